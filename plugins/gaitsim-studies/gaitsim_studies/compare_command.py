"""`gaitsim compare`."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING

from gaitsim.plugin import GaitsimError, Names, PlotFormat, option
from gaitsim.plugin.commands import (
    DASK,
    GENERATIONS,
    INTERRUPTED,
    JSON,
    POPULATION,
    SET,
    WORKERS,
    Action,
    argument,
)

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Executor, Experiment
    from gaitsim_studies.comparison import Findings, Sample


class CompareExperiments(Action):
    """Compare experiments statistically, with the same number of evaluations for each repeat.

    Each repeat evolves an experiment from a different random population, and gets the same number
    of evaluations whatever its search and population size. The order of the experiments does not
    affect the results. The command writes a report in Markdown, figures, tables of all repeats and
    of the ECDF, and all numbers as JSON.

    Ctrl-C stops the comparison and keeps finished repeats; the same command continues it.

    [bold]Examples[/bold]

    gaitsim compare millipede-random millipede-double-mutation

    gaitsim compare spider spider-genetic --evaluations 9000 --targets 1.5,2,2.5
    """

    not_in_forms = (*Action.not_in_forms, "set_", "dask")

    experiments: Names = argument(
        "two or more presets, TOML files or robot files",
        "NAME|FILE",
        allowed="names separated by spaces",
        completion="preset_names",
        shown=True,
    )
    repeats: int = option(30, "number of repeats of each experiment", ge=2, le=100_000)
    evaluations: int | None = option(
        None,
        "evaluations per repeat",
        ge=1,
        unset="the smallest number that any of the experiments plans",
    )
    targets: str | None = option(
        None,
        "target scores, such as 1.5,2,2.5, for the ECDF (the share of targets reached by each "
        "number of evaluations) and for the expected running times (the mean number of evaluations "
        "to reach a target)",
        unset="51 equally spaced scores for the ECDF, and the quartiles of the scores of all "
        "repeats for the running times",
        placeholder="SCORE,…",
    )
    generations: int | None = GENERATIONS
    population: int | None = POPULATION
    set_: Names | None = SET
    workers: int | None = WORKERS
    dask: str | None = DASK
    out: Path | None = option(
        None,
        "folder of the report",
        unset="a folder in comparisons/ named after the experiments",
        placeholder="FOLDER",
    )
    format: PlotFormat = option("png", "format of the figures")
    json_lines: bool = JSON

    def load(self) -> tuple[Sequence[float], int, dict[str, Experiment]]:
        """Check the options; return the targets, the evaluations per repeat, and the experiments.

        Raises:
            GaitsimError: an option or an experiment has problems.
        """
        from gaitsim.plugin.runs import parse_assignments
        from gaitsim_studies.comparison import check_request, equal_budgets, load_experiments

        aims = check_request(self.targets, self.evaluations, self.generations)
        short = {"evolution.generations": self.generations, "evolution.population": self.population}
        given = {key: value for key, value in short.items() if value is not None}
        loaded = load_experiments(self.experiments, {**given, **parse_assignments(self.set_ or ())})
        return aims, *equal_budgets(loaded, self.evaluations)

    def free_folder(self) -> Path:
        """Check the comparison, and return a folder for it: new, or that of a stopped one.

        Raises:
            GaitsimError: an option or an experiment has problems.
        """
        from gaitsim.plugin.runs import free_name
        from gaitsim_studies.comparison import experiment_texts

        loaded = self.load()[2]
        wanted = _folder_of(loaded)
        return _stopped(wanted, experiment_texts(loaded), self.repeats) or free_name(wanted)

    def do(self) -> None:
        """Evolve the repeats, and write the report."""
        from gaitsim.plugin.commands import cluster, notice, print_json
        from gaitsim.plugin.runs import check_links, command, create_folder
        from gaitsim_studies.comparison import experiment_texts, warning

        aims, budget, loaded = self.load()
        if problem := warning(loaded.values()):
            notice(f"Warning: {problem}")
        texts, wanted = experiment_texts(loaded), self.out or _folder_of(loaded)
        with cluster(self.dask, self.workers) as executor:
            folder = _stopped(wanted, texts, self.repeats)
            if folder is None:
                folder = create_folder(wanted, texts, [_repeats_folder(self.repeats)])
            check_links(folder)
            shown = f"./{folder}" if str(folder).startswith("-") else folder
            files = (f"{shown}/{text}" for text in texts)
            again = command("compare", *files, *self._options(), "--evaluations", budget)
            findings = self._finish(folder, loaded, aims, budget, again, executor)
        if self.json_lines:
            print_json({"folder": str(folder), **_values(findings, again)})
        else:
            _print(folder, findings, again)

    def _finish(
        self,
        folder: Path,
        loaded: dict[str, Experiment],
        aims: Sequence[float],
        budget: int,
        again: str,
        executor: Executor | None,
    ) -> Findings:
        """Evolve the missing repeats, and write the report into the folder.

        A folder without a finished repeat is removed if this fails.
        """
        from gaitsim.plugin.commands import interruptible, notice
        from gaitsim.plugin.runs import RunLock
        from gaitsim_studies.comparison import analyse

        kept = folder / _repeats_folder(self.repeats)
        lock = RunLock(folder)  # marks the folder as in use
        try:
            with interruptible():
                samples = self._samples(loaded, kept, executor)
                try:
                    findings = analyse(samples, budget, aims)
                except GaitsimError:  # no repeat has a score, so nothing is worth keeping
                    rmtree(kept)
                    raise
                _write(folder, findings, again, self.format)
        except BaseException as error:
            saved = any(kept.glob("*.npy"))
            if not saved:
                rmtree(folder, ignore_errors=True)
            if isinstance(error, KeyboardInterrupt):
                how = (
                    "finished repeats are saved. Continue" if saved else "nothing is saved. Repeat"
                )
                notice(f"Stopped; {how} with: {self._command()}")
                sys.exit(INTERRUPTED)
            if isinstance(error, GaitsimError) and saved:
                error.add_remedy(f"finished repeats are saved; continue with: {self._command()}")
            raise
        finally:
            lock.release()
        rmtree(kept, ignore_errors=True)
        return findings

    def _options(self) -> list[object]:
        """Return the options that a comparison of the written experiments needs."""
        options: list[object] = ["--repeats", self.repeats]
        options += [f"--targets={self.targets}"] if self.targets is not None else []
        return options + (["--format", self.format] if self.format != "png" else [])

    def _command(self) -> str:
        """Return the command line of this comparison."""
        from gaitsim.plugin.runs import command

        plans: dict[str, object] = {
            "--evaluations": self.evaluations,
            "--generations": self.generations,
            "--population": self.population,
            "--out": self.out,
        }
        return command(
            "compare",
            *self.experiments,
            *self._options(),
            *(word for flag, value in plans.items() if value is not None for word in (flag, value)),
            *(word for text in self.set_ or () for word in ("--set", text)),
        )

    def _samples(
        self, loaded: dict[str, Experiment], kept: Path, executor: Executor | None
    ) -> dict[str, Sample]:
        """Evolve the missing repeats of each experiment, with a progress bar or a log."""
        import numpy as np

        from gaitsim.plugin.commands import Progress, warn_of_cluster as warn
        from gaitsim.plugin.runs import sweep
        from gaitsim_studies.comparison import Sample
        from gaitsim_studies.running import complete_repeats, read_repeats

        sweep(kept)
        found = {}
        for place, (label, experiment) in enumerate(loaded.items(), 1):
            best = read_repeats(kept, place, experiment, self.repeats)
            found[label] = Sample(experiment, best)
            missing = int(np.isnan(best[:, 0]).sum())
            if not missing:
                continue
            some = f"{missing} of " if missing < self.repeats else ""
            total = experiment.evolution.generations
            log = f"{label}: {some}{self.repeats} repeats of {total:,} generations"
            log = "" if self.json_lines else log
            with Progress(label, "generations", missing * total, log=log) as progress:
                complete_repeats(
                    kept,
                    place,
                    experiment,
                    best,
                    workers=self.workers,
                    on_generation=progress.advance,
                    on_warning=warn,
                    cluster=executor,
                )
        return found


def _repeats_folder(repeats: int) -> str:
    """Return the name of the folder of finished repeats, which exists until the report does."""
    return f"repeats-{repeats}"


def _stopped(wanted: Path, texts: Mapping[str, str], repeats: int) -> Path | None:
    """Return the folder of a stopped comparison of the same experiments; None if there is none."""
    from gaitsim.plugin import is_folder, read_regular
    from gaitsim.plugin.runs import is_locked, numbered_names
    from gaitsim_studies.comparison_report import REPORT

    def is_same(folder: Path) -> bool:
        try:
            return (
                is_folder(folder / _repeats_folder(repeats))
                and not os.path.lexists(folder / REPORT)
                and not os.path.lexists(folder / f"{len(texts) + 1}.toml")
                and all(
                    read_regular(folder / name, len(data := text.encode())) == data
                    for name, text in texts.items()
                )
                and not is_locked(folder)
            )
        except OSError:
            return False

    return next(filter(is_same, takewhile(os.path.lexists, numbered_names(wanted))), None)


def _folder_of(experiments: Mapping[str, Experiment]) -> Path:
    """Return the default folder of a comparison."""
    name = "-against-".join(one.name for one in experiments.values())
    return Path("comparisons") / name[:150]


def _values(findings: Findings, again: str) -> dict[str, object]:
    from gaitsim_studies.comparison_report import to_dict

    return {**to_dict(findings), "command": again}


def _write(folder: Path, findings: Findings, again: str, format: PlotFormat) -> None:
    """Write the files of a comparison; the report is last, as it marks the end."""
    from gaitsim.plugin.commands import as_json, report_files
    from gaitsim.plugin.pictures import LIGHT, save
    from gaitsim.plugin.runs import write_bytes
    from gaitsim_studies.comparison_report import CURVES, REPORT, TABLE, VALUES, write_comparison
    from gaitsim_studies.plots import FIGURES

    figures = [folder / f"{kind}.{format}" for kind in FIGURES]
    for path, draw in zip(figures, FIGURES.values(), strict=True):
        save(draw(findings, LIGHT), path)
    write_bytes(folder / VALUES, (as_json(_values(findings, again)) + "\n").encode())
    write_comparison(folder, findings, again, figures)
    report_files(*(folder / name for name in (REPORT, TABLE, CURVES, VALUES)), *figures)


def _print(folder: Path, findings: Findings, again: str) -> None:
    from gaitsim.plugin.commands import output, print_table
    from gaitsim_studies.comparison_report import REPORT, methods, remarks, tables

    console = output()
    for heading, text in remarks(findings):
        console.print(f"\n{heading} {text}", style="yellow", markup=False)
    for title, columns, rows, note in tables(findings):
        console.print(f"\n{title}", style="bold")
        print_table(columns, rows)
        if note:
            console.print(note, style="dim")
    console.print(f"\n{methods(findings)}\n", style="dim")
    console.print(f"Report: {folder / REPORT}")
    console.print(f"Repeat: {again}", soft_wrap=True)

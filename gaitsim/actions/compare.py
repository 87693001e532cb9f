"""`gaitsim compare`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING

from gaitsim.actions.action import (
    DASK,
    GENERATIONS,
    JSON,
    POPULATION,
    SET,
    WORKERS,
    WORLD_SEED,
    Action,
    argument,
)
from gaitsim.choices import PlotFormat
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.evaluation import Executor
    from gaitsim.evaluation.worlds import Ranges
    from gaitsim.experiment import Experiment
    from gaitsim.gait.unseen import UnseenResults
    from gaitsim.individual import Individual
    from gaitsim.study.comparison import Findings, Sample
    from gaitsim.study.in_worlds import Ranking

VALUES = "comparison.json"


class CompareExperiments(Action):
    """Compare experiments statistically, with the same number of evaluations for each repeat.

    Each repeat evolves an experiment from a different random population, and gets the same number
    of evaluations whatever its search and population size. The order of the experiments does not
    affect the results. The command writes a report in Markdown, figures, tables of all repeats and
    of the ECDF, and all numbers as JSON.

    [bold]Examples[/bold]

    gaitsim compare millipede-random millipede-double-mutation

    gaitsim compare spider spider-genetic --evaluations 9000 --targets 1.5,2,2.5

    gaitsim compare runs/walker-four runs/walker-worlds --worlds 100
    """

    not_in_forms = (*Action.not_in_forms, "set_", "dask", "worlds", "world_seed")

    experiments: Names = argument(
        "two or more presets, TOML files or robot files; with --worlds, runs",
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
    worlds: int | None = option(
        None,
        "rank runs instead of experiments: evaluate the champion of each run in the same N "
        "randomly drawn worlds, and compare the means of the worst 10 % of the results",
        placeholder="N",
    )
    world_seed: int | None = WORLD_SEED
    json_lines: bool = JSON

    def load(self) -> tuple[Sequence[float], int, dict[str, Experiment]]:
        """Check the options; return the targets, the evaluations per repeat, and the experiments.

        Raises:
            GaitsimError: an option or an experiment has problems.
        """
        from gaitsim.experiment import parse_assignments
        from gaitsim.study.comparison import check_request, equal_budgets, load_experiments

        aims = check_request(self.targets, self.evaluations, self.generations)
        short = {"evolution.generations": self.generations, "evolution.population": self.population}
        given = {key: value for key, value in short.items() if value is not None}
        loaded = load_experiments(self.experiments, {**given, **parse_assignments(self.set_ or ())})
        return aims, *equal_budgets(loaded, self.evaluations)

    def free_folder(self) -> Path:
        """Check the comparison, and return a new folder for it.

        Raises:
            GaitsimError: an option or an experiment has problems.
        """
        from gaitsim.runs.files.folder import free_name

        return free_name(_folder_of(self.load()[2]))

    def do(self) -> None:
        """Evolve the repeats, and write the report."""
        from gaitsim.console.cluster import cluster
        from gaitsim.console.interrupts import all_or_nothing
        from gaitsim.console.printing import notice
        from gaitsim.console.unseen import check_worlds
        from gaitsim.runs.files.folder import command, create_folder
        from gaitsim.runs.lock import RunLock
        from gaitsim.study.comparison import analyse, warning

        check_worlds(self.worlds, self.world_seed)
        if self.worlds is not None:
            _rank_runs(self, self.worlds)
            return
        aims, budget, loaded = self.load()
        if problem := warning(loaded.values()):
            notice(f"Warning: {problem}")
        texts = {f"{place}.toml": one.to_toml() for place, one in enumerate(loaded.values(), 1)}
        options = ["--repeats", self.repeats]
        options += [f"--targets={self.targets}"] if self.targets is not None else []
        options += ["--format", self.format] if self.format != "png" else []
        plans: dict[str, object] = {
            "--evaluations": self.evaluations,
            "--generations": self.generations,
            "--population": self.population,
            "--out": self.out,
        }
        start_again = command(
            "compare",
            *self.experiments,
            *options,
            *(word for flag, value in plans.items() if value is not None for word in (flag, value)),
            *(word for text in self.set_ or () for word in ("--set", text)),
        )
        with cluster(self.dask, self.workers) as executor:
            folder = create_folder(self.out or _folder_of(loaded), texts)
            lock = RunLock(folder)  # marks the folder as in use
            with all_or_nothing(
                f"Start over: {start_again} (unlike this command, gaitsim study keeps finished "
                "work)"
            ):
                try:
                    samples = self._samples(loaded, executor)
                    findings = analyse(samples, budget, aims)
                except BaseException:
                    rmtree(folder, ignore_errors=True)
                    raise
                finally:
                    lock.release()
        shown = f"./{folder}" if str(folder).startswith("-") else folder
        files = (f"{shown}/{text}" for text in texts)
        again = command("compare", *files, *options, "--evaluations", budget)
        _report(folder, findings, again, self.format, json=self.json_lines)

    def _samples(
        self, loaded: dict[str, Experiment], executor: Executor | None
    ) -> dict[str, Sample]:
        """Repeat each experiment, with a progress bar or a log."""
        from gaitsim.console.cluster import warn
        from gaitsim.console.progress_bar import Progress
        from gaitsim.study.comparison import Sample
        from gaitsim.study.running import repeat_experiment

        found = {}
        for label, experiment in loaded.items():
            total = experiment.evolution.generations
            log = f"{label}: {self.repeats} repeats of {total:,} generations"
            log = "" if self.json_lines else log
            with Progress(label, "generations", total, log=log) as progress:
                best = repeat_experiment(
                    experiment,
                    self.repeats,
                    workers=self.workers,
                    on_generation=progress.advance,
                    on_warning=warn,
                    cluster=executor,
                )
                found[label] = Sample(experiment, best)
        return found


def _folder_of(experiments: Mapping[str, Experiment]) -> Path:
    """Return the default folder of a comparison."""
    name = "-against-".join(one.name for one in experiments.values())
    return Path("comparisons") / name[:150]


def _report(
    folder: Path, findings: Findings, again: str, format: PlotFormat, *, json: bool
) -> None:
    """Write the files of a comparison, and print it."""
    from gaitsim.console.printing import as_json, print_json, report_files
    from gaitsim.render.plots.comparison import FIGURES
    from gaitsim.render.plots.style import LIGHT, save
    from gaitsim.runs.files.atomic import write_bytes
    from gaitsim.study.comparison_report import CURVES, REPORT, TABLE, to_dict, write_comparison

    figures = [folder / f"{kind}.{format}" for kind in FIGURES]
    for path, draw in zip(figures, FIGURES.values(), strict=True):
        save(draw(findings, LIGHT), path)
    write_comparison(folder, findings, again, figures)
    values = {**to_dict(findings), "command": again}
    write_bytes(folder / VALUES, (as_json(values) + "\n").encode())
    report_files(*(folder / name for name in (REPORT, TABLE, CURVES, VALUES)), *figures)
    if json:
        print_json({"folder": str(folder), **values})
    else:
        _print(folder, findings, again)


def _print(folder: Path, findings: Findings, again: str) -> None:
    from gaitsim.console.printing import output, print_table
    from gaitsim.study.comparison_report import REPORT, methods, remarks, tables

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


def _rank_runs(action: CompareExperiments, number: int) -> None:
    """Evaluate the champions of runs in the same unseen worlds, and print their ranking."""
    from gaitsim.console.printing import print_json
    from gaitsim.console.unseen import evaluate_with_progress
    from gaitsim.runs.files.folder import find_run
    from gaitsim.study.in_worlds import rank_in_worlds

    evolving = "evaluations", "targets", "generations", "population", "set_", "dask", "out"
    if given := action.flags_of(*evolving):
        raise GaitsimError(
            f"--worlds ranks existing runs, and cannot be combined with {' and '.join(given)}",
            allowed="--world-seed, --workers and --json",
        )

    def evaluate(label: str, champion: Individual, ranges: Ranges) -> UnseenResults:
        return evaluate_with_progress(
            champion,
            number,
            action.world_seed,
            workers=action.workers,
            ranges=ranges,
            what=label,
        )

    paths = [find_run(one) for one in action.experiments]
    found = rank_in_worlds(paths, number, seed=action.world_seed or 0, evaluate=evaluate)
    if action.json_lines:
        print_json(found.to_dict())
    else:
        _print_ranking(found, number)


def _print_ranking(found: Ranking, number: int) -> None:
    from gaitsim.console.printing import notice, output, print_table
    from gaitsim.render.terminal.explanation import (
        format_or_dash,
        format_percent,
        format_spans,
        format_strongest,
    )
    from gaitsim.study.in_worlds import LEAST_WORLDS
    from gaitsim.study.statistics import CONFIDENCE

    def spread(low: float, high: float) -> str:
        return "–" if math.isnan(low) else f"{low:z.3f} to {high:z.3f}".replace("-", "−")

    console = output()
    first = found.runs[0].unseen
    unit = f"{first.measure} {first.unit}".rstrip()
    interval = f"{100 * CONFIDENCE:.0f} % CI"
    for note in found.notes:
        notice(note)
    title = f"Champions in the same {number:,} unseen worlds, {unit}"
    console.print(title, style="bold")
    rows = [
        (
            one.label,
            format_or_dash(one.unseen.worst_tenth, 3),
            spread(one.low, one.high),
            format_or_dash(one.unseen.median, 3),
            format_or_dash(one.unseen.nominal.result, 3),
            format_percent(one.unseen.kept(one.unseen.worst_tenth)),
            f"{one.unseen.falls:,}",
            format_strongest(one.unseen),
        )
        for one in found.runs
    ]
    numbers = "worst tenth", interval, "median", "nominal", "of nominal", "falls"
    print_table(["run", *numbers, "worst condition"], rows, numbers)
    console.print("\nDifferences of the worst tenths", style="bold")
    pairs = [
        (
            f"{pair.first} − {pair.second}",
            format_or_dash(pair.difference, 3),
            spread(pair.low, pair.high),
            {True: "yes", False: "no", None: "–"}[pair.differs],
        )
        for pair in found.pairs
    ]
    print_table(["pair", "difference", interval, "differs"], pairs, ("difference", interval))
    intervals = (
        "The intervals come from resampling the worlds, equally for both "
        "runs of a pair; they describe these champions,\nnot repeats of the runs."
    )
    if number < LEAST_WORLDS:
        intervals = f"Fewer than {LEAST_WORLDS} worlds are too few for confidence intervals."
    console.print(
        "\nWorst tenth: the mean of the worst tenth of the results. Of nominal: that mean divided "
        f"by the nominal result.\n{intervals}\n"
        f"Worlds: seed {first.seed}; {', '.join(format_spans(first))}.",
        style="dim",
        soft_wrap=True,
    )

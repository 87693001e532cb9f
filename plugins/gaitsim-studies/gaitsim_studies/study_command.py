"""`gaitsim study`."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.plugin import GaitsimError, RunError, option
from gaitsim.plugin.commands import DASK, INTERRUPTED, JSON, WORKERS, Action, argument

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Executor
    from gaitsim_studies.confirmation import ReachedTarget
    from gaitsim_studies.file import Cell, Study
    from gaitsim_studies.running import Best


class RunStudy(Action):
    """Evolve every combination of chosen options, and tabulate their scores.

    The file of the study lists the options and their values; each combination is a cell. If the
    file sets a target score, gaitsim also evolves new repeats of the cells that reach the target
    with the fewest evaluations, to confirm that they reach it ('confirm' in the file).

    Ctrl-C stops the study and keeps finished cells; to continue, pass the folder of the study.

    [bold]Examples[/bold]

    gaitsim study millipede-operators

    gaitsim study my-study.toml --out studies/mine

    gaitsim study studies/mine

    gaitsim study studies/mine --json

    gaitsim study millipede-operators --dask tcp://host:8786
    """

    not_in_forms = (*Action.not_in_forms, "dask")

    study: str = argument(
        "name of a study, path of a TOML file, or folder of a study to continue",
        "NAME|FILE|FOLDER",
        completion="study_names",
        shown=True,
    )
    workers: int | None = WORKERS
    dask: str | None = DASK
    out: Path | None = option(
        None,
        "folder of the study",
        unset="a folder in studies/ named after the study",
        placeholder="FOLDER",
    )
    json_lines: bool = JSON

    def free_folder(self) -> Path:
        """Check the study, and return a new folder for it.

        Raises:
            GaitsimError: the study has problems.
        """
        from gaitsim.plugin.runs import free_name
        from gaitsim_studies.file import cells, read_study

        study, _ = read_study(self.study)
        cells(study, source=self.study)
        return free_name(Path("studies") / study.name)

    def do(self) -> None:
        """Run the cells, and write the results."""
        from dataclasses import asdict

        from gaitsim.plugin.commands import cluster, interruptible, notice, print_json
        from gaitsim.plugin.runs import RunLock, check_links, command, create_folder
        from gaitsim_studies.file import STUDY, cells, experiment_files, read_study
        from gaitsim_studies.plots import plot_surfaces
        from gaitsim_studies.results import write_results

        resumed = os.path.lexists(Path(self.study) / STUDY)
        if resumed:
            check_links(Path(self.study))
        source = str(Path(self.study) / STUDY) if resumed else self.study
        study, text = read_study(source)
        all_cells = cells(study, Path(self.study) if resumed else None, source)
        folder = Path(self.study) if resumed else self.out or Path("studies") / study.name
        with cluster(self.dask, self.workers) as executor:
            if not resumed:
                folder = create_folder(folder, {STUDY: text, **experiment_files(study)})
            lock, again = RunLock(folder), command("study", folder)
            try:
                try:
                    with interruptible():
                        found = _run(folder, study, all_cells, self.workers, executor)
                        reached = _confirm(folder, study, found, self.workers, executor)
                except KeyboardInterrupt:
                    notice(f"Stopped; finished cells are saved. Continue with: {again}")
                    sys.exit(INTERRUPTED)
                except GaitsimError as error:
                    error.add_remedy(f"run the remaining cells: {again}")
                    raise
                write_results(folder, study, found, reached)
                plot_surfaces(folder, study, found)
            finally:
                lock.release()
        if self.json_lines:
            print_json({"folder": str(folder), "reached": [asdict(one) for one in reached]})
            return
        _print(folder, study, reached)


def _print(folder: Path, study: Study, reached: Sequence[ReachedTarget]) -> None:
    from gaitsim.plugin.commands import output, print_table, report_files
    from gaitsim_studies.results import TABLE, rule, summary, title

    console = output()
    if study.target is not None:
        console.print(f"\n{title(study)}", style="bold")
        print_table(*summary(study, reached))
        console.print(f"Rule: {rule(study)}.", style="dim")
    report_files(folder / TABLE)
    console.print(f"\nTable: {folder / TABLE}")


def _run(
    folder: Path,
    study: Study,
    all_cells: Sequence[Cell],
    workers: int | None,
    executor: Executor | None,
) -> list[tuple[Cell, Best]]:
    """Run the missing cells with a progress bar, and return the results of all cells."""
    from gaitsim.plugin.commands import Progress, warn_of_cluster as warn
    from gaitsim_studies.running import results, run_cells

    _, missing = results(folder, study, all_cells)
    done = len(all_cells) - len(missing)
    log = f"study {folder}: {len(missing)} of {len(all_cells)} cells to run"
    with Progress(f"study {folder}", "cells", len(all_cells), done, log=log) as progress:
        for _ in run_cells(folder, study, missing, workers, warn, executor):
            progress.advance()
    found, missing = results(folder, study, all_cells)
    if missing:
        raise RunError(f"cell {missing[0].index} of {folder} is missing or damaged")
    return found


def _confirm(
    folder: Path,
    study: Study,
    found: Sequence[tuple[Cell, Best]],
    workers: int | None,
    executor: Executor | None,
) -> list[ReachedTarget]:
    """Run fresh repeats with a progress bar, and return the cells that reach the target."""
    from gaitsim.plugin.commands import Progress, warn_of_cluster as warn
    from gaitsim_studies.confirmation import confirm

    if study.target is None:
        return []
    log = f"study {folder}: {study.fresh.repeats:,} fresh repeats of each candidate cell"
    with Progress(f"confirm {folder}", "sets of repeats", log=log) as progress:

        def on_sets(done: int, total: int) -> None:
            progress.expect(total)
            progress.reach(done)

        return confirm(
            folder, study, found, workers, on_sets=on_sets, on_warning=warn, cluster=executor
        )

"""`gaitsim study`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitsim.cli.run import Dask, Workers

if TYPE_CHECKING:
    from gaitsim.evaluation import Executor
    from gaitsim.study.file import Cell, Study
    from gaitsim.study.running import Best


def study(
    study: Annotated[
        str,
        typer.Argument(
            help="A ready study, the path of a TOML file, or the folder of a study to go on with.",
            metavar="NAME|FILE|FOLDER",
        ),
    ],
    workers: Workers = None,
    dask: Dask = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the study. Default: studies/<name>.")
    ] = None,
) -> None:
    """Sweep options over all cores; results in one table, with surfaces and a summary.

    Ctrl-C stops; the finished cells are kept, and the folder's name goes on with the rest.

    [bold]Examples[/bold]

    gaitsim study millipede-operators

    gaitsim study my-study.toml --out studies/mine

    gaitsim study studies/mine

    gaitsim study millipede-operators --dask tcp://host:8786
    """
    import sys

    from gaitsim.cli.cluster import cluster
    from gaitsim.cli.console import notice, output, wrote
    from gaitsim.runs.files.folder import command, create_folder
    from gaitsim.runs.files.lock import RunLock
    from gaitsim.study.file import cells, read_study, resolved

    begun = (Path(study) / STUDY).is_file()
    source = str(Path(study) / STUDY) if begun else study
    read, text = read_study(source)
    every = cells(read, Path(study) if begun else None, source)
    folder = Path(study) if begun else out or Path("studies") / read.name
    with cluster(dask, workers) as executor:
        if not begun:
            folder = create_folder(folder, {STUDY: text, **resolved(read)})
        lock = RunLock(folder)
        try:
            if not _run(folder, read, every, workers, executor):
                notice(f"Stopped; finished cells are kept. Go on with: {command('study', folder)}")
                sys.exit(130)
            results = _collect(folder, read, every)
            _write(folder, read, results)
        finally:
            lock.release()
    _summarise(folder, read, results)
    wrote(folder / TABLE)
    output().print(f"\nTable: {folder / TABLE}", markup=False)


STUDY, TABLE, REPORT = "study.toml", "results.csv", "report.md"


def _run(
    folder: Path,
    study: "Study",
    every: "list[Cell]",
    workers: int | None,
    cluster: "Executor | None",
) -> bool:
    """Run what is not finished, with a progress bar; False when the user stopped it."""
    from gaitsim.cli.cluster import warn
    from gaitsim.cli.interrupts import interruptible
    from gaitsim.cli.progress_bar import Progress
    from gaitsim.errors import GaitsimError
    from gaitsim.runs.files.folder import command
    from gaitsim.study.running import finished, run_cells

    missing = [
        cell for cell in every if finished(folder, cell, study.repeats, study.record_every) is None
    ]
    total, done = len(every), len(every) - len(missing)
    log = f"study {folder}: {len(missing)} of {total} cells to run"
    try:
        with (
            interruptible(),
            Progress(f"study {folder}", "cells", total, done, log=log) as progress,
        ):
            for _ in run_cells(
                folder, missing, study.repeats, study.record_every, workers, warn, cluster
            ):
                progress.advance()
    except KeyboardInterrupt:
        return False
    except GaitsimError as error:
        error.then(f"go on with the cells that are left: {command('study', folder)}")
        raise
    return True


def _collect(folder: Path, study: "Study", every: "list[Cell]") -> "list[tuple[Cell, Best]]":
    from gaitsim.errors import RunError
    from gaitsim.study.running import finished

    results = []
    for cell in every:
        best = finished(folder, cell, study.repeats, study.record_every)
        if best is None:
            raise RunError(f"cell {cell.index} of {folder} is gone or damaged")
        results.append((cell, best))
    return results


def _write(folder: Path, study: "Study", results: "list[tuple[Cell, Best]]") -> None:
    from gaitsim.render.plots.surfaces import plot_surface, surface_axis
    from gaitsim.runs.files.atomic import write_bytes
    from gaitsim.study.results import table

    for old in (folder / REPORT, *folder.glob("surface-*.png")):
        old.unlink(missing_ok=True)
    write_bytes(folder / TABLE, table(study, results).encode())
    if surface_axis(study):
        for place, experiment in enumerate(study.experiments, 1):
            file = folder / f"surface-{place}-{Path(experiment).stem}.png"
            plot_surface(study, experiment, results, file)


def _summarise(folder: Path, study: "Study", results: "list[tuple[Cell, Best]]") -> None:
    """Print and write down what first reached the target, published cells beside it."""
    from gaitsim.cli.console import number, output, table
    from gaitsim.runs.files.atomic import write_bytes
    from gaitsim.study.results import POPULATION, RULE, first_reached, markdown

    if study.target is None:
        return
    others = [axis for axis in study.axes if axis != POPULATION]
    columns = ["experiment", "population / generations", *others, "mean"]
    if study.published:
        columns.append("published")
    rows = []
    for found in first_reached(study, results):
        if found.population is None:
            blanks = [""] * len(others)
            row = [found.experiment, "never", *blanks, f"at most {number(found.mean)}"]
        else:
            row = [
                found.experiment,
                f"{found.population} / {found.generations}",
                *(str(found.point[axis]) for axis in others),
                number(found.mean),
            ]
        if study.published:
            cell = study.published.get(found.experiment)
            row.append(f"{cell.population} / {cell.generations}" if cell else "never")
        rows.append(row)
    title = f"Cheapest population and generations that reach {study.target:g}"
    lines = [f"# {study.name}", "", study.description, "", f"## {title}", ""]
    lines += [*markdown(columns, rows), "", f"Rule: {RULE}. Means of {study.repeats} repeats.", ""]
    write_bytes(folder / REPORT, "\n".join(lines).encode())
    made = table(*columns)
    for row in rows:
        made.add_row(*row)
    console = output()
    console.print(f"\n{title}", style="bold")
    console.print(made, markup=False)
    console.print(RULE, style="dim")

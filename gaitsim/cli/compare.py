"""`gaitsim compare`."""

from math import isfinite
from pathlib import Path
from shutil import rmtree
from typing import Annotated

import typer

from gaitsim.cli.cluster import cluster, warn
from gaitsim.cli.console import notice, output, print_json, print_table, wrote
from gaitsim.cli.interrupts import all_or_nothing
from gaitsim.cli.options import Dask, Generations, Json, Population, Set, Workers
from gaitsim.cli.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Executor
from gaitsim.experiment import Experiment, parse_assignments
from gaitsim.render.plots.convergence import plot_convergence
from gaitsim.runs.files.folder import command, create_folder
from gaitsim.runs.files.lock import RunLock
from gaitsim.study.comparison import (
    FIGURE,
    REPORT,
    TABLE,
    Findings,
    Sample,
    analyse,
    load_experiments,
    methods,
    tables,
    to_dict,
    warning,
    write_comparison,
)
from gaitsim.study.running import repeat_experiment


def compare(
    experiments: Annotated[
        list[str], typer.Argument(help="Two or more presets or TOML files.", metavar="NAME|FILE")
    ],
    repeats: Annotated[int, typer.Option(min=2, max=100_000, help="Repeats of each.")] = 30,
    target: Annotated[
        float | None,
        typer.Option(help="Score that counts as success. Default: the lowest of the medians."),
    ] = None,
    generations: Generations = None,
    population: Population = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the report. Default: comparisons/<names>.")
    ] = None,
    json: Json = False,
) -> None:
    """Compare experiments over repeats, with statistics for a publication.

    Writes a report in Markdown, a figure, and every repeat as a table.

    [bold]Examples[/bold]

    gaitsim compare millipede-random millipede-double-mutation

    gaitsim compare spider mine.toml --repeats 20 --generations 200 --target 2.0
    """
    if target is not None and not isfinite(target):
        raise GaitsimError(f"{target} is not a score", where="--target", allowed="a number")
    short = {"evolution.generations": generations, "evolution.population": population}
    given = {key: value for key, value in short.items() if value is not None}
    loaded = load_experiments(experiments, {**given, **parse_assignments(set_ or ())})
    if said := warning(loaded.values()):
        notice(f"Warning: {said}")
    texts = {f"{place}.toml": one.to_toml() for place, one in enumerate(loaded.values(), 1)}
    name = "-against-".join(one.name for one in loaded.values())[:150]
    with cluster(dask, workers) as executor:
        folder = create_folder(out or Path("comparisons") / name, texts)
        lock = RunLock(folder)  # shows that it is being worked on
        with all_or_nothing():
            try:
                findings = analyse(_samples(loaded, repeats, workers, executor, quiet=json), target)
            except BaseException:
                rmtree(folder, ignore_errors=True)
                raise
            finally:
                lock.release()
    shown = f"./{folder}" if str(folder).startswith("-") else folder
    options = ["--repeats", repeats, *(["--target", target] if target is not None else [])]
    again = command("compare", *(f"{shown}/{text}" for text in texts), *options)
    plot_convergence(findings.samples, folder / FIGURE, findings.warning)
    write_comparison(folder, findings, again)
    wrote(*(folder / name for name in (REPORT, TABLE, FIGURE)))
    if json:
        print_json({"folder": str(folder), **to_dict(findings), "command": again})
    else:
        _print(folder, findings, again)


def _samples(
    loaded: dict[str, Experiment],
    repeats: int,
    workers: int | None,
    cluster: Executor | None,
    quiet: bool,
) -> dict[str, Sample]:
    """Repeat each experiment, with a progress bar or a line now and then."""
    found = {}
    for label, experiment in loaded.items():
        total = experiment.evolution.generations
        log = "" if quiet else f"{label}: {repeats} repeats of {total} generations"
        with Progress(label, "generations", total, log=log) as progress:
            best = repeat_experiment(
                experiment,
                repeats,
                workers=workers,
                on_generation=progress.advance,
                on_warning=warn,
                cluster=cluster,
            )
            found[label] = Sample(experiment, best)
    return found


def _print(folder: Path, findings: Findings, again: str) -> None:
    console = output()
    for title, columns, rows in tables(findings):
        console.print(f"\n{title}", style="bold")
        print_table(columns, rows)
    console.print(f"\n{methods(findings)}\n", style="dim")
    console.print(f"Report: {folder / REPORT}")
    console.print(f"Again:  {again}", soft_wrap=True)

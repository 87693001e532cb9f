"""`gaitsim compare`."""

from __future__ import annotations

from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING, Annotated

import typer

from gaitsim.choices import PlotFormat
from gaitsim.cli.completion import preset_names
from gaitsim.cli.options import Dask, Generations, Json, Population, Set, Workers, WorldSeed
from gaitsim.console.interrupts import all_or_nothing
from gaitsim.console.printing import as_json, notice, output, print_json, print_table, report_files
from gaitsim.console.progress_bar import Progress
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import command, create_folder

if TYPE_CHECKING:
    from gaitsim.evaluation import Executor
    from gaitsim.experiment import Experiment
    from gaitsim.study.comparison import Findings, Sample


VALUES = "comparison.json"


def compare(
    experiments: Annotated[
        list[str],
        typer.Argument(
            help="Two or more presets, TOML files or robot files; with --worlds, runs.",
            metavar="NAME|FILE",
            autocompletion=preset_names,
        ),
    ],
    repeats: Annotated[
        int, typer.Option(min=2, max=100_000, help="Number of repeats of each experiment.")
    ] = 30,
    evaluations: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Evaluations per repeat. Default: the smallest number that any of the "
            "experiments plans.",
        ),
    ] = None,
    targets: Annotated[
        str | None,
        typer.Option(
            metavar="SCORE,…",
            help="Target scores, such as 1.5,2,2.5, for the ECDF (the share of targets reached "
            "by each number of evaluations) and for the expected running times (the mean number "
            "of evaluations to reach a target). Default: 51 equally spaced scores for the ECDF, "
            "and the quartiles of the scores of all repeats for the running times.",
        ),
    ] = None,
    generations: Generations = None,
    population: Population = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder of the report. Default: a folder in comparisons/ named after the "
            "experiments.",
        ),
    ] = None,
    format: Annotated[PlotFormat, typer.Option(help="Format of the figures.")] = "png",
    worlds: Annotated[
        int | None,
        typer.Option(
            "--worlds",
            metavar="N",
            help="Rank runs instead of experiments: evaluate the champion of each run in the same "
            "N randomly drawn worlds, and compare the means of the worst 10 % of the results.",
        ),
    ] = None,
    world_seed: WorldSeed = None,
    json: Json = False,
) -> None:
    """Compare experiments statistically, with the same number of evaluations for each repeat.

    Each repeat evolves an experiment from a different random population, and gets the same number
    of evaluations whatever its search and population size. The order of the experiments does not
    affect the results. The command writes a report in Markdown, figures, tables of all repeats and
    of the ECDF, and all numbers as JSON.

    [bold]Examples[/bold]

    gaitsim compare millipede-random millipede-double-mutation

    gaitsim compare spider spider-cma --evaluations 9000 --targets 1.5,2,2.5

    gaitsim compare runs/walker-four runs/walker-worlds --worlds 100
    """
    from gaitsim.cli.cluster import cluster
    from gaitsim.cli.compare_worlds import rank_runs
    from gaitsim.console.unseen import check_worlds
    from gaitsim.experiment import parse_assignments
    from gaitsim.runs.lock import RunLock
    from gaitsim.study.comparison import (
        analyse,
        check_request,
        equal_budgets,
        load_experiments,
        warning,
    )

    check_worlds(worlds, world_seed)
    if worlds is not None:
        unused = {
            "--evaluations": evaluations,
            "--targets": targets,
            "--generations": generations,
            "--population": population,
            "--set": set_,
            "--dask": dask,
            "--out": out,
        }
        rank_runs(experiments, worlds, world_seed, workers, unused, json)
        return
    aims = check_request(targets, evaluations, generations)
    short = {"evolution.generations": generations, "evolution.population": population}
    given = {key: value for key, value in short.items() if value is not None}
    loaded = load_experiments(experiments, {**given, **parse_assignments(set_ or ())})
    budget, loaded = equal_budgets(loaded, evaluations)
    if problem := warning(loaded.values()):
        notice(f"Warning: {problem}")
    texts = {f"{place}.toml": one.to_toml() for place, one in enumerate(loaded.values(), 1)}
    name = "-against-".join(one.name for one in loaded.values())[:150]
    options = ["--repeats", repeats]
    options += [f"--targets={targets}"] if targets is not None else []
    options += ["--format", format] if format != "png" else []
    plans: dict[str, object] = {
        "--evaluations": evaluations,
        "--generations": generations,
        "--population": population,
        "--out": out,
    }
    start_again = command(
        "compare",
        *experiments,
        *options,
        *(word for flag, value in plans.items() if value is not None for word in (flag, value)),
        *(word for text in set_ or () for word in ("--set", text)),
    )
    with cluster(dask, workers) as executor:
        folder = create_folder(out or Path("comparisons") / name, texts)
        lock = RunLock(folder)  # marks the folder as in use
        with all_or_nothing(
            f"Start over: {start_again} (unlike this command, gaitsim study keeps finished work)"
        ):
            try:
                samples = _samples(loaded, repeats, workers, executor, quiet=json)
                findings = analyse(samples, budget, aims)
            except BaseException:
                rmtree(folder, ignore_errors=True)
                raise
            finally:
                lock.release()
    shown = f"./{folder}" if str(folder).startswith("-") else folder
    files = (f"{shown}/{text}" for text in texts)
    again = command("compare", *files, *options, "--evaluations", budget)
    _report(folder, findings, again, format, json=json)


def _samples(
    loaded: dict[str, Experiment],
    repeats: int,
    workers: int | None,
    executor: Executor | None,
    quiet: bool,
) -> dict[str, Sample]:
    """Repeat each experiment, with a progress bar or a log."""
    from gaitsim.cli.cluster import warn
    from gaitsim.study.comparison import Sample
    from gaitsim.study.running import repeat_experiment

    found = {}
    for label, experiment in loaded.items():
        total = experiment.evolution.generations
        log = "" if quiet else f"{label}: {repeats} repeats of {total:,} generations"
        with Progress(label, "generations", total, log=log) as progress:
            best = repeat_experiment(
                experiment,
                repeats,
                workers=workers,
                on_generation=progress.advance,
                on_warning=warn,
                cluster=executor,
            )
            found[label] = Sample(experiment, best)
    return found


def _report(
    folder: Path, findings: Findings, again: str, format: PlotFormat, *, json: bool
) -> None:
    """Write the files of a comparison, and print it."""
    from gaitsim.render.plots.comparison import FIGURES
    from gaitsim.render.plots.style import LIGHT, save
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

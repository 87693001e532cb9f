"""`gaitsim run`."""

from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.cluster import cluster
from gaitsim.cli.detaching import check_detachable, evolve_detached
from gaitsim.cli.evolving import evolve_run
from gaitsim.cli.options import (
    Dask,
    Detach,
    ExperimentName,
    Generations,
    Json,
    Population,
    Set,
    Workers,
)
from gaitsim.experiment import load_experiment, parse_assignments
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.start import check_start, kept_individual


def run(
    experiment: ExperimentName,
    generations: Generations = None,
    population: Population = None,
    seed: Annotated[int | None, typer.Option(help="Seed of all randomness.")] = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="FILE|RUN[@N]",
            help="Start from an individual: a champion's file, a run's champion, or the best of a "
            "run's generation N. The others are its mutations.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run. Default: runs/<name>.")
    ] = None,
    detach: Detach = False,
    json: Json = False,
) -> None:
    """Evolve a gait and keep the run on disk.

    Ctrl-C stops after the current generation, saves, and prints how to continue.

    [bold]Examples[/bold]

    gaitsim run spider

    gaitsim run spider --seed 3 --generations 200

    gaitsim run spider --set mutation.rate=0.1 --set fitness.yaw_weight=2

    gaitsim run my-spider.toml --out runs/mine --json > log.jsonl

    gaitsim run my_robot.urdf

    gaitsim run spider --from runs/spider --set fitness.yaw_weight=4

    gaitsim run spider --from spider@120

    gaitsim run spider --from runs/spider/champions/generation-000012.pickle

    gaitsim run spider --detach

    gaitsim run walker --dask tcp://host:8786
    """
    short = {
        "evolution.generations": generations,
        "evolution.population": population,
        "seed": seed,
    }
    given = {key: value for key, value in short.items() if value is not None}
    loaded = load_experiment(experiment, {**given, **parse_assignments(set_ or ())})
    start = None
    if from_ is not None:
        start = kept_individual(from_)
        check_start(loaded, start, f"--from {from_}")
    if detach:
        check_detachable(dask)
        evolve_detached(create_run(loaded, out, start), workers=workers, json=json)
        return
    with cluster(dask, workers) as executor:
        evolve_run(create_run(loaded, out, start), workers=workers, json=json, cluster=executor)

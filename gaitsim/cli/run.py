"""`gaitsim run`."""

from typing import Annotated

import typer

from gaitsim.cli.completion import preset_names
from gaitsim.cli.options import (
    Dask,
    Detach,
    From,
    Generations,
    Json,
    Population,
    RunFolder,
    Seed,
    Set,
    Workers,
)
from gaitsim.errors import GaitsimError


def run(
    experiment: Annotated[
        str | None,
        typer.Argument(
            help="Name of a preset, or path of a TOML file or a robot file such as URDF. "
            "Default: with --from CODE, the experiment of the code.",
            metavar="NAME|FILE",
            autocompletion=preset_names,
        ),
    ] = None,
    generations: Generations = None,
    population: Population = None,
    seed: Seed = None,
    set_: Set = None,
    workers: Workers = None,
    dask: Dask = None,
    from_: From = None,
    out: RunFolder = None,
    detach: Detach = False,
    json: Json = False,
) -> None:
    """Evolve a gait, and save the run in a folder.

    Ctrl-C stops after the current generation, saves the run, and prints how to continue it.

    [bold]Examples[/bold]

    gaitsim run spider

    gaitsim run spider --seed 3 --generations 200

    gaitsim run spider --set mutation.rate=0.1 --set fitness.yaw_weight=2

    gaitsim run my-spider.toml --out runs/mine --json > log.jsonl

    gaitsim run my_robot.urdf

    gaitsim run spider --from runs/spider --set fitness.yaw_weight=4

    gaitsim run spider --from spider@120

    gaitsim run spider --from runs/spider/champions/generation-000012.pickle

    gaitsim run --from gaitsim1-8gAAAGNl… --seed 4

    gaitsim run spider --detach

    gaitsim run walker --dask tcp://host:8786
    """
    from gaitsim.cli.evolving import (
        chosen_place,
        command_line_options,
        evolve_run,
        starting_individual,
    )
    from gaitsim.console.codes import read_challenge
    from gaitsim.experiment import load_experiment
    from gaitsim.runs.creation import create_run
    from gaitsim.runs.snapshot import RunSnapshot

    given = command_line_options(generations, population, seed, set_)
    challenge = read_challenge(from_) if from_ is not None else None
    if experiment is not None:
        loaded = load_experiment(experiment, given)
    elif challenge is not None:
        loaded = challenge.experiment_with(given)
    else:
        raise GaitsimError(
            "no experiment is given",
            where="NAME|FILE",
            allowed="the name of a preset or a file; optional with --from CODE",
            remedy="'gaitsim experiments list' lists the presets",
        )
    start = starting_individual(loaded, challenge or from_)
    with chosen_place(dask, workers, detach=detach) as place:
        created = RunSnapshot(create_run(loaded, out, start))
        evolve_run(created, place, workers=workers, json=json)

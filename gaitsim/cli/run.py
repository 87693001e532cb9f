"""`gaitsim run`."""

from gaitsim.cli.options import (
    Dask,
    Detach,
    ExperimentName,
    From,
    Generations,
    Json,
    Population,
    RunFolder,
    Seed,
    Set,
    Workers,
)
from gaitsim.cli.starting import begin_run, given_options
from gaitsim.experiment import load_experiment


def run(
    experiment: ExperimentName,
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
    loaded = load_experiment(experiment, given_options(generations, population, seed, set_))
    begin_run(loaded, from_, out, workers=workers, dask=dask, detach=detach, json=json)

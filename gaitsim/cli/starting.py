"""What the commands that begin a run share."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gaitsim.cli.cluster import cluster
from gaitsim.cli.detaching import check_detachable, evolve_detached
from gaitsim.cli.evolving import evolve_run
from gaitsim.experiment import Experiment, parse_assignments
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.start import check_start, kept_individual


def given_options(
    generations: int | None, population: int | None, seed: int | None, set_: Sequence[str] | None
) -> dict[str, Any]:
    """Return the options of an experiment that the command line gives, by key.

    Raises:
        ExperimentError: a `--set` is not KEY=VALUE.
    """
    short = {
        "evolution.generations": generations,
        "evolution.population": population,
        "seed": seed,
    }
    given = {key: value for key, value in short.items() if value is not None}
    return {**given, **parse_assignments(set_ or ())}


def begin_run(
    experiment: Experiment,
    from_: str | None,
    out: Path | None,
    *,
    workers: int | None,
    dask: str | None,
    detach: bool,
    json: bool,
) -> None:
    """Create a run and evolve it, here or in the background.

    Raises:
        GaitsimError: the individual of `--from` does not fit, the folder cannot be created, or the
            run fails.
    """
    start = None
    if from_ is not None:
        start = kept_individual(from_)
        check_start(experiment, start, f"--from {from_}")
    if detach:
        check_detachable(dask)
        evolve_detached(create_run(experiment, out, start), workers=workers, json=json)
        return
    with cluster(dask, workers) as executor:
        path = create_run(experiment, out, start)
        evolve_run(path, workers=workers, json=json, cluster=executor)

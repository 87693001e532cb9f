"""Steps shared by the commands that start a run."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gaitsim.cli.cluster import cluster
from gaitsim.cli.codes import challenge_as_start, read_challenge
from gaitsim.cli.detaching import check_detachable, evolve_detached
from gaitsim.cli.evolving import evolve_run
from gaitsim.experiment import Experiment, parse_assignments
from gaitsim.runs.creation import create_run
from gaitsim.runs.start import check_start, find_individual
from gaitsim.sharing.challenge import Challenge


def command_line_options(
    generations: int | None, population: int | None, seed: int | None, set_: Sequence[str] | None
) -> dict[str, Any]:
    """Return the experiment options given on the command line, by key."""
    short = {
        "evolution.generations": generations,
        "evolution.population": population,
        "seed": seed,
    }
    given = {key: value for key, value in short.items() if value is not None}
    return {**given, **parse_assignments(set_ or ())}


def start_run(
    experiment: Experiment,
    from_: str | Challenge | None,
    out: Path | None,
    *,
    workers: int | None,
    dask: str | None,
    detach: bool,
    json: bool,
) -> None:
    """Create a run and evolve it, in this process or in the background.

    `from_` is the value of `--from`, or a challenge code that was already read.
    """
    start = None
    if from_ is not None:
        challenge = read_challenge(from_) if isinstance(from_, str) else from_
        start = find_individual(str(from_)) if challenge is None else challenge_as_start(challenge)
        check_start(experiment, start, f"--from {'CODE' if challenge else from_}")
    if detach:
        check_detachable(dask)
        evolve_detached(create_run(experiment, out, start), workers=workers, json=json)
        return
    with cluster(dask, workers) as executor:
        path = create_run(experiment, out, start)
        evolve_run(path, workers=workers, json=json, cluster=executor)

"""Judge gaits in unseen worlds from the command line, with a progress bar."""

from gaitsim.cli.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import Ranges
from gaitsim.gait.unseen import Judgement, check_request, conditions_of, judge
from gaitsim.individual import Individual


def check_worlds(number: int | None, seed: int | None) -> None:
    """Check `--worlds` and `--world-seed` before anything is played.

    Raises:
        GaitsimError: one is invalid, or the seed is given alone.
    """
    if number is not None:
        check_request(number, seed or 0)
    elif seed is not None:
        raise GaitsimError(
            "--world-seed chooses unseen worlds, and none are requested",
            remedy="give --worlds, too, such as --worlds 100",
        )


def judge_shown(
    individual: Individual,
    number: int,
    seed: int | None = None,
    *,
    workers: int | None = None,
    ranges: Ranges | None = None,
    what: str = "unseen worlds",
) -> Judgement:
    """Judge a gait in unseen worlds, and show how many are done.

    Raises:
        GaitsimError: the body has no conditions, or the motion fails in every world.
    """
    conditions_of(individual.experiment)
    with Progress(what, "worlds") as progress:
        return judge(
            individual,
            number,
            seed=seed or 0,
            ranges=ranges,
            workers=workers,
            begin=progress.expect,
            advance=progress.advance,
        )

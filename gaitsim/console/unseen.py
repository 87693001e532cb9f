"""Evaluate gaits in unseen worlds from the command line, with a progress bar."""

from collections.abc import Callable
from typing import TypeVar

from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import notice
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import Ranges, conditions_of
from gaitsim.gait.checks import CheckResults, check_gait, worlds_of
from gaitsim.gait.feedback import REPORTED, FeedbackResults, blinded, compare_blind
from gaitsim.gait.unseen import UnseenResults, check_request, evaluate_unseen
from gaitsim.individual import Individual
from gaitsim.storage.snapshot import RunSnapshot

Result = TypeVar("Result")

AT_END, FEWEST_AT_END = 100, 10
"""Maximum and minimum number of unseen worlds at the end of a run.

Between these limits, the number is a tenth of the number of motions that the run simulated, so
that this evaluation costs little by comparison.
"""


def check_worlds(number: int | None, seed: int | None) -> None:
    """Check `--worlds` and `--world-seed` before any simulation."""
    if number is not None:
        check_request(number, seed or 0)
    elif seed is not None:
        raise GaitsimError(
            "--world-seed needs --worlds",
            remedy="add --worlds, such as --worlds 100",
        )


def evaluate_with_progress(
    individual: Individual,
    number: int,
    seed: int | None = None,
    *,
    workers: int | None = None,
    ranges: Ranges | None = None,
    what: str = "unseen worlds",
) -> UnseenResults:
    """Evaluate a gait in unseen worlds, and show the progress."""
    conditions_of(individual.experiment)
    with Progress(what, "worlds") as progress:
        return evaluate_unseen(
            individual,
            number,
            seed=seed or 0,
            ranges=ranges,
            workers=workers,
            begin=progress.expect,
            advance=progress.advance,
        )


def check_with_progress(individual: Individual, workers: int | None = None) -> CheckResults | None:
    """Check whether a gait holds, and show the progress; None if its body names no checks."""
    worlds = worlds_of(individual.experiment)
    if not worlds:
        return None
    with Progress("checking whether the gait holds", "worlds", len(worlds)) as progress:
        return check_gait(individual, workers=workers, advance=progress.advance)


def compare_blind_with_progress(
    individual: Individual, workers: int | None = None
) -> FeedbackResults | None:
    """Compare a gait with and without reflexes, and show the progress; None without reflexes."""
    if blinded(individual) is None:
        return None
    with Progress("walking with and without reflexes", "worlds", REPORTED) as progress:
        return compare_blind(individual, workers=workers, advance=progress.advance)


def check_champion(champion: Individual, workers: int | None = None) -> CheckResults | None:
    """Check whether a champion holds; Ctrl-C skips this.

    Returns:
        None if its body names no checks, or after a notice of why there is no result.
    """
    return _skippable(
        "the checks of whether the gait holds", lambda: check_with_progress(champion, workers)
    )


def evaluate_champion(
    run: RunSnapshot, champion: Individual, workers: int | None = None
) -> UnseenResults | None:
    """Evaluate the champion of a run over worlds in unseen worlds; Ctrl-C skips this.

    Returns:
        None if the run neither draws worlds nor names ranges, or after a notice of why there is
        no result.
    """
    worlds = champion.experiment.worlds
    if not (worlds.number or worlds.ranges):
        return None
    evaluated = int(run.history["evaluations"][-1]) * max(1, worlds.count)
    number = min(AT_END, max(FEWEST_AT_END, evaluated // 10))
    what = f"{number} unseen worlds (Ctrl-C skips them)"
    return _skippable(
        "the evaluation in unseen worlds",
        lambda: evaluate_with_progress(champion, number, workers=workers, what=what),
    )


def _skippable(what: str, evaluate: Callable[[], Result | None]) -> Result | None:
    """Return a result; None after a notice if Ctrl-C skips it, or if it fails."""
    try:
        with interruptible():
            return evaluate()
    except KeyboardInterrupt:
        notice(f"Skipped {what}.")
    except GaitsimError as error:
        notice(f"No result of {what}: {error.what}")
    return None

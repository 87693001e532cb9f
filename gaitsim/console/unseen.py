"""Evaluate gaits in several worlds from the command line, with a progress bar."""

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import TypeVar

from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import notice
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.gait.worlds import (
    CheckResults,
    UnseenResults,
    check_gait,
    check_request,
    evaluate_unseen,
)
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


def with_progress(what: str, evaluate: Callable[..., Result]) -> Result:
    """Evaluate a gait in worlds, and show the progress from the first world on.

    Args:
        what: description for the progress bar.
        evaluate: function with the arguments `begin` and `advance` of `evaluate_in`.
    """
    with ExitStack() as bars:
        shown: list[Progress] = []

        def begin(total: int) -> None:
            shown.append(bars.enter_context(Progress(what, "worlds", total)))

        def advance(worlds: int) -> None:
            shown[0].advance(worlds)

        return evaluate(begin=begin, advance=advance)


def check_champion(champion: Individual, workers: int | None = None) -> CheckResults | None:
    """Check whether a champion holds; Ctrl-C skips this.

    Returns:
        None if its body names no checks, or after a notice of why there is no result.
    """
    return _skippable(
        "the checks of whether the gait holds",
        "checking whether the gait holds",
        partial(check_gait, champion, workers=workers),
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
    return _skippable(
        "the evaluation in unseen worlds",
        f"{number} unseen worlds (Ctrl-C skips them)",
        partial(evaluate_unseen, champion, number, workers=workers),
    )


def _skippable(what: str, shown: str, evaluate: Callable[..., Result | None]) -> Result | None:
    """Return a result; None after a notice if Ctrl-C skips it, or if it fails."""
    try:
        with interruptible():
            return with_progress(shown, evaluate)
    except KeyboardInterrupt:
        notice(f"Skipped {what}.")
    except GaitsimError as error:
        notice(f"No result of {what}: {error.what}")
    return None

"""Judge gaits in unseen worlds from the command line, with a progress bar."""

from gaitsim.cli.console import notice
from gaitsim.cli.interrupts import interruptible
from gaitsim.cli.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import Ranges, conditions_of
from gaitsim.gait.judgement import Judgement
from gaitsim.gait.unseen import check_request, judge
from gaitsim.individual import Individual
from gaitsim.runs.snapshot import RunSnapshot

AT_END, FEWEST_AT_END = 100, 10
"""Unseen worlds at the end of a run, at most and at least; otherwise a tenth of those that it
evaluated individuals in, so that judging costs little beside evolving."""


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


def judge_at_end(
    run: RunSnapshot, champion: Individual, workers: int | None = None
) -> Judgement | None:
    """Judge the champion of a run over worlds in unseen ones; Ctrl-C skips it.

    Returns:
        None for a run in one world, and after reporting why there is nothing to say.
    """
    worlds = champion.experiment.worlds.number
    if not worlds:
        return None
    evaluated = int(run.history["evaluations"][-1]) * worlds
    number = min(AT_END, max(FEWEST_AT_END, evaluated // 10))
    what = f"{number} unseen worlds (Ctrl-C skips them)"
    try:
        with interruptible():
            return judge_shown(champion, number, workers=workers, what=what)
    except KeyboardInterrupt:
        notice("Not judged in unseen worlds: stopped.")
    except GaitsimError as error:
        notice(f"Not judged in unseen worlds: {error.what}")
    return None

"""The data that plots need: a kept front or archive, and a part of the motion."""

from gaitsim.errors import GaitsimError, NothingToPlotError
from gaitsim.individual import Individual


def require_front(individual: Individual) -> None:
    """Check that the search of an individual's run keeps a front."""
    _require_kept(individual, "front", "a search with a Pareto front, such as nsga-2")


def require_archive(individual: Individual) -> None:
    """Check that the search of an individual's run keeps an archive."""
    _require_kept(individual, "archive", "a search with an archive, such as map-elites")


def _require_kept(individual: Individual, kept: str, allowed: str) -> None:
    experiment = individual.experiment
    if experiment.search.keeps != kept:
        name = experiment.entries["search"].name
        raise NothingToPlotError(f"the search {name!r} keeps no {kept}", allowed=allowed)


def window_slice(
    frames: int, rate: float, window: tuple[float, float] | None, default: float | None = None
) -> slice:
    """Return the frames of a window of time.

    Args:
        frames: number of frames of the motion.
        rate: frames per second, Hz.
        window: first and last second; None for the last `default` seconds.
        default: length of the default window, s; None for the whole motion.
    """
    if frames < 2:
        raise NothingToPlotError(
            "the motion has only one frame, so no plot over time is possible",
            allowed="a motion of at least two frames",
        )
    if window is None:
        return slice(0 if default is None else max(0, frames - round(default * rate)), frames)
    first, last = window
    found = slice(max(0, round(first * rate)), min(frames, round(last * rate) + 1))
    if first < 0 or found.stop - found.start < 2:
        raise GaitsimError(
            f"fewer than two frames of the motion are between {first:g} and {last:g} s",
            allowed=f"part of 0 to {(frames - 1) / rate:.4g} s, with {rate:g} frames per second",
        )
    return found

"""The arguments of a plot."""

from collections.abc import Callable
from dataclasses import dataclass

from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.render.plots.style import LIGHT, Theme
from gaitsim.runs.snapshot import RunSnapshot


class NothingToPlotError(GaitsimError):
    """A run, body or motion lacks the data for a kind of plot."""


KEEPERS = {
    "front": "a search with a Pareto front, such as nsga-2",
    "archive": "a search with an archive, such as map-elites",
}


def require_kept(individual: Individual, kept: str) -> None:
    """Check that the search of an individual's run keeps a 'front' or an 'archive'."""
    experiment = individual.experiment
    if experiment.search.keeps != kept:
        name = experiment.entries["search"].name
        raise NothingToPlotError(f"the search {name!r} keeps no {kept}", allowed=KEEPERS[kept])


@dataclass(frozen=True, eq=False)
class Request:
    """The arguments of a plot.

    Attributes:
        run: run to plot.
        individuals: individuals to draw; one or more for kinds that show a motion.
        channel: channel of the motion; None for the default of the body.
        components: names or numbers of the channel's components; () draws all.
        window: first and last second; None for the default of the kind.
        theme: colours of the plot.
        beside: other runs, for the kind that shows several.
        axes: two axes of an archive; () draws all pairs.
        progress: function called with the number of members processed since the last call.
    """

    run: RunSnapshot
    individuals: tuple[Individual, ...] = ()
    channel: str | None = None
    components: tuple[str, ...] = ()
    window: tuple[float, float] | None = None
    theme: Theme = LIGHT
    beside: tuple[RunSnapshot, ...] = ()
    axes: tuple[str, ...] = ()
    progress: Callable[[int], object] = lambda done: None

    @property
    def individual(self) -> Individual:
        """The individual, for kinds that draw only one."""
        return self.individuals[0]


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

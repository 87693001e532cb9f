"""The arguments of a plot."""

from collections.abc import Callable
from dataclasses import dataclass

from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.render.plots.style import LIGHT, Theme
from gaitsim.runs.snapshot import RunSnapshot


class NothingToPlotError(GaitsimError):
    """A body or its motion lacks the data of a kind of plot."""


KEEPERS = {
    "front": "a search of several objectives, such as nsga-2",
    "archive": "a search that fills the cells of measures, such as map-elites",
}


def require_kept(individual: Individual, kept: str) -> None:
    """Refuse the run of an individual whose search keeps no 'front', or no 'archive'.

    Raises:
        NothingToPlotError: it does not.
    """
    experiment = individual.experiment
    if experiment.search.keeps != kept:
        name = experiment.entries["search"].name
        raise NothingToPlotError(f"the search {name!r} keeps no {kept}", allowed=KEEPERS[kept])


@dataclass(frozen=True, eq=False)
class Request:
    """The arguments of a plot.

    Attributes:
        run: the run to plot.
        individuals: to draw; one or more for kinds that show a motion.
        channel: of the motion; None for the default of the body.
        components: names or indices of the channel's components; () draws all.
        window: first and last second; None for the default of the kind.
        theme: colours.
        beside: other runs, for the kind that shows several.
        axes: two axes of an archive; () draws all pairs.
        progress: called with the number of members that were worked on since the last call.
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
        """The individual of kinds that draw one."""
        return self.individuals[0]


def window_slice(
    frames: int, rate: float, window: tuple[float, float] | None, usual: float | None = None
) -> slice:
    """Return the frames of a window of time.

    Args:
        frames: of the motion.
        rate: frames a second, Hz.
        window: first and last second; None for the last `usual` seconds.
        usual: length of the default window, s; None for the whole motion.

    Raises:
        NothingToPlotError: the motion has only one frame.
        GaitsimError: fewer than two frames are in the window.
    """
    if frames < 2:
        raise NothingToPlotError(
            "the motion has only one frame, so there is nothing over time",
            allowed="a body that moves in two frames or more",
        )
    if window is None:
        return slice(0 if usual is None else max(0, frames - round(usual * rate)), frames)
    first, last = window
    found = slice(max(0, round(first * rate)), min(frames, round(last * rate) + 1))
    if first < 0 or found.stop - found.start < 2:
        raise GaitsimError(
            f"no two frames of the motion are between {first:g} and {last:g} s",
            allowed=f"a part of 0 to {(frames - 1) / rate:.4g} s, of {rate:g} frames a second",
        )
    return found

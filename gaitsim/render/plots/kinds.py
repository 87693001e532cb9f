"""The kinds of plots, by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from gaitsim.individual import Individual
from gaitsim.render.plots.archive import archive_figure
from gaitsim.render.plots.channel import channel_figure, default_channel
from gaitsim.render.plots.diversity import diversity_figure
from gaitsim.render.plots.fitness import fitness_figure
from gaitsim.render.plots.footfall import contacts_of, footfall_figure
from gaitsim.render.plots.front import front_figure
from gaitsim.render.plots.gaits import gaits_figure, require_gaits
from gaitsim.render.plots.genome import genome_figure
from gaitsim.render.plots.joints import joints_figure, require_joints
from gaitsim.render.plots.path import path_figure
from gaitsim.render.plots.phase import phase_figure, stride_of
from gaitsim.render.plots.request import Request, require_kept
from gaitsim.render.plots.runs import runs_figure
from gaitsim.render.plots.search import require_figures, search_figure
from gaitsim.render.plots.stability import stability_figure
from gaitsim.render.plots.terms import terms_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_INDIVIDUAL = ("--generation", "--member", "--damage", "--world")
_MOTION = (*_INDIVIDUAL, "--window")
_CHANNEL = (*_MOTION, "--generations", "--channel", "--component")


@dataclass(frozen=True)
class Kind:
    """A kind of plot.

    Attributes:
        draw: function that draws the plot.
        options: options of `gaitsim plot` that the kind uses.
        check: function that raises a NothingToPlotError if an individual lacks the data.
    """

    draw: Callable[[Request], "Figure"]
    options: tuple[str, ...] = _MOTION
    check: Callable[[Individual], object] = lambda individual: None

    @property
    def shows_motion(self) -> bool:
        """Whether the kind shows an individual's motion rather than the whole run."""
        return "--generation" in self.options

    @property
    def takes_several(self) -> bool:
        """Whether the kind can show more than one individual."""
        return "--generations" in self.options


KINDS: Mapping[str, Kind] = {
    "fitness": Kind(lambda request: fitness_figure(request.run, request.theme), options=()),
    "terms": Kind(terms_figure, options=()),
    "diversity": Kind(diversity_figure, options=()),
    "genome": Kind(genome_figure, options=()),
    "runs": Kind(runs_figure, options=("--beside",)),
    "search": Kind(search_figure, (), require_figures),
    "front": Kind(front_figure, (), partial(require_kept, kept="front")),
    "archive": Kind(archive_figure, ("--axes",), partial(require_kept, kept="archive")),
    "gaits": Kind(gaits_figure, (), require_gaits),
    "path": Kind(path_figure),
    "channel": Kind(channel_figure, _CHANNEL, default_channel),
    "footfall": Kind(footfall_figure, check=contacts_of),
    "phase": Kind(phase_figure, _INDIVIDUAL, stride_of),
    "joints": Kind(joints_figure, (*_MOTION, "--channel"), require_joints),
    "stability": Kind(stability_figure, check=contacts_of),
}
# `--kind all` draws a single individual.
ALL_OPTIONS = tuple(option for option in _CHANNEL if option != "--generations")


def file_stem(kind: str, request: Request) -> str:
    """Return the name of a plot's file without extension: 'channel-margin-generation-138'."""
    parts = [kind, *request.axes]
    if kind == "channel":
        parts += [request.channel or default_channel(request.individual), *request.components]
    if kind == "joints" and request.channel:
        parts.append(request.channel)
    if KINDS[kind].shows_motion:
        numbers = [str(individual.generation) for individual in request.individuals]
        shown = "-".join(numbers) if len(numbers) <= 4 else f"{numbers[0]}-to-{numbers[-1]}"
        several = KINDS[kind].takes_several and len(numbers) > 1
        parts.append(f"generation-{shown}" if several else request.individual.stem)
    stem = "-".join(parts)
    return "".join(char if char.isalnum() or char in "-_" else "-" for char in stem)

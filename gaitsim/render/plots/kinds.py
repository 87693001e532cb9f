"""The kinds of plots by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gaitsim.render.plots.channel import channel_figure, usual_channel
from gaitsim.render.plots.fitness import fitness_figure
from gaitsim.render.plots.footfall import footfall_figure
from gaitsim.render.plots.joints import joints_figure
from gaitsim.render.plots.path import path_figure
from gaitsim.render.plots.request import Request
from gaitsim.render.plots.stability import stability_figure
from gaitsim.render.plots.terms import terms_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Kind:
    """A kind of plot.

    Attributes:
        draw: draws it.
        moves: whether it shows an individual's motion rather than the whole run.
        several: whether it shows more than one individual.
    """

    draw: Callable[[Request], "Figure"]
    moves: bool = True
    several: bool = False


KINDS: Mapping[str, Kind] = {
    "fitness": Kind(lambda request: fitness_figure(request.run, request.theme), moves=False),
    "terms": Kind(terms_figure, moves=False),
    "path": Kind(path_figure),
    "channel": Kind(channel_figure, several=True),
    "footfall": Kind(footfall_figure),
    "joints": Kind(joints_figure),
    "stability": Kind(stability_figure),
}


def file_stem(kind: str, request: Request) -> str:
    """Return the name of a plot's file, such as 'channel-margin-generation-138'."""
    if not KINDS[kind].moves:
        return kind
    parts = [kind]
    if kind == "channel":
        parts += [request.channel or usual_channel(request.individual), *request.components]
    numbers = [str(individual.generation) for individual in request.individuals]
    if not KINDS[kind].several:
        numbers = numbers[:1]
    shown = "-".join(numbers) if len(numbers) <= 4 else f"{numbers[0]}-to-{numbers[-1]}"
    stem = "-".join([*parts, f"generation-{shown}"])
    return "".join(char if char.isalnum() or char in "-_" else "-" for char in stem)

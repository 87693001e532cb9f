"""Plot a gait: footfalls, stability, and phases compared with the nearest reference gait."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError
from gaitsim.gait import Footfalls, GaitAnalysis
from gaitsim.render.plots.components import finite_or_nan
from gaitsim.render.plots.labels import add_heading, shorten
from gaitsim.render.plots.panels import draw_bars
from gaitsim.render.plots.style import LIGHT, WIDTH, Theme, save, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STRIDES = 4  # maximum number of strides shown
SECONDS = 3.0  # length shown of a gait without strides


def plot_gait(gait: GaitAnalysis, title: str, path: Path, theme: Theme = LIGHT) -> None:
    """Draw the footfalls, phases and stability margin of a gait.

    Footfalls and margin cover the last strides, after the gait has settled. Phases are
    dots, larger if more consistent; lines show the phases of the nearest reference gait.
    """
    from matplotlib.figure import Figure

    found = gait.footfalls
    if found is None:
        raise GaitsimError(
            "the body has no feet, so there are no footfalls to draw",
            allowed="a body whose skeleton has contacts",
            remedy="omit --figure",
        )
    part = _frames_to_draw(found, gait.frame_rate)
    names = [shorten(foot.name, 12) for foot in found.feet]
    with styled(theme):
        colours = theme.foot_colours([foot.name for foot in found.feet])
        rows = 0.17 * max(4, len(names))
        figure = Figure(figsize=(2 * WIDTH, 1.5 + rows + 1.1))
        places = figure.subplot_mosaic(
            [["footfalls", "phases"], ["margin", "phases"]],
            width_ratios=[2.2, 1],
            height_ratios=[rows + 0.3, 1.2],
        )
        axes, start = places["footfalls"], part.start / gait.frame_rate
        shown = [*zip(names, found.touching[part].T, strict=True)]
        draw_bars(axes, shown, start, gait.frame_rate, colours)
        axes.set_title("footfalls")
        axes.tick_params(labelbottom=False)
        _draw_margin(places["margin"], found.margin[part], start, gait.frame_rate, theme)
        places["margin"].set_xlim(axes.get_xlim())
        _draw_phases(places["phases"], gait, found, names, colours, theme)
        name = gait.name.name if gait.name.name != "none" else "no named gait"
        add_heading(figure, f"{shorten(title, 70)}: {name}")
        save(figure, path, theme)


def _frames_to_draw(found: Footfalls, frame_rate: float) -> slice:
    """Return the frames to draw: the last strides, or seconds of a gait without strides."""
    frames = len(found.touching)
    length = round(STRIDES * found.stride.frames if found.stride else SECONDS * frame_rate)
    return slice(max(0, frames - max(length, 2)), frames)


def _draw_margin(
    axes: "Axes", margin: NDArray[np.float64], start: float, rate: float, theme: Theme
) -> None:
    """Draw the margin in millimetres, with gaps while no foot is on the ground."""
    seconds = start + (np.arange(len(margin)) + 0.5) / rate
    values = 1000 * finite_or_nan(margin)
    axes.plot(seconds, values, color=theme.ink)
    axes.fill_between(
        seconds, values, 0, where=values < 0, color=theme.colours[1], alpha=0.3, linewidth=0
    )
    axes.axhline(0, color=theme.ink, linewidth=0.5)
    if np.isnan(values).all():
        axes.text(0.5, 0.5, "no foot on the ground", transform=axes.transAxes, ha="center")
    axes.set_title("stability margin (mm)")
    axes.set_xlabel("time (s)")


def _draw_phases(
    axes: "Axes",
    gait: GaitAnalysis,
    found: Footfalls,
    names: list[str],
    colours: list[str],
    theme: Theme,
) -> None:
    """Draw the phases of touch-down in cycles, and the phases of the nearest reference gait."""
    axes.set_title("phase of touch-down (cycles)")
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_yticks(range(len(names)), names)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(-0.15, 1.15)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "¼", "½", "¾", "1"])
    for row, phase in enumerate(gait.name.pattern):
        if phase is not None:
            for cycle in (-1, 0, 1):
                axes.plot(
                    [phase + cycle] * 2, [row - 0.4, row + 0.4], color=theme.ink, linewidth=0.8
                )
    known = np.flatnonzero(np.isfinite(found.phases))
    for row in known.tolist():
        size = 4 + 26 * float(found.consistency[row]) ** 2
        # 0 and 1 are the same moment, so a phase near one of them is drawn at both.
        places = found.phases[row] + np.array([-1.0, 0.0, 1.0])
        axes.scatter(places, [row] * 3, s=size, color=colours[row], zorder=3, linewidth=0)
    if not len(known):
        axes.text(0.5, 0.5, "no stride", transform=axes.transAxes, ha="center")
    elif gait.name.distance is not None:
        away = f"rms distance to the reference\ngait (lines): {gait.name.distance:.2f} cycles"
        axes.set_xlabel(away)

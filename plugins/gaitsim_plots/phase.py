"""Plot a stride as a clock that shows when each foot is on the ground."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.plugin import NothingToPlotError
from gaitsim.plugin.gait import Footfalls, GaitAnalysis, Stride, analyse_individual
from gaitsim.plugin.pictures import WIDTH, Theme, add_heading, heading_of, shorten, styled
from gaitsim.plugin.runs import Individual
from gaitsim_plots.feet import contacts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MAX_MARK = 4  # maximum characters of a name on a ring
_CYCLE = 2 * np.pi


def phase_figure(individual: Individual, theme: Theme) -> "Figure":
    """Plot a ring for each foot with an arc from touch-down to lift-off, and a table.

    A stride is one clockwise turn, which starts at the touch-down of the first foot that steps.
    """
    from matplotlib.figure import Figure

    gait, found, stride = stride_of(individual)
    marks = [foot.name for foot in found.feet]
    if max(map(len, marks)) > _MAX_MARK:
        marks = [str(number) for number in range(1, len(marks) + 1)]
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 3.0))
        places = figure.subplot_mosaic(
            [["clock", "table"]],
            width_ratios=(2.6, 1),
            per_subplot_kw={"clock": {"projection": "polar"}},
        )
        _draw_clock(places["clock"], found, marks, theme)
        _draw_table(places["table"], found, marks, theme)
        name = gait.name.name if gait.name.name != "none" else "no named gait"
        length = stride.frames / gait.frame_rate
        figure.supxlabel(f"{name}; stride {length:.3g} s ({stride.frequency:.3g} Hz)", fontsize=7)
        add_heading(figure, heading_of([individual]))
    return figure


def stride_of(individual: Individual) -> tuple[GaitAnalysis, Footfalls, Stride]:
    """Return the analysis of a gait, its footfalls and its stride."""
    contacts_of(individual)
    gait = analyse_individual(individual)
    found = gait.footfalls
    if found is None or found.stride is None or not np.isfinite(found.phases).any():
        raise NothingToPlotError(
            f"the feet of {individual.title} have no common stride",
            where=str(individual.source),
            allowed="a gait that repeats",
            remedy="plot when each foot is on the ground with --kind footfall",
        )
    return gait, found, found.stride


def _draw_clock(axes: "Axes", found: Footfalls, marks: list[str], theme: Theme) -> None:
    """Draw the rings, with the first foot outermost."""
    count = len(marks)
    radii = np.arange(count, 0, -1) + 0.2 * count
    axes.set_theta_zero_location("N")  # type: ignore[attr-defined]
    axes.set_theta_direction(-1)  # type: ignore[attr-defined]
    colours = theme.foot_colours([foot.name for foot in found.feet])
    for foot, mark, radius, phase, colour in zip(
        found.feet, marks, radii, found.phases, colours, strict=True
    ):
        axes.plot(np.linspace(0, _CYCLE, 181), [radius] * 181, color=theme.faint, linewidth=0.5)
        steps = bool(np.isfinite(phase))
        if not steps and foot.duty_factor < 1:
            continue
        start = (phase if steps else 0) * _CYCLE
        stance = foot.duty_factor * _CYCLE
        axes.bar(
            start, 0.8, stance, radius - 0.4, align="edge", color=colour, linewidth=0, zorder=2
        )
        middle = (start + min(stance / 2, 0.7 / radius)) % _CYCLE
        axes.text(
            middle,
            radius,
            mark,
            rotation=-np.degrees(middle) + (180 if np.pi / 2 < middle < 3 * np.pi / 2 else 0),
            color=theme.background,
            fontsize=min(6.0, 42 / count),
            fontweight="bold",
            ha="center",
            va="center",
            zorder=3,
        )
    axes.set_ylim(0, radii[0] + 0.45)
    axes.set_yticks([])
    quarters = np.arange(4) / 4
    axes.set_xticks(quarters * _CYCLE, ["0", "¼", "½", "¾"])
    axes.tick_params(axis="x", pad=-3)
    axes.spines["polar"].set_visible(False)


def _draw_table(axes: "Axes", found: Footfalls, marks: list[str], theme: Theme) -> None:
    """Write the phase and duty factor of each foot."""
    axes.set_axis_off()
    rows = [("foot", "phase", "duty", theme.ink)]
    colours = theme.foot_colours([foot.name for foot in found.feet])
    for foot, mark, phase, colour in zip(found.feet, marks, found.phases, colours, strict=True):
        name = mark if mark == foot.name else f"{mark} {shorten(foot.name, 8)}"
        shown = f"{phase:.2f}" if np.isfinite(phase) else "–"
        rows.append((name, shown, f"{foot.duty_factor:.2f}", colour))
    for row, (name, phase, duty, colour) in enumerate(rows):
        height = 0.5 + (len(rows) / 2 - row - 0.5) * min(0.09, 1 / len(rows))
        axes.text(0, height, name, color=colour, fontsize=6.5, va="center")
        for right, text in ((0.66, phase), (1, duty)):
            axes.text(right, height, text, fontsize=6.5, va="center", ha="right")

"""Plot the results of a gait in unseen worlds: sorted, and against each condition."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.gait.feet import Floats
from gaitsim.gait.sensitivity import PARTS
from gaitsim.gait.worlds import UnseenResults
from gaitsim.render.plots.labels import add_heading, format_number
from gaitsim.render.plots.panels import rows_of_panels
from gaitsim.render.plots.style import LIGHT, WIDTH, Theme, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = (4, 3, 5)  # numbers of columns to try; the one with the fewest empty places is chosen
_HEIGHT = 1.55  # height of a row of panels, inches
_DOT = 7.0  # area of a world's mark, points²


def worlds_figure(found: UnseenResults, heading: str, theme: Theme = LIGHT) -> "Figure":
    """Draw the sorted results, and the results against each condition, the most harmful one first.

    The vertical axis of every panel shows the results.
    """
    from matplotlib.figure import Figure

    strongest = [one.condition for one in found.effects]
    names = [*strongest, *(name for name in found.ranges if name not in strongest)]
    panels = 1 + len(names)
    columns = min(panels, min(COLUMNS, key=lambda count: -panels % count))
    rows = -(-panels // columns)
    with styled(theme):
        figure = Figure(figsize=(2 * WIDTH, 0.65 + rows * _HEIGHT))
        first, *others = places = rows_of_panels(figure, panels, columns, share_y=True)
        _draw_distribution(first, found, theme)
        for axes, name in zip(others, names, strict=True):
            _draw_condition(axes, found, name, theme)
        unit = f" ({found.unit})" if found.unit else ""
        for axes in places[::columns]:
            axes.set_ylabel(f"{found.measure}{unit}")
        handles: dict[str, object] = {}
        for axes in (first, *others):
            marks, labels = axes.get_legend_handles_labels()
            for label, mark in zip(labels, marks, strict=True):
                handles.setdefault(label, mark)
        add_heading(figure, heading, [*handles.values()], [*handles])
    return figure


def heading_of_worlds(found: UnseenResults, title: str) -> str:
    """Return the heading of the figure: the title, the number of worlds and of falls."""
    return f"{title}: {len(found.worlds):,} unseen worlds, {found.falls_in_words}"


def _draw_distribution(axes: "Axes", found: UnseenResults, theme: Theme) -> None:
    """Draw the sorted results against the share of worlds with lower results."""
    order = np.argsort(found.results, kind="stable")
    share = 100 * (np.arange(len(order)) + 0.5) / len(order)
    _draw_worlds(axes, share, found, theme, order)
    axes.axvspan(0, 10, color=theme.faint, alpha=0.35, linewidth=0, zorder=0)
    if np.isfinite(found.worst_tenth):
        axes.plot(
            [0, 10],
            [found.worst_tenth] * 2,
            color=theme.ink,
            linewidth=1.4,
            solid_capstyle="butt",
        )
        axes.annotate(
            f"worst tenth {format_number(round(found.worst_tenth, 3))}",
            (10, found.worst_tenth),
            (3, 0),
            textcoords="offset points",
            fontsize=6.5,
            va="center",
        )
    axes.set_xlim(0, 100)
    axes.set_xlabel("share of worlds (%)")


def _draw_condition(axes: "Axes", found: UnseenResults, name: str, theme: Theme) -> None:
    """Draw the results against a condition, with the means of its thirds and its harmful range."""
    values, (low, high) = found.conditions[name], found.ranges[name]
    effect = next((one for one in found.effects if one.condition == name), None)
    for start, end in effect.hurting if effect else ():
        axes.axvspan(
            start, end, color=theme.colours[1], alpha=0.13, linewidth=0, label="harmful range"
        )
    _draw_worlds(axes, values, found, theme, np.arange(len(values)))
    if low < high:
        edges = np.linspace(low, high, PARTS + 1)
        finite = np.isfinite(found.results)
        parts = np.searchsorted(edges[1:-1], values)
        for part in range(PARTS):
            inside = finite & (parts == part)
            if inside.any():
                axes.plot(
                    edges[part : part + 2],
                    [found.results[inside].mean()] * 2,
                    color=theme.ink,
                    linewidth=1.4,
                    solid_capstyle="butt",
                    label="mean of a third",
                )
        axes.set_xlim(low, high)
    unit = f" ({found.units[name]})" if found.units[name] else ""
    axes.set_xlabel(name.replace("_", " ") + unit)
    axes.locator_params(axis="x", nbins=4)


def _draw_worlds(
    axes: "Axes", across: Floats, found: UnseenResults, theme: Theme, order: np.ndarray
) -> None:
    """Mark each world; falls are crosses, and failed motions are crosses on the axis."""
    results, fell = found.results[order], found.fell[order]
    nominal, colours = found.nominal.result, theme.colours
    if np.isfinite(nominal):
        axes.axhline(
            nominal, color=colours[2], linewidth=0.9, linestyle="--", label="nominal world"
        )
    kept = ~fell & np.isfinite(results)
    axes.scatter(
        across[kept], results[kept], s=_DOT, color=colours[0], linewidth=0, alpha=0.8, label="world"
    )
    cross: dict[str, Any] = {
        "s": 2.4 * _DOT,
        "marker": "x",
        "color": colours[1],
        "linewidth": 0.9,
        "label": "fall",
    }
    fallen = fell & np.isfinite(results)
    if fallen.any():
        axes.scatter(across[fallen], results[fallen], **cross)
    failed = ~np.isfinite(results)
    if failed.any():
        foot = axes.get_xaxis_transform()
        axes.scatter(across[failed], np.zeros(failed.sum()), transform=foot, clip_on=False, **cross)

"""Plots of maps of designs: heat maps over two dimensions, or the effect of each dimension."""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gaitsim.plugin.pictures import Theme
    from gaitsim_design.maps import DesignMap
    from gaitsim_design.statistics import Floats

SHOWN = ("score", "speed", "cost of transport", "heat")
CURVE = 61  # points of an effect
FEW = 12  # levels of an axis with a label each
RANGE = 0.05, 0.95  # quantiles of the values that span the colours


def design_figure(found: "DesignMap", theme: "Theme") -> "Figure":
    """Return heat maps of a grid of two dimensions, or else effects of all dimensions."""
    from gaitsim.plugin.pictures import styled

    with styled(theme):
        grid = found.grid
        return _effects(found, theme) if grid is None else _heat_maps(found, grid, theme)


def _heat_maps(found: "DesignMap", grid: Any, theme: "Theme") -> "Figure":
    """Draw a heat map of each quantity, with the original, the best design and the plateau.

    Args:
        found: map of designs.
        grid: index of each design of the grid, (first dimension, second dimension).
        theme: colours.
    """
    from matplotlib.figure import Figure

    from gaitsim.plugin.pictures import WIDTH, add_heading, heading_of_run, rows_of_panels

    shown = [name for name in SHOWN if name in found.quantities]
    rows = -(-len(shown) // 2)
    figure = Figure(figsize=(2 * WIDTH, 0.6 + 2.65 * rows))
    levels = [np.unique(found.designs[grid.ravel(), axis]) for axis in (0, 1)]
    borders = [np.append(one - step / 2, one[-1] + step / 2)
               for one in levels for step in [one[1] - one[0]]]  # fmt: skip
    for axes, name in zip(rows_of_panels(figure, len(shown), 2), shown, strict=True):
        quantity = found.quantities[name]
        means = quantity.means
        values = np.ma.masked_invalid(means[grid].T)
        known = means[np.isfinite(means)]
        low, high = np.quantile(known, RANGE)
        # Outliers, such as designs that fall, would take most of the colours.
        low, high = (known.min(), high) if not quantity.higher else (low, known.max())
        colours = "viridis" if quantity.higher else "viridis_r"
        drawn = axes.pcolormesh(
            *borders, values, cmap=colours, vmin=low, vmax=max(high, low + 1e-9)
        )
        extend = "max" if not quantity.higher else "min"
        bar = figure.colorbar(drawn, ax=axes, extend=extend, aspect=24, pad=0.02)
        bar.outline.set_visible(False)
        bar.ax.tick_params(length=0)
        axes.set_title(f"{name} ({quantity.unit})" if quantity.unit else name)
        _outline(axes, found.plateau[grid], borders, theme)
        _mark(axes, found, theme)
        axes.grid(visible=False)
        axes.set_box_aspect(1)
        for axis, one, label in zip((axes.xaxis, axes.yaxis), levels, _labels(found), strict=True):
            axis.set_label_text(label)
            if len(one) <= FEW:
                axis.set_ticks(one, [f"{level:.3g}" for level in one])
    search, on = found.search, int(found.plateau.sum())
    more = f", {len(found.designs)} designs, {search.replicates} replicates, plateau of {on}"
    heading = heading_of_run(found.run.path.resolve().name, found.experiment, more, 2 * WIDTH)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    add_heading(figure, heading, handles, labels)
    return figure


def _labels(found: "DesignMap") -> list[str]:
    """Return the labels of the axes, with the size of the original."""
    return [
        f"{name} (× {one.nominal:.3g} {one.unit})".replace(" )", ")")
        for name, one in found.dimensions.items()
    ]


def _outline(axes: "Axes", inside: Any, borders: "list[Floats]", theme: "Theme") -> None:
    """Draw the border of the cells for which `inside`, (columns, rows), holds."""
    across, up = borders
    padded = np.pad(inside, 1)
    lines = []
    for column, row in np.argwhere(np.diff(padded, axis=0)[:, 1:-1]):
        lines.append([(across[column], up[row]), (across[column], up[row + 1])])
    for column, row in np.argwhere(np.diff(padded, axis=1)[1:-1]):
        lines.append([(across[column], up[row]), (across[column + 1], up[row])])
    from matplotlib.collections import LineCollection

    for colour, width in ((theme.background, 3.2), (theme.ink, 1.6)):
        axes.add_collection(
            LineCollection(lines, colors=colour, linewidths=width, capstyle="projecting"),
            autolim=False,
        )
    axes.plot([], [], color=theme.ink, linewidth=1.6, label="plateau of the score")


def _mark(axes: "Axes", found: "DesignMap", theme: "Theme") -> None:
    """Mark the original and the design with the best score."""
    for index, marker, size, label in (
        (found.original, "o", 6, "original"),
        (found.best, "*", 10, "best score"),
    ):
        axes.plot(
            *found.designs[index],
            marker=marker,
            markersize=size,
            linestyle="none",
            color=theme.ink,
            markerfacecolor="none" if marker == "o" else theme.ink,
            markeredgecolor=theme.background if marker == "*" else theme.ink,
            markeredgewidth=0.7 if marker == "*" else 1.6,
            label=label,
            zorder=5,
        )


def _effects(found: "DesignMap", theme: "Theme") -> "Figure":
    """Draw the mean effect of each dimension on each quantity, with intervals over replicates."""
    from matplotlib.figure import Figure

    from gaitsim.plugin.pictures import WIDTH, add_heading, heading_of_run
    from gaitsim_design.statistics import ResponseSurface, intervals

    shown = [name for name in SHOWN if name in found.quantities]
    columns = len(found.names)
    width = max(WIDTH, min(1.6 * columns, 2.2 * WIDTH))
    figure = Figure(figsize=(width, 0.9 + 1.35 * len(shown)))
    places = figure.subplots(len(shown), columns, sharex="col", sharey="row", squeeze=False)
    along = np.linspace(-1, 1, CURVE)
    low, high = found.designs.min(axis=0), found.designs.max(axis=0)
    for row, name in zip(places, shown, strict=True):
        quantity = found.quantities[name]
        means = quantity.means
        each = [ResponseSurface.fit(found.points, one) for one in quantity.values.T]
        surfaces = [one for one in each if one is not None]
        span = np.quantile(means[np.isfinite(means)], RANGE)
        for index, axes in enumerate(row):
            axes.plot(
                found.designs[:, index], means, ".", color=theme.faint, markersize=3, label="design"
            )
            if surfaces:
                x = low[index] + (along + 1) / 2 * (high[index] - low[index])
                curves = np.stack([one.effect(index, along) for one in surfaces], axis=1)
                middle, half = intervals(curves)
                axes.plot(x, middle, color=theme.colours[0], label="mean effect")
                axes.fill_between(
                    x, middle - half, middle + half, color=theme.colours[0], alpha=0.2,
                    linewidth=0, label="95 % interval",
                )  # fmt: skip
            axes.axvline(1.0, color=theme.ink, linewidth=0.7, linestyle=":", label="original")
            space = 0.25 * (span[1] - span[0]) + 1e-9
            axes.set_ylim(span[0] - space, span[1] + space)
        row[0].set_ylabel(f"{name}\n({quantity.unit})" if quantity.unit else name)
    for axes, label in zip(places[-1], _labels(found), strict=True):
        axes.set_xlabel(label.replace(" (", "\n("))
    more = f", {len(found.designs)} designs, {found.search.replicates} replicates"
    heading = heading_of_run(found.run.path.resolve().name, found.experiment, more, width)
    add_heading(figure, heading, *places[0][0].get_legend_handles_labels())
    return figure

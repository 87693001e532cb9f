"""Plot parallel coordinates."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.errors import NothingToPlotError
from gaitsim.render.archive_view import colour_scale_low
from gaitsim.render.parallel_view import ParallelView
from gaitsim.render.plots.labels import add_heading, shorten
from gaitsim.render.plots.style import WIDTH, Theme, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_AXES = 12
_SMOOTH = 24  # points of a line between two axes


def parallel_figure(view: ParallelView, text: str, theme: Theme) -> "Figure":
    """Draw a line for each item, whose colour is its score; the best item is thick.

    Args:
        view: the items.
        text: heading.
        theme: theme of the figure.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    known = view.scores[np.isfinite(view.scores)]
    if not len(known):
        raise NothingToPlotError(f"none of the {view.items} has a score")
    if len(view.axes) > MAX_AXES:
        raise NothingToPlotError(
            f"too many axes to plot: {len(view.axes)}", allowed=f"at most {MAX_AXES}"
        )
    low, extended = colour_scale_low(known)
    norm = Normalize(low, max(float(known.max()), low + 1e-12), clip=True)
    # Bent lines are easier to follow across an axis than straight ones.
    bend = np.linspace(0, 1, _SMOOTH)
    along = np.concatenate([at + bend for at in range(len(view.axes) - 1)])
    ease = bend**2 * (3 - 2 * bend)
    left, right = view.shares[:, :-1, None], view.shares[:, 1:, None]
    heights = (left + (right - left) * ease).reshape(len(view.shares), -1)
    order = np.argsort(np.where(np.isfinite(view.scores), view.scores, -np.inf), kind="stable")
    best = view.best
    with styled(theme):
        figure = Figure(figsize=(max(1.5 * WIDTH, 0.9 * len(view.axes) + 0.6), 3.1))
        axes = figure.subplots()
        axes.grid(visible=False)
        axes.set_axis_off()
        lines = np.stack([np.broadcast_to(along, heights.shape), heights], axis=-1)[order]
        widths = np.where(order == best, 2.2, 0.8)
        drawn = LineCollection(
            [*lines],
            array=view.scores[order],
            norm=norm,
            cmap="viridis",
            linewidths=widths,
            alpha=np.where(order == best, 1.0, max(0.15, min(0.9, 40 / len(lines)))),
        )
        axes.add_collection(drawn)
        for place, axis in enumerate(view.axes):
            axes.plot([place, place], [0, 1], color=theme.ink, linewidth=0.7)
            for share, word in axis.ticks(8 if axis.choices else 5):
                axes.plot([place - 0.02, place], [share, share], color=theme.ink, linewidth=0.6)
                axes.text(
                    place - 0.04,
                    share,
                    shorten(word, 16),
                    ha="right",
                    va="center",
                    fontsize=6,
                    bbox={"facecolor": theme.background, "alpha": 0.7, "pad": 0.4, "linewidth": 0},
                )
            arrow = {"max": " ↑", "min": " ↓", "": ""}[axis.better]
            name, unit = shorten(axis.name, 22), f"\n({axis.unit})" if axis.unit else ""
            axes.text(place, 1.05, f"{name}{arrow}{unit}", ha="center", va="bottom", fontsize=7)
        axes.set_xlim(-0.35, len(view.axes) - 0.9)
        axes.set_ylim(-0.03, 1.18)
        bar = figure.colorbar(
            ScalarMappable(norm, "viridis"),
            ax=axes,
            fraction=0.03,
            pad=0.02,
            extend="min" if extended else "neither",
        )
        bar.set_label(view.axes[-1].label, fontsize=7)
        bar.ax.tick_params(labelsize=6)
        add_heading(figure, f"{text}, {len(view.scores):,} {view.items}")
    return figure

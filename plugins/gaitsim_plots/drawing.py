"""Draw the dimensions of an individual from the side and from above, beside the original body."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.plugin import NothingToPlotError, Organism, RealSpace, Skeleton
from gaitsim.plugin.pictures import WIDTH, Theme, add_heading, heading_of, styled
from gaitsim.plugin.runs import Individual

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VIEWS = {"from the side": (0, 2), "from above": (0, 1)}
GREY = "0.72"  # the original
ROW = 0.16  # inches of a row of the table
CLEAR = 0.05  # distance of dimension lines from the body, as a share of its length
FLAT = 0.6  # share of its length that a labelled segment has in a view


def drawing_figure(individual: Individual, theme: Theme) -> "Figure":
    """Draw the body of an individual in its standing pose, with its lengths, over the original.

    Raises:
        NothingToPlotError: the body has no dimensions.
    """
    from matplotlib.figure import Figure

    organism = individual.experiment.organism
    space = organism.design_space()
    if not space:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} has no dimensions",
            where=str(individual.source),
        )
    body = individual.body
    plain: dict[str, Any] = {"dimensions": {}, "evolve": (), "ranges": {}}
    before, after = (_standing(one) for one in (organism.model_copy(update=plain), body))
    factors: dict[str, float] = getattr(body, "dimensions", {})
    shown = {name: factors.get(name, 1.0) for name in space if "." not in name or name in factors}
    with styled(theme):
        points = 1000 * np.concatenate([one.segments[0].reshape(-1, 3) for one in (before, after)])
        low, high = points.min(axis=0), points.max(axis=0)
        margin = 4 * CLEAR * float(high[0] - low[0])
        extent = high - low + 2 * margin
        heights = [0.9 * WIDTH * float(extent[up] / extent[0]) for _, up in VIEWS.values()]
        table = ROW * (len(shown) + 2)
        figure = Figure(figsize=(WIDTH, sum(heights) + table + 1.0))
        panels = figure.subplots(3, 1, height_ratios=[*heights, table])
        for axes, (title, view) in zip(panels, VIEWS.items(), strict=False):
            _draw(axes, before, view, GREY, 2.5)
            _draw(axes, after, view, theme.left, 1.2)
            _label(axes, after, view, theme)
            across, up = view
            axes.set_xlim(low[across] - margin, high[across] + margin)
            axes.set_ylim(low[up] - margin, high[up] + margin)
            axes.set_aspect("equal")
            axes.set_title(title, fontsize=7, pad=2)
            axes.set_xlabel("x (mm)")
            axes.set_ylabel(f"{'xyz'[up]} (mm)")
        _write_table(panels[2], space, shown)
        add_heading(figure, heading_of([individual]))
    return figure


def _standing(body: Organism) -> Skeleton:
    """Return the skeleton of a body that begins to move."""
    space = body.genome_space()
    assert isinstance(space, RealSpace)
    middle = (space.lower + space.upper) / 2
    return body.skeleton(body.move(middle[None]), 0)


def _draw(
    axes: "Axes", skeleton: Skeleton, view: tuple[int, int], colour: str, width: float
) -> None:
    from matplotlib.collections import LineCollection

    lines = 1000 * np.asarray(skeleton.segments[0])[..., view]
    axes.add_collection(LineCollection([*lines], colors=colour, linewidths=width, zorder=4 - width))
    joints = np.unique(lines.reshape(-1, 2).round(6), axis=0)
    axes.plot(*joints.T, "o", color=colour, markersize=1.5 * width, zorder=4 - width)


def _label(axes: "Axes", skeleton: Skeleton, view: tuple[int, int], theme: Theme) -> None:
    """Write the length of each segment of the first leg, and draw the extents of the body."""
    ends = 1000 * np.asarray(skeleton.segments[0], np.float64)
    low, high = ends.reshape(-1, 3).min(axis=0), ends.reshape(-1, 3).max(axis=0)
    size = float(high[0] - low[0])
    leg = skeleton.contact_names[:1]
    for name, segment in zip(skeleton.names, ends, strict=True):
        flat = segment[:, view]
        length = float(np.linalg.norm(segment[1] - segment[0]))
        if name.split()[:1] == list(leg) and np.linalg.norm(flat[1] - flat[0]) > FLAT * length:
            x, y = flat.mean(axis=0)
            axes.annotate(
                f"{length:.1f}",
                (x, y),
                xytext=(4, 2),
                textcoords="offset points",
                fontsize=6,
                color=theme.left,
            )
    across, up = view
    clear = CLEAR * size
    arrow = {"arrowstyle": "<->", "color": theme.ink, "lw": 0.6, "shrinkA": 0, "shrinkB": 0}
    text: dict[str, Any] = {"textcoords": "offset points", "fontsize": 6}
    left, right, top, bottom = low[across], high[across], high[up], low[up]
    y, x = top + clear, right + clear
    axes.annotate("", (left, y), (right, y), arrowprops=arrow)
    middle = ((left + right) / 2, y)
    axes.annotate(f"{right - left:.1f}", middle, (0, 2), ha="center", va="bottom", **text)
    axes.annotate("", (x, bottom), (x, top), arrowprops=arrow)
    axes.annotate(f"{top - bottom:.1f}", (x, (bottom + top) / 2), (3, 0), va="center", **text)


def _write_table(axes: "Axes", space: Any, shown: dict[str, float]) -> None:
    axes.axis("off")
    rows = []
    for name, factor in shown.items():
        one = space[name]
        scale, unit = (1000, "mm") if one.unit == "m" else (1, one.unit)
        own = scale * one.nominal
        rows.append([name, f"{own:.1f}", f"{own * factor:.1f}", unit, f"{factor:.3f}"])
    table = axes.table(
        rows,
        colLabels=["dimension", "original", "design", "unit", "factor"],
        colWidths=[0.3, 0.2, 0.2, 0.1, 0.2],
        cellLoc="right",
        loc="center",
        edges="horizontal",
    )
    table.auto_set_font_size(False)
    table.set_fontsize(6.5)
    for cell in table.get_celld().values():
        cell.set_linewidth(0.4)

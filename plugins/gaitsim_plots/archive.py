"""Plot an archive: the best score in each cell of its axes."""

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, NothingToPlotError
from gaitsim.plugin.pictures import (
    WIDTH,
    ArchiveView,
    Theme,
    add_heading,
    colour_scale_low,
    format_number,
    heading_of_run,
    require_archive,
    rows_of_panels,
    shorten,
    styled,
)
from gaitsim.plugin.runs import Member, RunSnapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure


_MAX_SEPARATE = 4  # maximum number of axes with separate panels; more axes give a matrix of panels
_MAX_AXES = 10  # maximum number of axes, which have 45 panels
_COLOURS = "viridis"
_MAX_PARTS = 1_000, 1_000  # maximum cells along both axes of a panel
_MAX_VECTORS = 20_000  # maximum cells of a panel as vectors in SVG and PDF; more are a bitmap


def archive_figure(run: RunSnapshot, theme: Theme, axes: Sequence[str] = ()) -> "Figure":
    """Plot the scores of the elites in the cells of two axes; empty cells are blank.

    If the archive has more than two axes, each pair has a panel, in which a cell shows the best
    elite across all other axes. If it has more than four, the panels form half a matrix. The best
    elite is marked.
    """
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    individual = run.individual(Member(1)) if run.experiment.search.keeps else run.individual()
    require_archive(individual)
    archive = ArchiveView.of(run.members)
    if archive is None:
        raise NothingToPlotError("the search does not provide the cells of its archive")
    panels = _panels(archive.names, axes)
    labels = {name: _label(name, individual.unit_of(name)) for name in archive.names}
    score = _label("score", individual.experiment.fitness.unit)
    scores = archive.members.scores
    shown = np.concatenate([archive.panel(*one, most=_MAX_PARTS).scores.ravel() for one in panels])
    low, extended = colour_scale_low(shown[np.isfinite(shown)])
    norm = Normalize(low, max(float(scores.max()), low + 1e-9))
    with styled(theme):
        matrix = len(panels) > 1 and len(archive.names) > _MAX_SEPARATE
        figure = Figure(figsize=_size(len(panels), matrix))
        places = (
            _triangle(figure, len(archive.names))
            if matrix
            else rows_of_panels(figure, len(panels), min(len(panels), 3))
        )
        drawn: Any = None
        for place, names in zip(places, panels, strict=True):
            place.set_xlabel(labels[names[0]])
            if len(names) == 1:
                _draw_steps(place, archive, names[0], theme)
                place.set_ylabel(score)
                continue
            drawn = _draw_cells(place, archive, names, norm)
            place.set_ylabel(labels[names[1]])
            _mark_best(place, archive, names, theme, 3 if matrix else 5)
            if matrix:
                place.label_outer()
        if drawn is not None:
            extend = "min" if extended else "neither"
            if matrix:
                # The bar is in the empty half of the matrix.
                beside = figure.add_axes((0.55, 0.8, 0.36, 0.015))
                bar = figure.colorbar(drawn, cax=beside, orientation="horizontal", extend=extend)
            else:
                bar = figure.colorbar(
                    drawn,
                    ax=places,
                    location="bottom",
                    aspect=40,
                    pad=0.02,
                    shrink=0.8 if len(panels) == 1 else 0.5,
                    extend=extend,
                )
            bar.outline.set_visible(False)
            bar.ax.tick_params(length=0)
            others = len(archive.names) > len(panels[0])
            bar.set_label(f"{score}{', the best across the other axes' * others}", fontsize=7)
        more = f", generation {run.generation}, {len(scores):,} of {archive.total:,} cells"
        add_heading(
            figure,
            heading_of_run(run.path.resolve().name, run.experiment, more, figure.get_figwidth()),
            *places[0].get_legend_handles_labels(),
        )
    return figure


def _panels(known: Sequence[str], asked: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the names of the axes of each panel."""
    unknown = [name for name in asked if name not in known]
    if unknown or len(set(asked)) < len(asked):
        what = f"the archive has no axis {unknown[0]!r}" if unknown else "an axis is given twice"
        raise GaitsimError(what, where="--axes", allowed=", ".join(known))
    if asked or len(known) == 1:
        return [tuple(asked or known)]
    if len(known) > _MAX_AXES:
        raise NothingToPlotError(
            f"too many axes to plot: {len(known)}, which have "
            f"{len(known) * (len(known) - 1) // 2} pairs",
            allowed=f"at most {_MAX_AXES} axes at once",
            remedy=f"choose two, such as --axes '{known[0]}' '{known[1]}'",
        )
    if len(known) > _MAX_SEPARATE:  # row after row of the matrix
        return [(across, up) for row, up in enumerate(known) for across in known[:row]]
    return list(combinations(known, 2))


def _size(panels: int, matrix: bool) -> tuple[float, float]:
    """Return the width and height of the figure, inches."""
    if matrix:
        return 2.1 * WIDTH, 2.1 * WIDTH
    return (WIDTH, 3.2) if panels == 1 else (2.1 * WIDTH, 1.1 + 2.2 * -(-panels // 3))


def _triangle(figure: "Figure", axes: int) -> "list[Axes]":
    """Return the panels below the diagonal, row by row; the panels of a column share their axis."""
    places = figure.subplots(axes - 1, axes - 1, sharex="col", sharey="row")
    for row, column in zip(*np.triu_indices(axes - 1, 1), strict=True):
        places[row, column].remove()
    return [places[row, column] for row, column in zip(*np.tril_indices(axes - 1), strict=True)]


def _label(name: str, unit: str) -> str:
    return f"{shorten(name, 32)} ({unit})" if unit else shorten(name, 40)


def _draw_cells(
    axes: "Axes", archive: ArchiveView, names: tuple[str, ...], norm: "Normalize"
) -> Any:
    """Draw the cells of two axes; return the artist for the colour bar."""
    across, up = names
    axes.grid(visible=False)
    ends = [archive.borders[name][[0, -1]] for name in names]
    axes.set(xlim=ends[0], ylim=ends[1])
    centroids = archive.members.centroids
    if centroids is not None and len(archive.names) == 2:
        from matplotlib.collections import PolyCollection

        cells = archive.cells[:, 0]
        columns = [archive.names.index(name) for name in names]
        shapes = polygons(centroids[:, columns], np.array(ends))
        drawn = PolyCollection([shapes[cell] for cell in cells], norm=norm, cmap=_COLOURS)
        drawn.set_array(archive.members.scores)
        drawn.set(edgecolor="face", linewidth=0.2, rasterized=len(cells) > _MAX_VECTORS)
        axes.add_collection(drawn, autolim=False)
        return drawn
    panel = archive.panel(across, up, most=_MAX_PARTS)
    return axes.pcolormesh(
        *panel.borders,
        np.ma.masked_invalid(panel.scores.T),
        norm=norm,
        cmap=_COLOURS,
        rasterized=panel.scores.size > _MAX_VECTORS,
    )


def _draw_steps(axes: "Axes", archive: ArchiveView, name: str, theme: Theme) -> None:
    """Draw the score in each cell of one axis."""
    panel = archive.panel(name, most=_MAX_PARTS)
    axes.stairs(panel.scores, *panel.borders, baseline=None, color=theme.colours[0])
    axes.set_xlim(*archive.borders[name][[0, -1]])


def _mark_best(
    axes: "Axes", archive: ArchiveView, names: tuple[str, ...], theme: Theme, size: float
) -> None:
    members = archive.members
    best = int(np.argmax(members.scores))
    ends = [archive.borders[name][[0, -1]] for name in names]
    place = [
        np.clip(members.values[name][best], *end) for name, end in zip(names, ends, strict=True)
    ]
    label = f"best score, {format_number(float(members.scores[best]))}: member {best + 1}"
    # A wider outline in the background colour makes the mark visible on any colour.
    for colour, width, order, named in (
        (theme.background, 2.2, 4, None),
        (theme.ink, 1.0, 5, label),
    ):
        axes.plot(
            *place,
            linestyle="",
            marker="D",
            markersize=size,
            markerfacecolor="none",
            markeredgecolor=colour,
            markeredgewidth=width,
            clip_on=False,
            zorder=order,
            label=named,
        )


def polygons(centres: NDArray[np.float64], ends: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the cell of each centre, clipped to a rectangle.

    Distances are relative to the sides of the rectangle. Mirroring the centres at the four sides
    makes the sides borders of cells.

    Args:
        centres: centres of the cells, inside the rectangle, (cells, 2).
        ends: low and high end of both axes, (2, 2).

    Returns:
        The corners of each cell in order, (corners, 2) each.
    """
    from scipy.spatial import Voronoi

    low, width = ends[:, 0], ends[:, 1] - ends[:, 0]
    shares = (centres - low) / width
    x, y = shares.T
    mirrored = [(-x, y), (2 - x, y), (x, -y), (x, 2 - y)]
    points = np.concatenate([shares, *(np.stack(image, 1) for image in mirrored)])
    found = Voronoi(points)
    corners = low + np.clip(found.vertices, 0, 1) * width
    return [corners[found.regions[region]] for region in found.point_region[: len(centres)]]

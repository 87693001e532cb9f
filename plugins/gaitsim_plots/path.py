"""Plot the path of a body from above and from the side, with the body drawn at a few moments."""

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import NothingToPlotError, Skeleton
from gaitsim.plugin.gait import Floats, count_trials
from gaitsim.plugin.pictures import (
    WIDTH,
    Theme,
    add_heading,
    heading_of,
    mix,
    round_step,
    shown_unit,
    styled,
    window_slice,
)
from gaitsim.plugin.runs import Individual

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MAX_MOMENTS = 6  # maximum number of moments at which the body is drawn
_MIN_BODY_SIZE = 0.07  # minimum size of a drawn body, as a share of the path
_SEPARATE = 1.15  # distance between drawn bodies, as a share of their size
# Size of a path, as a share of the body's size, below which the body stands still, and below which
# the body would hide it.
_STILL, _HIDDEN = 0.01, 0.1
_MIN_EXTENT = 1e-6  # m; anything smaller is a point
_SLIM, _FLAT = 0.4, 0.16  # minimum ratios of the sides of a panel; flat panels are above each other
_TALL = 1.5  # ratio of height to width from which the panels are side by side
_MARGIN = 0.06  # margin in a panel, as a share of its larger side
_SHADES = 48  # number of shades of a path, from its start to its end


@dataclass(frozen=True, eq=False)
class PathScene:
    """The path and the bodies to draw.

    Attributes:
        path: path of the body, (frames, 3) m.
        bodies: segments of the body at each moment, (moments, segments, 2, 3) m; no moment if the
            body is larger than the path that it would hide.
        at: frames of the moments, (moments,), of which the first is the start.
        size: size of the body, m.
        factor: enlargement of the bodies.
    """

    path: Floats
    bodies: Floats
    at: NDArray[np.intp]
    size: float
    factor: float

    @property
    def planar(self) -> bool:
        """Whether the body is a line along x when seen from above."""
        long, wide = np.ptp(self.bodies[..., :2].reshape(-1, 2), axis=0) if len(self.at) else (0, 1)
        return bool(wide <= _MIN_EXTENT * long)

    def separate(self, shown: tuple[int, int]) -> NDArray[np.intp]:
        """Return the indices of the bodies that do not overlap in the view of two axes."""
        places = self.path[self.at][:, shown]
        return _far_apart(places, _SEPARATE * self.size * self.factor)


def path_figure(
    individual: Individual, theme: Theme, window: tuple[float, float] | None = None
) -> "Figure":
    """Plot the path from above and from the side, with the same scale along both axes.

    A planar body, which is a line from above, is drawn only from the side.
    """
    skeleton = individual.skeleton
    part = window_slice(len(skeleton.segments), skeleton.frame_rate, window)
    scene = scene_of(skeleton, part)
    if scene is None:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} cannot be drawn: no frame of its "
            "skeleton is finite",
            where=str(individual.source),
        )
    along = int(np.argmax(np.ptp(scene.path[:, :2], axis=0)))  # the side view shows the travel
    views = {"from the side": (along, 2)}
    if not scene.planar:
        views = {"from above": (0, 1), **views}
    with styled(theme):
        figure, panels = _panels(scene, [*views.values()])
        for axes, (title, shown) in zip(panels, views.items(), strict=True):
            _draw_view(axes, scene, shown, theme)
            axes.set_title(title, fontsize=7, pad=2)
        if not len(scene.at):
            panels[0].set_title(f"{next(iter(views))}; body not drawn", fontsize=7, pad=2)
        handles, labels = panels[0].get_legend_handles_labels()
        if (trials := count_trials(individual)) > 1:
            labels[0] += f", first of {trials} trials"
        text = heading_of([individual])
        if scene.factor > 1:
            text += f"; body × {scene.factor:g}"
        add_heading(figure, text, handles, labels)
    return figure


def scene_of(skeleton: Skeleton, part: slice) -> PathScene | None:
    """Return the scene of a part of a motion; None if no frame of it is finite.

    The body is drawn at the start, and wherever it does not overlap an earlier drawing.
    """
    whole = np.isfinite(skeleton.segments[part]).all(axis=(1, 2, 3))
    whole &= np.isfinite(skeleton.path[part]).all(axis=1)
    if not whole.any():
        return None
    segments = np.asarray(skeleton.segments[part][whole], dtype=np.float64)
    path = np.asarray(skeleton.path[part][whole], dtype=np.float64)
    size = float(np.ptp(segments[0].reshape(-1, 3), axis=0).max())
    across = float(np.ptp(path, axis=0).max())
    factor = 1.0
    if 0 < size < _MIN_BODY_SIZE * across:
        factor = round_step(_MIN_BODY_SIZE * across / size)
    room = _SEPARATE * size * factor
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    count = min(MAX_MOMENTS, 1 + int(across / room)) if room > 0 else 1
    at = np.searchsorted(gone, np.linspace(0, gone[-1], count) - 1e-12)
    at = at[np.sort(_far_apart(path[at], room))]
    if _STILL * size < across < _HIDDEN * size:
        at = at[:0]
    bodies = path[at, None, None] + factor * (segments[at] - path[at, None, None])
    return PathScene(path, bodies, at, size, factor)


def _far_apart(places: Floats, least: float) -> NDArray[np.intp]:
    """Return the index of the first place, and repeatedly of the one farthest from all chosen."""
    chosen = [0][: len(places)]
    while chosen and least > 0:
        away = np.linalg.norm(places - places[chosen, None], axis=-1).min(axis=0)
        if away.max() < least:
            break
        chosen.append(int(away.argmax()))
    return np.array(chosen, dtype=np.intp)


def _panels(scene: PathScene, views: list[tuple[int, int]]) -> tuple["Figure", "list[Axes]"]:
    """Create a panel for each view, above each other, or side by side if the motion is tall."""
    from matplotlib.figure import Figure

    points = np.concatenate([scene.path, scene.bodies.reshape(-1, 3)])
    low, high = points.min(axis=0), points.max(axis=0)
    if low[2] > -1e-9 and low[2] < high[2] - low[2]:
        low[2] = 0.0  # include the ground
    middle, extent = (low + high) / 2, np.maximum(high - low, _MIN_EXTENT)
    sizes = []
    for shown in views:
        size = extent[[*shown]] + 2 * _MARGIN * extent[[*shown]].max()
        sizes.append(size)
    tall = sizes[-1][1] > _TALL * sizes[-1][0]
    least = np.array([_SLIM, _SLIM if tall else _FLAT])
    sizes = [np.maximum(size, size[::-1] * least) for size in sizes]
    inches = 2.75
    if tall:
        figure = Figure(figsize=(WIDTH, 4.0))
        panels = [*figure.subplots(1, len(views), squeeze=False).ravel()]
    else:
        heights = [float(np.clip(inches * size[1] / size[0], 0.4, 2.75)) for size in sizes]
        figure = Figure(figsize=(WIDTH, 0.35 + sum(heights) + 0.55 * len(views)))
        panels = [*figure.subplots(len(views), 1, height_ratios=heights, squeeze=False).ravel()]
    for axes, shown, size in zip(panels, views, sizes, strict=True):
        factor, unit = shown_unit("m", points)
        centre = middle[[*shown]]
        axes.set_xlim(*factor * (centre[0] + np.array([-0.5, 0.5]) * size[0]))
        axes.set_ylim(*factor * (centre[1] + np.array([-0.5, 0.5]) * size[1]))
        across, up = ("xyz"[axis] for axis in shown)
        axes.set_xlabel(f"{across} ({unit})")
        axes.set_ylabel(f"{up} ({unit})")
        axes.set_aspect("equal", adjustable="box", anchor="N" if tall else "W")
    return figure, panels


def _draw_view(axes: "Axes", scene: PathScene, shown: tuple[int, int], theme: Theme) -> None:
    """Draw the view of two axes: bodies and path, of which later parts are darker, and marks."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import to_rgb

    factor, _ = shown_unit("m", np.concatenate([scene.path, scene.bodies.reshape(-1, 3)]))
    ink, paper, green = (
        np.array(to_rgb(colour)) for colour in (theme.ink, theme.background, theme.colours[0])
    )
    kept = np.sort(scene.separate(shown))
    times = scene.at[kept] / max(len(scene.path) - 1, 1)
    # Colours are mixed, as transparent lines would show a dot wherever two of them meet.
    for body, colour in zip(
        scene.bodies[kept][..., shown], mix(paper, ink, 0.3 + 0.6 * times), strict=True
    ):
        lines = LineCollection([*(factor * body)], colors=[tuple(colour)], linewidths=0.8, zorder=2)
        lines.set_capstyle("round")
        axes.add_collection(lines, autolim=False)
    path = factor * scene.path[:, shown]
    shades = min(_SHADES, max(len(path) - 1, 1))
    ends = np.linspace(0, len(path) - 1, shades + 1).round().astype(int)
    parts = [path[first : last + 1] for first, last in pairwise(ends.tolist())]
    shares = np.linspace(0.35, 1.0, shades)
    axes.add_collection(
        LineCollection(
            parts,
            colors=[tuple(colour) for colour in mix(paper, green, shares)],
            linewidths=1.2,
            zorder=3,
        ),
        autolim=False,
    )
    axes.plot([], [], color=theme.colours[0], linewidth=1.2, label="path")
    for place, marker, face, name in (
        (path[0], "o", theme.background, "start"),
        (path[-1], "s", theme.colours[0], "end"),
    ):
        axes.plot(
            *place,
            marker=marker,
            linestyle="",
            markersize=4,
            markerfacecolor=face,
            markeredgecolor=theme.colours[0],
            label=name,
            zorder=4,
        )

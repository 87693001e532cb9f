"""The ground and the bodies on it, seen by one camera."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.render.plots.labels import format_number
from gaitsim.render.scene.camera import DISTANCE, VIEWS, Camera, axes, fit_box
from gaitsim.render.scene.clip import Pose, Race
from gaitsim.render.scene.ground import fine_step, grid, steps
from gaitsim.render.scene.labels import (
    MIN_LETTERS,
    POINT,
    ROW,
    Labels,
    relative_size,
    small_letters,
    text_path,
)
from gaitsim.render.scene.pixels import GridLines
from gaitsim.render.scene.runner import Runner
from gaitsim.render.scene.themes import SceneTheme

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MIN_NUMBER_GAP = 70.0  # minimum pixels between numbers
DIVISIONS = 5  # divisions between two numbers


class AltitudeScale:
    """A ruler at the right edge of the picture, at the scale of the bodies.

    Args:
        figure: figure to draw in.
        size: width and height of the picture, pixels.
        theme: colours of the picture.
        colours: colour of each body's pointer.
        scale: pixels per metre of altitude.
        unit: size of the picture; see `relative_size`.
    """

    def __init__(
        self,
        figure: "Figure",
        size: tuple[int, int],
        theme: SceneTheme,
        colours: Sequence[str],
        scale: float,
        unit: float,
    ) -> None:
        from matplotlib.collections import LineCollection, PathCollection, PolyCollection
        from matplotlib.transforms import IdentityTransform

        width, height = size
        self._right = width - 22 * unit
        # Between the title and the clock.
        self._low, self._high = 0.16 * height, 0.84 * height
        self._scale, self._unit = scale, unit
        self._step = steps(MIN_NUMBER_GAP * unit / scale)[0]
        self._size = max(14 * unit, MIN_LETTERS)
        self._ticks = LineCollection([], colors=theme.faint, linewidths=1.2 * unit * POINT)
        self._numbers = PathCollection([], facecolors=theme.faint, edgecolors="none")
        self._pointer = PolyCollection([], facecolors=colours, edgecolors="none")
        for artist in (self._ticks, self._numbers, self._pointer):
            artist.set_transform(IdentityTransform())
            artist.set_zorder(8)
            figure.add_artist(artist)

    def show(self, altitudes: Sequence[float], altitude: float, at: float) -> None:
        """Move the ruler.

        Args:
            altitudes: altitudes of the bodies, m.
            altitude: altitude shown at the height `at` in the picture, m.
            at: height in the picture, pixels.
        """
        at = float(np.clip(at, self._low, self._high))
        fine = self._step / DIVISIONS
        first = int(np.ceil(altitude / fine + (self._low - at) / (fine * self._scale)))
        last = int(np.floor(altitude / fine + (self._high - at) / (fine * self._scale)))
        number = np.arange(first, last + 1)
        y = at + (number * fine - altitude) * self._scale
        long = number % DIVISIONS == 0
        length = np.where(long, 14, 7) * self._unit
        ticks = np.empty((len(number), 2, 2))
        ticks[:, 0, 0], ticks[:, 1, 0] = self._right - length, self._right
        ticks[..., 1] = y[:, None]
        line = np.array([[[self._right, self._low], [self._right, self._high]]])
        self._ticks.set_segments([*line, *ticks])
        right = self._right - 22 * self._unit
        self._numbers.set_paths(
            [
                text_path(
                    f"{format_number(value)} m",
                    self._size,
                    (right, height - 0.36 * self._size),
                    1.0,
                )
                for value, height in zip(number[long] * fine, y[long], strict=True)
            ]
        )
        heights = at + (np.array(altitudes) - altitude) * self._scale
        heights = np.clip(heights, self._low, self._high)[:, None, None]
        wide = 9 * self._unit
        tip = np.array([[0.0, 0.0], [1.4 * wide, wide], [1.4 * wide, -wide]])
        tip[:, 0] += self._right + 2 * self._unit
        self._pointer.set_verts([*(tip + heights * np.array([0.0, 1.0]))])


FILLED = 0.56, 0.52  # shares of the picture's width and height that a single body may fill
FILLED_BY_ALL = 0.8, 0.6  # shares that several bodies may fill together
MIN_BODY_SIZE = 0.08  # minimum size of each of several bodies, as a share of the picture's height
MAX_LEAD = 0.3  # maximum distance of the leader from the middle, as a share of that height
MIN_ELEVATION = 24.0  # minimum elevation of the camera for several bodies, degrees


class World:
    """Everything in a picture except its background.

    Args:
        figure: figure to draw in, at `DPI`.
        size: width and height, pixels.
        race: the bodies.
        theme: colours of the picture.
        view: name of a view in `VIEWS`.
        heading: first and second line of text.
    """

    def __init__(
        self,
        figure: "Figure",
        size: tuple[int, int],
        race: Race,
        theme: SceneTheme,
        view: str,
        heading: tuple[str, str],
    ) -> None:
        from matplotlib.transforms import IdentityTransform

        width, height = size
        self.race, self.clips = race, race.clips
        self._figure, self._identity = figure, IdentityTransform()
        self._unit = relative_size(width, height)
        self._reach = 0.75 * float(np.hypot(width, height))
        if view == "top" and all(clip.planar for clip in self.clips):
            view = "side"
        several = len(self.clips) > 1
        rows = ROW * small_letters(size) * len(self.clips) if several else 0.0
        self._centre = np.array([width / 2, (height - rows) / 2])
        azimuth, elevation = VIEWS[view]
        self.angles = azimuth, max(elevation, MIN_ELEVATION) if several else elevation
        box, (across, above) = race.box, FILLED_BY_ALL if several else FILLED
        self.scale, self.middle = fit_box(
            box, self.angles, across * width, above * height - rows / 2, view
        )
        self._extent = max(float(np.ptp(box, axis=0).max()), race.span) if several else race.span
        if several and self.scale * race.span < MIN_BODY_SIZE * height:
            self.scale = MIN_BODY_SIZE * height / race.span
            race.room = MAX_LEAD * height / self.scale
            self.middle = np.zeros(3)
            self._extent = height / self.scale
        self.grid = self._add(GridLines(theme, 0.8 * 1.3 * self._unit), 2)
        colours = [theme.body(number) for number in range(len(self.clips))]
        self.runners = [
            Runner(self._add, clip, theme, colour, self._unit, size)
            for clip, colour in zip(self.clips, colours, strict=True)
        ]
        rise = self.scale * float(np.cos(np.radians(self.angles[1])))
        upright = any(clip.flies for clip in self.clips) and rise > 0.5 * self.scale
        self.altitude_scale = (
            AltitudeScale(figure, size, theme, colours, rise, self._unit) if upright else None
        )
        step = fine_step(self.scale, self._unit)
        self.labels = Labels(figure, size, self.clips, theme, colours, step, heading)

    def _add(self, artist: Any, order: int) -> Any:
        artist.set_transform(self._identity)
        self._figure.add_artist(artist, clip=False)
        artist.set_zorder(order)
        return artist

    def show(self, seconds: float, turned: float = 0.0) -> None:
        """Move everything to its position at a moment.

        Args:
            seconds: time since the clips began.
            turned: angle of the camera around the bodies, degrees.
        """
        poses = [clip.at(seconds) for clip in self.clips]
        azimuth, elevation = self.angles
        camera = Camera(
            self.race.aim(poses) + self.middle,
            *axes(azimuth + turned, elevation),
            distance=DISTANCE * self._extent,
            scale=self.scale,
            centre=self._centre,
        )
        lead = self.clips[self.race.leader]
        ends, strength = grid(camera, self._extent, self._reach, self._unit, lead.corners)
        self.grid.show(camera, lead.on_ground(ends), strength)
        self._show_runners(camera, poses)
        if self.altitude_scale:
            altitudes = [
                float(pose.middle[2]) + clip.floor
                for clip, pose in zip(self.clips, poses, strict=True)
            ]
            at = float(camera.project(poses[self.race.leader].middle)[0][1])
            self.altitude_scale.show(altitudes, altitudes[self.race.leader], at)
        self.labels.set_clock(poses, seconds)

    def _show_runners(self, camera: Camera, poses: Sequence[Pose]) -> None:
        """Show the bodies, with near ones in front of far ones."""
        depths = [float(camera.project(pose.middle)[1]) for pose in poses]
        order = np.argsort(np.argsort(depths)[::-1]) if len(poses) > 1 else [0]
        for runner, pose, place in zip(self.runners, poses, order, strict=True):
            runner.show(camera, pose, self._reach, int(place))

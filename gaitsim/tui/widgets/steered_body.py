"""A steered body, and its path from above."""

from typing import ClassVar

import numpy as np
from rich.style import Style

from gaitsim.render.scene.clip import Clip
from gaitsim.render.terminal.body import draw_body
from gaitsim.render.terminal.chase import VIEWS, chase_camera, draw_path
from gaitsim.steering import Drive
from gaitsim.tui.widgets.canvas import CLOSER, BodyCanvas
from gaitsim.tui.widgets.cells import Cells, Picture

TURN_SHARE = 0.15  # of the angle to the body's heading that the camera turns per frame


class SteeredBody(BodyCanvas, can_focus=False):
    """A steered body, seen by a camera that turns with it.

    Attributes:
        camera: name of the camera, one of `gaitsim.render.terminal.chase.VIEWS`.
        zoom: zoom factor; 1 for the default distance.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message=message)
        self.camera = next(iter(VIEWS))
        self.zoom = 1.0
        self._length = 1.0
        self._turned = self._looking = 0.0

    def show(self, drive: Drive, turned: float) -> None:
        """Show the current state of a body.

        Args:
            drive: simulated body.
            turned: heading relative to that at the start, positive to the left, radians.
        """
        self._turned = turned
        away = (turned - self._looking + np.pi) % (2 * np.pi) - np.pi
        self._looking += TURN_SHARE * away
        self._body = Clip(drive.skeleton)
        self._length = drive.size
        self.redraw()

    def reset_heading(self) -> None:
        """Turn the camera to the initial heading immediately."""
        self._looking = 0.0

    def picture(self, columns: int, rows: int) -> Picture:
        clip = self._body
        assert clip is not None, "else the placeholder is shown"
        pose = clip.at(clip.seconds)
        eye = chase_camera(
            self.camera, self._looking, pose.aim, self._length, self.zoom, columns, rows
        )
        return draw_body(eye, clip, pose, self._turned, columns, rows)

    def next_camera(self) -> None:
        """Switch to the next camera."""
        names = [*VIEWS]
        self.camera = names[(names.index(self.camera) + 1) % len(names)]
        self.redraw()

    def zoom_by(self, steps: int) -> None:
        """Zoom in, or out for negative steps."""
        self.zoom = min(max(self.zoom * CLOSER**steps, 0.25), 4.0)
        self.redraw()

    def action_zoom(self, steps: int) -> None:
        self.zoom_by(steps)


class PathPlan(Cells):
    """The path of a steered body from above."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"path--way", "path--body", "path--scale"}
    DEFAULT_CSS = """
    PathPlan {
        height: 1fr;
        & > .path--way { color: $success; }
        & > .path--body { color: $foreground; text-style: bold; }
        & > .path--scale { color: $foreground 60%; }
    }
    """

    def __init__(self) -> None:
        super().__init__()
        self._path = np.zeros((1, 3))
        self._turned, self._length = 0.0, 1.0

    def show(self, drive: Drive, turned: float) -> None:
        """Show the path of a body; `turned` as in `SteeredBody.show`."""
        self._path, self._turned = drive.path, turned
        self._length = drive.size
        self.redraw()

    def picture(self, columns: int, rows: int) -> Picture:
        return draw_path(self._path, self._turned, self._length, columns, rows)

    def ink_styles(self) -> list[Style]:
        """Return the styles of blank, path, body and scale."""
        parts = ("path--way", "path--body", "path--scale")
        return [self.ink_style(), *map(self.ink_style, parts)]

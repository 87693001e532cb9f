"""A widget that plays a moving body, drawn in braille dots."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from rich.style import Style
from textual import events
from textual.geometry import Offset
from textual.message import Message
from textual.reactive import reactive

from gaitsim.contracts import Skeleton
from gaitsim.errors import GaitsimError
from gaitsim.render.scene.clip import Clip
from gaitsim.render.terminal import body
from gaitsim.render.terminal.body import Viewpoint
from gaitsim.tui.keys import bindings
from gaitsim.tui.widgets.cells import Cells, Picture

FPS = 20
TURN = 10.0  # degrees per key press
DRAG = 3.0, 5.0  # degrees per column and row of a mouse drag
CLOSER = 1.25  # zoom factor per key press or notch of the mouse wheel
FOG = 0.55, 0.25, 0.0  # shares of the background in the limbs' colours, farthest first
_SIDES = ("middle", "left", "right")


class BodyCanvas(Cells, can_focus=True):
    """A skeleton in motion, seen by a camera that the user moves around it.

    Dragging turns the view and scrolling zooms, as do keys when the widget has the focus. The
    motion repeats at `speed` times real time, and pauses while another screen is shown.

    Args:
        skeleton: first skeleton; None shows `message`.
        message: message shown without a body.
        fps: maximum frames per second.
        clock: function that returns the time in seconds, for tests.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "canvas--ground",
        "canvas--track",
        "canvas--middle",
        "canvas--left",
        "canvas--right",
        "canvas--damaged",
        "canvas--label",
    }
    DEFAULT_CSS = """
    BodyCanvas {
        width: 1fr; height: 1fr; min-height: 3;
        & > .canvas--ground { color: $foreground 30%; }
        & > .canvas--track { color: $success; }
        & > .canvas--middle { color: $foreground; }
        & > .canvas--left { color: $primary; }
        & > .canvas--right { color: $warning; }
        & > .canvas--damaged { color: $error; }
        & > .canvas--label { color: $foreground 80%; }
    }
    """
    BINDINGS = bindings("canvas")

    seconds: reactive[float] = reactive(0.0, repaint=False, init=False)
    view: reactive[Viewpoint] = reactive(Viewpoint(), repaint=False, init=False)
    playing: reactive[bool] = reactive(False, repaint=False, init=False)
    speed: reactive[float] = reactive(1.0, repaint=False, init=False)
    ground: reactive[bool] = reactive(True, repaint=False, init=False)

    @dataclass
    class FrameShown(Message):
        """Posted when a different frame is shown."""

        canvas: "BodyCanvas"

    @dataclass
    class ViewChanged(Message):
        """Posted when the camera has moved."""

        view: Viewpoint

    def __init__(
        self,
        skeleton: Skeleton | None = None,
        *,
        message: str = "no body yet",
        fps: float = FPS,
        clock: Callable[[], float] = time.monotonic,
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        self._body: Clip | None = None
        self._message = message
        self._clock, self._fps = clock, fps
        self._last_tick = 0.0
        self._dragged_from: Offset | None = None
        if skeleton is not None:
            self.set_skeleton(skeleton)

    def set_skeleton(self, skeleton: Skeleton | None, message: str = "no body yet") -> None:
        """Replace the body; keep the camera, and the time modulo the new duration.

        If the body cannot be drawn, the reason is shown.
        """
        self._body, self._message = None, message
        if skeleton is not None:
            try:
                self._body = Clip(skeleton)
            except GaitsimError as error:
                self._message = str(error)
        if self.seconds > self.duration:
            self.seconds = self.seconds % self.duration if self.duration else 0.0
        self.redraw()

    def show_message(self, message: str) -> None:
        """Set the message that is shown without a body, such as 'reading the run …'."""
        self._message = message
        if self._body is None:
            self.redraw()

    @property
    def skeleton(self) -> Skeleton | None:
        """The skeleton shown; None without one."""
        return self._body.skeleton if self._body else None

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return self._body.seconds if self._body else 0.0

    @property
    def frames(self) -> int:
        """The number of frames."""
        return len(self._body.skeleton.segments) if self._body else 0

    @property
    def frame(self) -> int:
        """The frame at the current time, rounded down."""
        if self._body is None:
            return 0
        # Tolerate rounding errors in the time of a frame.
        at = int(self.seconds * self._body.skeleton.frame_rate + 1e-6)
        return min(at, self.frames - 1)

    def show_frame(self, frame: int) -> None:
        """Show a frame, clipped to the motion."""
        if self._body is not None:
            frame = min(max(frame, 0), self.frames - 1)
            self.seconds = frame / self._body.skeleton.frame_rate

    def on_mount(self) -> None:
        self._timer = self.set_interval(1 / self._fps, self._tick, pause=not self.playing)
        self._last_tick = self._clock()

    def _tick(self) -> None:
        now = self._clock()
        elapsed, self._last_tick = now - self._last_tick, now
        # A tick may have been due when the motion was paused.
        if not (self.playing and self.duration) or self.screen is not self.app.screen:
            return
        self.seconds = (self.seconds + elapsed * self.speed) % self.duration
        self.post_message(self.FrameShown(self))

    def watch_playing(self, playing: bool) -> None:
        if not self.is_mounted:
            return
        self._last_tick = self._clock()
        if playing:
            self._timer.resume()
        else:
            self._timer.pause()

    def watch_seconds(self) -> None:
        self.redraw()

    def watch_ground(self) -> None:
        self.redraw()

    def watch_view(self, view: Viewpoint) -> None:
        self.redraw()
        if self.is_mounted:
            self.post_message(self.ViewChanged(view))

    def placeholder(self) -> str:
        return "" if self._body else self._message

    def picture(self, columns: int, rows: int) -> Picture:
        assert self._body is not None, "else the placeholder is shown"
        return body.picture(self._body, self.seconds, self.view, columns, rows, ground=self.ground)

    def ink_styles(self) -> list[Style]:
        """Return the styles of ground, track, limbs by shade and side, damage, feet, and labels."""
        parts = [f"canvas--{side}" for side in _SIDES]
        return [
            self.ink_style(),
            self.ink_style("canvas--ground"),
            self.ink_style("canvas--track"),
            *(self.ink_style(part, fog) for fog in FOG for part in parts),
            self.ink_style("canvas--damaged") + Style(bold=True),
            *(self.ink_style(part) + Style(bold=True) for part in parts),
            self.ink_style("canvas--label"),
        ]

    def action_turn(self, across: int, up: int) -> None:
        self.view = self.view.turned(-across * TURN, up * TURN)

    def action_zoom(self, steps: int) -> None:
        self.view = self.view.zoomed(CLOSER**steps)

    def action_follow(self) -> None:
        self.view = self.view.following(not self.view.follow)

    def action_next_view(self) -> None:
        self.view = self.view.next()

    def action_reset(self) -> None:
        self.view = Viewpoint()

    def on_mouse_down(self, event: events.MouseDown) -> None:
        self._dragged_from = event.screen_offset
        self.capture_mouse()
        event.stop()

    def on_mouse_up(self, event: events.MouseUp) -> None:
        self._dragged_from = None
        self.release_mouse()
        event.stop()

    def on_mouse_move(self, event: events.MouseMove) -> None:
        if self._dragged_from is not None:
            moved, self._dragged_from = (
                event.screen_offset - self._dragged_from,
                event.screen_offset,
            )
            across, up = DRAG
            self.view = self.view.turned(-moved.x * across, moved.y * up)

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self.action_zoom(1)
        event.stop()

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self.action_zoom(-1)
        event.stop()

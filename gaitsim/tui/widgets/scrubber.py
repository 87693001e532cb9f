"""A slider over frames or generations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from rich.text import Text
from textual import events
from textual.message import Message
from textual.reactive import reactive
from textual.widget import Widget

from gaitsim.tui.keys import bindings


class Scrubber(Widget, can_focus=True):
    """A whole number in a range, chosen by mouse or keys.

    Args:
        label: text before the slider.
        first: lowest number.
        last: highest number.
        value: initial number.
        format_value: function that formats the number after the slider.
    """

    ALLOW_SELECT = False
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "scrubber--label",
        "scrubber--done",
        "scrubber--rest",
        "scrubber--knob",
    }
    DEFAULT_CSS = """
    Scrubber {
        height: 1; width: 1fr;
        & > .scrubber--label { color: $foreground; }
        & > .scrubber--done { color: $primary; }
        & > .scrubber--rest { color: $foreground 30%; }
        & > .scrubber--knob { color: $foreground; text-style: bold; }
        &:focus > .scrubber--knob { color: $accent; }
        &:focus > .scrubber--label { color: $accent; text-style: bold; }
    }
    """
    BINDINGS = bindings("scrubber")

    label: reactive[str] = reactive("", init=False)
    value: reactive[int] = reactive(0, init=False)
    first: reactive[int] = reactive(0, init=False)
    last: reactive[int] = reactive(0, init=False)

    @dataclass
    class Scrubbed(Message):
        """Posted when the user chooses a different number."""

        scrubber: "Scrubber"
        value: int

        @property
        def control(self) -> "Scrubber":
            return self.scrubber

    def __init__(
        self,
        label: str,
        first: int = 0,
        last: int = 0,
        value: int = 0,
        format_value: Callable[[int], str] = str,
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        self._format_value, self._held = format_value, False
        self.set_reactive(Scrubber.label, label)
        self.set_reactive(Scrubber.first, first)
        self.set_reactive(Scrubber.last, last)
        self.set_reactive(Scrubber.value, min(max(value, first), last))

    def validate_value(self, value: int) -> int:
        """Clip the value to the range."""
        return min(max(value, self.first), self.last)

    def set_range(self, first: int, last: int) -> None:
        """Set the range, and clip the value to it."""
        self.first, self.last = first, last
        self.value = min(max(self.value, first), last)

    def choose(self, value: int) -> None:
        """Set the value as if the user had chosen it."""
        before = self.value
        self.value = value
        if self.value != before:
            self.post_message(self.Scrubbed(self, self.value))

    def render(self) -> Text:
        start, width = self._bar()
        share = (self.value - self.first) / max(self.last - self.first, 1)
        knob = round(share * (width - 1))
        styles = {part: self.get_component_rich_style(f"scrubber--{part}", partial=True)
                  for part in ("label", "done", "rest", "knob")}  # fmt: skip
        text = Text(no_wrap=True, overflow="crop", end="")
        text.append(self.label.ljust(start), styles["label"])
        text.append("━" * knob, styles["done"])
        text.append("●", styles["knob"])
        text.append("─" * (width - 1 - knob), styles["rest"])
        text.append(f" {self._format_value(self.value)}")
        return text

    def _bar(self) -> tuple[int, int]:
        """Return the column and width of the slider, which are the same for all numbers."""
        start = len(self.label) + 1 if self.label else 0
        number = max(len(self._format_value(end)) for end in (self.first, self.last, self.value))
        return start, max(self.content_size.width - start - number - 1, 1)

    def action_step(self, steps: int) -> None:
        self.choose(self.value + steps)

    def action_end(self, last: bool) -> None:
        self.choose(self.last if last else self.first)

    def on_mouse_down(self, event: events.MouseDown) -> None:
        self._held = True
        self.capture_mouse()
        self._follow(event.x)

    def on_mouse_move(self, event: events.MouseMove) -> None:
        if self._held:
            self._follow(event.x)

    def on_mouse_up(self) -> None:
        self._held = False
        self.release_mouse()

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        self.action_step(1)
        event.stop()

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        self.action_step(-1)
        event.stop()

    def _follow(self, x: int) -> None:
        start, width = self._bar()
        left = self.gutter.left
        share = min(max((x - left - start) / max(width - 1, 1), 0.0), 1.0)
        self.choose(self.first + round(share * (self.last - self.first)))

"""A form of options, with bounds, units and descriptions from their declarations."""

from dataclasses import dataclass
from typing import ClassVar

from pydantic.fields import FieldInfo
from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.widgets import Input, Label, Select, Static

from gaitsim.errors import GaitsimError
from gaitsim.registry import options
from gaitsim.render.terminal.text import visible
from gaitsim.tui.builder import Option
from gaitsim.tui.formatting import clip

NAME = 22  # cells of an option's name


class Field(Vertical):
    """One option: its name, an input or a choice, and its unit, with its meaning below."""

    DEFAULT_CSS: ClassVar[str] = """
    Field { height: auto; margin-bottom: 1; }
    Field Horizontal { height: 1; }
    Field .field-name { width: 23; text-style: bold; }
    Field Input, Field Select { width: 30; }
    Field Input { background: $panel; padding: 0 1 !important; }
    Field Input:focus { background: $primary 25%; }
    Field .field-unit { width: 1fr; padding-left: 1; color: $text-muted; }
    Field .field-about { color: $text-muted; padding-left: 2; height: auto; }
    Field.-changed .field-name { color: $accent; }
    Field.-wrong .field-about { color: $error; }
    """

    @dataclass
    class Changed(Message):
        """Posted when the text of an option has changed; None stands for the preset's text."""

        key: str
        text: str | None

    def __init__(self, option: Option) -> None:
        super().__init__()
        self.option = option
        self._choices = options.choices(option.field)
        self.set_class(options.allowed(option.field) == "a string", "-text")

    def compose(self) -> ComposeResult:
        option = self.option
        name = option.key.rpartition(".")[2]
        with Horizontal():
            yield Label(Text(clip(name, NAME)), classes="field-name")
            if self._choices and option.text in self._choices:
                yield Select(
                    [(Text(choice), choice) for choice in self._choices],
                    value=option.text,
                    allow_blank=False,
                    compact=True,
                )
            else:
                unset = option.text == options.NOT_SET or (option.long and not self._is_changed)
                value = "" if unset else option.text
                yield Input(value, placeholder=_empty_value(option), compact=True)
            yield Label(Text(visible(options.unit(option.field))), classes="field-unit")
        yield Static(self._about(), classes="field-about")

    def on_mount(self) -> None:
        self.set_class(self._is_changed, "-changed")

    @property
    def _is_changed(self) -> bool:
        return self.option.text != self.option.preset

    def _about(self) -> Text:
        field: FieldInfo = self.option.field
        takes = (
            "" if self._choices else options.type_and_bounds(field)
        )  # the unit is beside the input
        if takes == "a string" and options.meaning(field):
            takes = ""
        parts = [part for part in (options.meaning(field), takes) if part]
        return Text(visible(" · ".join(parts)))

    def show_problem(self, problem: GaitsimError | None) -> None:
        """Show a short form of the problem below the input, or the option's description."""
        self.set_class(problem is not None, "-wrong")
        about = (
            self._about() if problem is None else Text(f"✗ {visible(self._short_problem(problem))}")
        )
        self.query_one(".field-about", Static).update(about)

    def _short_problem(self, problem: GaitsimError) -> str:
        """Return the allowed values of the option, or the problem if they do not explain it."""
        allowed = problem.allowed
        if allowed == options.allowed(self.option.field):
            return allowed
        parts = [problem.what, allowed and f"allowed: {allowed}", problem.remedy]
        return "; ".join(part for part in parts if part)

    @on(Input.Changed)
    def _typed(self, event: Input.Changed) -> None:
        event.stop()
        self._post(event.value or _empty_value(self.option))

    @on(Select.Changed)
    def _chosen(self, event: Select.Changed) -> None:
        event.stop()
        self._post(str(event.value))

    def _post(self, text: str) -> None:
        changed = text != self.option.preset
        self.set_class(changed, "-changed")
        self.post_message(self.Changed(self.option.key, text if changed else None))


def _empty_value(option: Option) -> str:
    """Return the meaning of an empty input: not set, or the preset's value."""
    unset = options.optional(option.field) and not option.long
    return options.NOT_SET if unset else option.preset

"""A dialog for the damage of a joint."""

from collections.abc import Callable, Sequence

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Label, Select, Static

from gaitsim.errors import GaitsimError
from gaitsim.tui.actions import bindings

INTACT = "intact"
# For each kind of damage: the quantity, its unit and an example.
VALUES = {
    "stuck": ("angle", "°; empty: standing pose", "20"),
    "slow": ("speed", "share that remains", "0.5"),
    "weak": ("torque", "share that remains", "0.5"),
}


class JointDialog(ModalScreen[tuple[str, str] | None]):
    """Ask for the damage of a joint; return the joint and the damage as text, '' for none.

    Args:
        joints: joints of the leg.
        current: current damage as text, by joint.
        check: function that raises a GaitsimError for damage that the body cannot have.
    """

    BINDINGS = bindings("joint")
    DEFAULT_CSS = """
    JointDialog {
        & .row { height: 1; margin-top: 1; }
        & .row Label { width: 10; text-style: bold; }
        & .row Select { width: 24; }
        & .row Input { width: 12; background: $panel; padding: 0 1 !important; }
        & .row #joint-unit { width: 1fr; text-style: none; padding-left: 1; color: $text-muted; }
        & #joint-text { margin-top: 1; height: auto; }
    }
    """

    def __init__(
        self, joints: Sequence[str], current: dict[str, str], check: Callable[[str, str], object]
    ) -> None:
        super().__init__()
        self._joints, self._current, self._check = joints, current, check

    def compose(self) -> ComposeResult:
        kinds = [INTACT, *VALUES]
        joint = next(iter(self._current), self._joints[0])
        kind, value = self._current_damage(joint)
        with Vertical(classes="dialog") as box:
            box.border_subtitle = "esc: cancel"
            yield Static("Damage a joint", classes="dialog-title")
            with Horizontal(classes="row"):
                yield Label("Joint")
                yield Select([(Text(one), one) for one in self._joints], value=joint,
                             allow_blank=False, compact=True, id="joint-name")  # fmt: skip
            with Horizontal(classes="row"):
                yield Label("Damage")
                yield Select([(one, one) for one in kinds], value=kind,
                             allow_blank=False, compact=True, id="joint-kind")  # fmt: skip
            with Horizontal(classes="row"):
                yield Label("Value", id="joint-value-name")
                yield Input(value, compact=True, id="joint-value")
                yield Label(id="joint-unit")
            yield Static(id="joint-text")
            with Horizontal(classes="dialog-buttons"):
                yield Button("OK", variant="primary", compact=True, id="joint-ok")
                yield Button("Cancel", compact=True, id="joint-cancel")

    def on_mount(self) -> None:
        self.query_one("#joint-kind").focus()
        self._show()

    def _current_damage(self, joint: str) -> tuple[str, str]:
        """Return the kind and value of a joint's current damage."""
        words = self._current.get(joint, "").removeprefix(joint).split()
        return (words[0], " ".join(words[1:])) if words else (INTACT, "")

    @property
    def joint(self) -> str:
        """The chosen joint."""
        return str(self.query_one("#joint-name", Select).value)

    @property
    def text(self) -> str:
        """The chosen damage in the syntax of `--damage`; '' for none."""
        kind = str(self.query_one("#joint-kind", Select).value)
        value = self.query_one("#joint-value", Input).value.strip()
        return "" if kind == INTACT else f"{self.joint} {kind} {value}".rstrip()

    @on(Select.Changed, "#joint-name")
    def _joint_changed(self) -> None:
        kind, value = self._current_damage(self.joint)
        self.query_one("#joint-kind", Select).value = kind
        self.query_one("#joint-value", Input).value = value
        self._show()

    @on(Select.Changed, "#joint-kind")
    @on(Input.Changed)
    def _show(self) -> bool:
        """Show the damage as text, or why the body cannot have it; return whether it can."""
        kind = str(self.query_one("#joint-kind", Select).value)
        name, unit, example = VALUES.get(kind, ("value", "", ""))
        field = self.query_one("#joint-value", Input)
        field.disabled, field.placeholder = kind == INTACT, example
        self.query_one("#joint-value-name", Label).update(name.capitalize())
        self.query_one("#joint-unit", Label).update(unit)
        message = self.query_one("#joint-text", Static)
        try:
            self._check(self.joint, self.text)
        except GaitsimError as error:
            message.update(Text(str(error)))
            message.set_class(True, "problem")
            return False
        message.update(Text(f"--damage '{self.text}'" if self.text else f"{self.joint} is intact"))
        message.set_class(False, "problem")
        return True

    @on(Input.Submitted)
    def _submit(self) -> None:
        if self._show():
            self.dismiss((self.joint, self.text))

    def on_button_pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "joint-ok":
            self._submit()
        else:
            self.dismiss()

"""Damage of a body: a plan of its legs to choose and remove them, and a dialog for its joints."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from rich.style import Style
from rich.text import Text
from textual import events, on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.reactive import reactive
from textual.widgets import Button, Input, Label, Select, Static

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.pictures import Plan, plan as drawing
from gaitsim.plugin.toolkit import Damage
from gaitsim.screen import Cells, Dialog, Picture, bindings

Legs = Mapping[str, tuple[str, ...]]
Choice = tuple[Damage, ...]
INTACT = "intact"
# For each kind of damage: the quantity, its unit and an example.
VALUES = {
    "stuck": ("angle", "°; empty: standing pose", "20"),
    "slow": ("speed", "share that remains", "0.5"),
    "weak": ("torque", "share that remains", "0.5"),
}


def toggle_leg(damage: Choice, leg: str, legs: Legs) -> Choice:
    """Return the damage with a leg lost, or restored if it was lost, and its joints intact."""
    was_lost = any(one.part == leg for one in damage)
    kept = tuple(one for one in damage if one.part not in (leg, *legs[leg]))
    return kept if was_lost else sort_damage((*kept, Damage(leg, "lost")), legs)


def set_joint(damage: Choice, joint: str, new: Damage | None, legs: Legs) -> Choice:
    """Return the damage with `new` damage to a joint, None for intact, and its leg restored."""
    leg = next(leg for leg, joints in legs.items() if joint in joints)
    kept = tuple(one for one in damage if one.part not in (leg, joint))
    return sort_damage((*kept, *((new,) if new else ())), legs)


def sort_damage(damage: Choice, legs: Legs) -> Choice:
    """Return the damage in the order of the legs, so that equal damage has equal text."""
    order = [part for leg, joints in legs.items() for part in (leg, *joints)]
    return tuple(sorted(damage, key=lambda one: order.index(one.part)))


def damage_texts(damage: Choice) -> tuple[str, ...]:
    """Return damage in the syntax of `--damage`, one string per part."""
    return tuple(map(str, damage))


class BodyPlan(Cells, can_focus=True):
    """A plan of a body with one chosen leg. Arrow keys or a click choose another leg.

    Attributes:
        plan: plan of the body; None while it is being read.
        damage: damage to its legs and joints.
        leg: chosen leg; '' without a plan.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "plan--trunk",
        "plan--leg",
        "plan--damaged",
        "plan--lost",
    }
    DEFAULT_CSS = """
    BodyPlan {
        height: 1fr; min-height: 5;
        & > .plan--trunk { color: $foreground 45%; }
        & > .plan--leg { color: $foreground; }
        & > .plan--damaged { color: $error; }
        & > .plan--lost { color: $error; }
    }
    """
    BINDINGS = bindings("plan")

    plan: reactive[Plan | None] = reactive(None, repaint=False, init=False)
    damage: reactive[tuple[Damage, ...]] = reactive((), repaint=False, init=False)
    leg: reactive[str] = reactive("", repaint=False, init=False)

    @dataclass
    class Removed(Message):
        """Posted when the user removes or restores a leg."""

        leg: str

    def watch_plan(self, plan: Plan | None) -> None:
        self.leg = next(iter(plan.legs), "") if plan is not None else ""
        self.redraw()

    def watch_damage(self) -> None:
        self.redraw()

    def watch_leg(self) -> None:
        self.redraw()

    def placeholder(self) -> str:
        return "" if self.plan is not None else "reading the body …"

    def picture(self, columns: int, rows: int) -> Picture:
        assert self.plan is not None, "else the placeholder is shown"
        lost = {one.part for one in self.damage if one.kind == "lost"}
        damaged = {one.part for one in self.damage if one.kind != "lost"}
        return drawing.draw_plan(self.plan, lost, damaged, self.leg, (columns, rows))

    def ink_styles(self) -> list[Style]:
        """Return the styles of blank, trunk, legs by state, and the chosen leg's label."""
        parts = [*map(self.ink_style, ("plan--trunk", "plan--lost", "plan--leg", "plan--damaged"))]
        bold = Style(bold=True)
        return [self.ink_style(), *parts, *(part + bold for part in parts)]

    def action_choose(self, forward: int, left: int) -> None:
        if self.plan is not None:
            self.leg = drawing.next_leg(self.plan, self.leg, forward, left)

    def action_remove(self) -> None:
        if self.leg:
            self.post_message(self.Removed(self.leg))

    def on_click(self, event: events.Click) -> None:
        """Choose a leg; remove or restore it if it is already chosen."""
        at = event.get_content_offset(self)
        if self.plan is None or at is None:
            return
        leg = drawing.leg_at(self.plan, at.x, at.y, (self.content_size[0], self.content_size[1]))
        if leg == self.leg:
            self.action_remove()
        self.leg = leg


class JointDialog(Dialog[tuple[str, str] | None]):
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

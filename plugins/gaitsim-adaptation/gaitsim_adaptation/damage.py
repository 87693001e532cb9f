"""Damage of a body, and a plan of its legs to choose and remove them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from rich.style import Style
from textual import events
from textual.message import Message
from textual.reactive import reactive

from gaitsim.plugin.pictures import Plan, plan as drawing
from gaitsim.plugin.toolkit import Damage
from gaitsim.screen import Cells, Picture, bindings

Legs = Mapping[str, tuple[str, ...]]
Choice = tuple[Damage, ...]


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

"""A plan of a body's legs from above, to choose and damage them."""

from dataclasses import dataclass
from typing import ClassVar

from rich.style import Style
from textual import events
from textual.message import Message
from textual.reactive import reactive

from gaitsim.legged.damage import Damage
from gaitsim.render.terminal import plan as drawing
from gaitsim.render.terminal.plan import Plan
from gaitsim.tui.actions import bindings
from gaitsim.tui.widgets.cells import Cells, Picture


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

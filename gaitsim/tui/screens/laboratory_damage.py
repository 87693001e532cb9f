"""Damage in the laboratory: remove legs, damage joints, repair, and switch the physics."""

from pathlib import Path

from textual import on, work
from textual.reactive import reactive

from gaitsim.errors import GaitsimError
from gaitsim.individual import Which
from gaitsim.legged.damage import parse_damage
from gaitsim.tui.actions import bindings
from gaitsim.tui.damage_choice import Choice, set_joint, toggle_leg
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.joint_dialog import JointDialog
from gaitsim.tui.screens.laboratory_loading import Subject
from gaitsim.tui.widgets.body_plan import BodyPlan

NOT_READ = "The run is still being read, or cannot be read."


class DamageActions(GaitScreen):
    """A screen with the plan of a body that can be damaged.

    Args:
        run: folder of the run.
        which: individual to watch; None is the champion.

    Attributes:
        subject: the run; None until it is read.
        plan: plan of the legs.
        damage: damage of the body.
        physics: whether the body's twin in rigid-body physics is simulated instead.
    """

    BINDINGS = bindings("lab damage")

    damage: reactive[Choice] = reactive((), init=False, bindings=True)
    physics: reactive[bool] = reactive(False, init=False, bindings=True)

    def __init__(self, run: Path, which: Which = None) -> None:
        super().__init__()
        self.run, self.which = run, which
        self.subject: Subject | None = None
        self.plan = BodyPlan()

    def show_body(self) -> None:
        """Show the body after a change of damage or physics."""
        raise NotImplementedError

    @on(BodyPlan.Removed)
    def _removed(self, event: BodyPlan.Removed) -> None:
        """Remove or restore a leg."""
        if self.subject is None:
            return
        wanted = toggle_leg(self.damage, event.leg, self.subject.legs)
        if self.obstacle("joint"):
            self.notify(self.obstacle("joint"), title=event.leg, markup=False)
            return
        try:
            self.subject.check(wanted, physics=self.physics)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        else:
            self.damage = wanted

    @work(group="ask", exclusive=True)
    async def action_joint(self) -> None:
        """Ask for the damage of a joint of the chosen leg."""
        subject, leg = self.subject, self.plan.leg
        assert subject is not None, "available only after reading"
        joints = subject.legs[leg]
        now = {one.part: str(one) for one in self.damage if one.part in joints}

        def wanted(joint: str, text: str) -> Choice:
            new = parse_damage([text], subject.legs)[0] if text else None
            found = set_joint(self.damage, joint, new, subject.legs)
            subject.check(found, physics=self.physics)
            return found

        answer = await self.app.push_screen_wait(JointDialog(joints, now, wanted))
        if answer is not None:
            self.damage = wanted(*answer)

    def action_repair(self) -> None:
        self.damage = ()

    def action_physics(self) -> None:
        """Switch to the twin, or back, if that body can have the damage."""
        assert self.subject is not None, "available only after reading"
        try:
            self.subject.check(self.damage, physics=not self.physics)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        else:
            self.physics = not self.physics

    def watch_damage(self, damage: Choice) -> None:
        self.plan.damage = damage
        self.show_body()

    def watch_physics(self) -> None:
        self.show_body()

    def obstacle(self, action: str) -> str:
        if action in ("joint", "repair", "physics") and self.subject is None:
            return NOT_READ
        if action == "repair" and not self.damage:
            return "The body is intact."
        if action == "physics" and self.subject and not self.subject.has_twin:
            return "The body has no twin in rigid-body physics."
        return super().obstacle(action)

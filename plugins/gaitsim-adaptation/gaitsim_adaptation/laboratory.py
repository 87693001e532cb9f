"""The laboratory: damage a body, watch its champion fail, and adapt its gait in a few trials."""

import asyncio
from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.reactive import reactive
from textual.widgets import DataTable, Static

from gaitsim.plugin import GaitsimError, unknown
from gaitsim.plugin.pictures import visible, visible_lines
from gaitsim.plugin.runs import Member, Which, command
from gaitsim.plugin.toolkit import damage_options, parse_damage
from gaitsim.screen import Ask, GaitScreen, RunChoice, bindings, options_of
from gaitsim_adaptation.adaptation import Adaptation, open_adaptation
from gaitsim_adaptation.damage import BodyPlan, Choice, damage_texts, set_joint, toggle_leg
from gaitsim_adaptation.laboratory_panels import (
    LaboratoryRun,
    Trials,
    WalkPane,
    read_subject,
    simulate_walk,
)
from gaitsim_adaptation.trials import Trial, refinements

JOINTS = (
    "A joint is 'stuck' in its standing pose or at an angle in degrees, or 'slow' or 'weak' with "
    "the share of its speed or torque that remains, such as 0.5. Its name alone repairs it."
)
NOT_READ = "The run is still being read, or cannot be read."
CHANGES = 10  # gaits that 'Refine' tries
WIDE, HIGH = 120, 36  # minimum columns for three bodies, and rows for an empty table


class Laboratory(GaitScreen):
    """A damaged body, its champion before and after the damage, and the search for a new gait.

    Args:
        run: folder of the run.
        which: individual to watch; None is the champion.

    Attributes:
        WATCHED: seconds for which a trial is shown before the next one.
        subject: the run; None until it is read.
        plan: plan of the legs.
        damage: damage of the body.
        physics: whether the body's twin in rigid-body physics is simulated instead.
        intact: pane of the champion on the intact body.
        damaged: pane of the champion on the damaged body.
        adapted: pane of a trial's gait on the damaged body.
        adaptation: adaptation with its trials; None before the first.
        shown: trial whose gait is shown in `adapted`; None before the first.
    """

    HELP_TEXT = """
Remove legs from a body, watch its champion fail, and let it adapt (Cully et al. 2015).

- **Plan**: the body from above, its front upwards. The arrow keys or a click choose a leg;
  Enter, space or another click removes or restores it. ✗ and dots mark a lost leg, ! a leg with
  a damaged joint.
- **Damage** asks for a joint of the chosen leg that is stuck at an angle, slow or weak, in the
  syntax of `--damage`, in which the damage is also shown below the plan. **Repair** removes all
  damage.
- **Bodies**: the champion, or the gait chosen on the previous screen, on the intact body and on
  the damaged one, and the gait being tried. The bar shows the distance walked, as a percentage of
  that on the intact body. A narrow screen hides the intact body during the trials.
- **Adapt** tries gaits of the atlas on the damaged body, each time the most promising one
  according to a Gaussian process whose prior mean is the map. *Expected* is its prediction with
  a standard deviation, *measured* the result of the trial, *of best* its ratio to the best result
  in the map of the intact body. The search ends when the best trial reaches 95 % of the highest
  expected value, or after 20 trials.
- **Refine** then tries ten small changes of the best gait, each more promising than others
  according to a Gaussian process over the genes. They are marked + and are not in the map.
- **Map**: the expected performance of each gait after the trials. Trials are marked by their
  numbers, the best by ★.
- **Stop** keeps all trials; **Adapt** or `gaitsim adapt` continues the search. **Verify** computes
  and measures them again.
- Enter or a click on a trial shows it again. **Replay** and **Export** apply to the gait shown, on
  the damaged body of the run; a changed gait is exported as a gait file.
- **Physics** switches to the body's twin in rigid-body physics, if it has one.
"""
    BINDINGS = bindings("lab")
    DEFAULT_CSS = """
    Laboratory {
        & #lab-top { height: 1fr; min-height: 8; }
        & #lab-left { width: 27; }
        & #lab-damage { height: auto; max-height: 4; padding: 0 1; }
        & #lab-state { height: auto; max-height: 4; padding: 0 1; background: $surface; }
        & Trials { height: 9; }
        &.-wide #lab-left { width: 40; }
        &.-tall Trials { height: 18; }
    }
    """
    AUTO_FOCUS = "BodyPlan"
    WATCHED: ClassVar[float] = 1.25

    damage: reactive[Choice] = reactive((), init=False, bindings=True)
    physics: reactive[bool] = reactive(False, init=False, bindings=True)

    def __init__(self, run: Path, which: Which = None) -> None:
        super().__init__()
        self.run, self.which = run, which
        self.subject: LaboratoryRun | None = None
        self.plan = BodyPlan()
        self._stopping = False
        self.adaptation: Adaptation | None = None
        self.shown: Trial | None = None
        who = f"generation {which}" if isinstance(which, int) else str(which or "champion")
        self.intact = WalkPane(f"{who}, intact", "reading the run …")
        self.damaged = WalkPane(f"{who}, damaged", "enter: remove the chosen leg")
        self.adapted = WalkPane("adapted", "a: try gaits of the atlas")
        self.trials = Trials()
        self.title = visible(run.name)

    def content(self) -> ComposeResult:
        with Horizontal(id="lab-top"):
            with Vertical(id="lab-left"):
                yield self.plan
                yield Static(id="lab-damage", classes="command")
            yield self.intact
            yield self.damaged
            yield self.adapted
        yield Static(id="lab-state")
        yield self.trials

    @work(group="read")
    async def on_mount(self) -> None:
        self._arrange()
        try:
            self.subject = await self.in_thread(read_subject, self.run, self.which)
        except GaitsimError as error:
            self._fail(error)
            return
        self.plan.plan = self.subject.plan
        self.show_body()

    # Damage

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
        now = [str(one) for one in self.damage if one.part in joints]

        def wanted(text: str) -> Choice:
            new = None if text in joints else parse_damage([text], subject.legs)[0]
            joint = text if new is None else new.part
            if joint not in joints:
                raise unknown("joint", joint, joints)
            found = set_joint(self.damage, joint, new, subject.legs)
            subject.check(found, physics=self.physics)
            return found

        ask = Ask(
            f"Which joint of {leg} is damaged?",
            next(iter(now), f"{joints[0]} stuck"),
            wanted,
            f"{JOINTS} Joints: {', '.join(joints)}.",
        )
        if (text := await self.app.push_screen_wait(ask)) is not None:
            self.damage = wanted(text)

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

    # The champion

    def show_body(self) -> None:
        """Show the champion on the changed body and discard the trials of the previous one."""
        self.adaptation = self.shown = None
        self.trials.clear()
        self.adapted.show_message(title="adapted")
        words = " ".join(f"--damage '{text}'" for text in damage_texts(self.damage))
        self.query_one("#lab-damage", Static).update(Text(visible(words or "no damage")))
        self.sub_title = "laboratory" + (" in rigid-body physics" if self.physics else "")
        self._arrange()
        self._walk()

    @work(group="walk", exclusive=True)
    async def _walk(self) -> None:
        assert self.subject is not None, "damage needs a run"
        champion, physics, damage = self.subject.champion, self.physics, self.damage
        self._say("simulating …")
        try:
            intact = await self.in_thread(simulate_walk, champion, (), physics)
            self.intact.show(intact, intact)
            if damage:
                damaged = await self.in_thread(simulate_walk, champion, damage, physics)
                self.damaged.show(damaged, intact)
            else:
                self.damaged.show_message()
        except GaitsimError as error:
            self._fail(error)
        else:
            self._say(self.obstacle("adapt") or "Press a to try gaits of the atlas on this body.")
        self.refresh_bindings()

    # The search for a new gait

    def action_adapt(self) -> None:
        """Run trials until a gait is good enough, or the search is stopped."""
        self._search({})

    def action_refine(self) -> None:
        """Run trials of changes of the best gait."""
        assert self.adaptation is not None, "available only after a trial"
        self._search({"refine": refinements(self.adaptation.trials) + CHANGES})

    @work(group="adapt", exclusive=True)
    async def _search(self, settings: Mapping[str, int]) -> None:
        self._stopping = False
        self.call_next(self.refresh_bindings)
        try:
            if self.adaptation is None or settings:
                self.adaptation = await self.in_thread(self._open, settings)
            await self._run_trials(self.adaptation)
        except GaitsimError as error:
            self.adaptation = None  # re-read its file, which another process may have changed
            self._fail(error)
        finally:
            self._stopping = False
            self.call_next(self.refresh_bindings)

    def _open(self, settings: Mapping[str, int]) -> Adaptation:
        """Continue or create the adaptation to this damage; called in a thread."""
        assert self.subject is not None, "available only after reading"
        done = 0

        def progress(count: int) -> None:
            nonlocal done
            done += count
            text = f"evaluating the atlas on the intact body: {done:,} gaits"
            self.app.call_from_thread(self._say, text)

        return open_adaptation(
            self.subject.run,
            damage_texts(self.damage),
            place="physics" if self.physics else "simulation",
            settings=settings,
            on_progress=progress,
        )

    async def _run_trials(self, adaptation: Adaptation) -> None:
        """Run trials one by one and show the best at the end."""
        while not self._stopping and adaptation.proposal is not None:
            proposal = adaptation.proposal
            self._say(f"trial {proposal.number} of at most {adaptation.settings.trials} …")
            trial = await self.in_thread(next, adaptation)
            self._list(adaptation)
            await self._show_trial(adaptation, trial, fast=True)
            await asyncio.sleep(self.WATCHED)
        self._list(adaptation)
        if adaptation.best is not None:
            await self._show_trial(adaptation, adaptation.best)
        self._say(
            f"{adaptation.ending}. {adaptation.shares}"
            if adaptation.ending
            else "Stopped; press a to continue."
        )

    def _list(self, adaptation: Adaptation) -> None:
        """Show all trials in the table and on the map along axes of a damaged leg."""
        assert self.subject is not None, "trials need a run"
        assert self.subject.run.members is not None, "the run is an atlas"
        self.trials.show(
            adaptation, self.subject.run.members, self.subject.damaged_legs(self.damage)
        )

    async def _show_trial(
        self, adaptation: Adaptation, trial: Trial, *, fast: bool = False
    ) -> None:
        """Show a trial's gait on the damaged body; if `fast`, within `WATCHED` seconds."""
        individual = adaptation.individual(trial)
        walk = await self.in_thread(simulate_walk, individual, self.damage, self.physics)
        won = trial is adaptation.best and not fast
        self.shown = trial
        self.adapted.show(walk, self.intact.walk, f"{'adapted: ' * won}trial {trial.number}")
        if fast and self.WATCHED:
            canvas = self.adapted.canvas
            canvas.speed = max(canvas.duration / self.WATCHED, 1.0)
        self._arrange()
        self.refresh_bindings()

    def action_export(self) -> None:
        """Export the gait shown; a changed gait is written as a gait file."""
        if self.shown is not None and self.shown.genome:
            self._write(self.shown)
        else:
            super().action_export()

    @work(group="ask")
    async def _write(self, trial: Trial) -> None:
        """Write the gait file of a trial."""
        assert self.adaptation is not None, "a trial was shown"
        try:
            file = await self.in_thread(self.adaptation.export, trial)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
            return
        options = ("--gait", file, *damage_options(damage_texts(self.damage)))
        self.notify(f"{file}\n{command('play', self.run, *options)}", markup=False)

    def action_stop(self) -> None:
        """Stop after the current trial."""
        self._stopping = True
        self._say("stopping …")

    @on(DataTable.RowSelected)
    @work(group="show", exclusive=True)
    async def _show_chosen(self, event: DataTable.RowSelected) -> None:
        """Show a trial again."""
        if self.adaptation is not None and not self.is_busy("adapt"):
            await self._show_trial(self.adaptation, self.adaptation.trials[event.cursor_row])

    # Layout and messages

    def _arrange(self) -> None:
        """Show three bodies if they fit, else the two that matter at this step."""
        wide = self.app.size.width >= WIDE
        possible = self.subject is None or not self.subject.unadaptable
        self.adapted.display = possible and (wide or self.adapted.walk is not None)
        self.intact.display = wide or not self.adapted.display
        high = self.app.size.height >= HIGH
        self.trials.display = possible and (high or self.adaptation is not None)

    def on_resize(self) -> None:
        self._arrange()

    def _say(self, text: str) -> None:
        self.query_one("#lab-state", Static).update(Text(visible_lines(text)))

    def _fail(self, error: GaitsimError) -> None:
        """Show an error; it replaces all panes if no body was read."""
        if self.subject is not None:
            self._say(str(error))
            return
        for part in ("#lab-left", WalkPane, Trials):
            self.query(part).set(display=False)
        self.intact.display = True
        self.intact.show_message(str(error), title=" ")

    # Available actions

    @property
    def choice(self) -> RunChoice:
        member = None if self.shown is None or self.shown.genome else Member(self.shown.member)
        return RunChoice(self.run, member or self.which, damage_texts(self.damage))

    @property
    def to_verify(self) -> Path | None:
        found = self.adaptation
        return None if found is None or self.is_busy("adapt") or not found.trials else found.path

    def command_line(self) -> str:
        options = damage_options(damage_texts(self.damage))
        if self.subject is None or self.subject.unadaptable or not self.damage:
            return command("play", self.run, *options_of(self.which), *options)
        return command("adapt", self.run, *options, *["--physics"] * self.physics)

    def obstacle(self, action: str) -> str:
        busy, subject = self.is_busy("adapt"), self.subject
        match action:
            case "adapt" | "refine" | "repair" | "joint" | "physics" if busy:
                return "An adaptation is running; press x to stop it first."
            case "adapt" | "replay" | "export" if subject is None:
                return NOT_READ
            case "adapt" if subject and subject.unadaptable:
                return subject.unadaptable
            case "adapt" if not self.damage:
                return "The body is intact; press Enter to remove a leg first."
            case "refine" if self.adaptation is None:
                return "No gait was tried; press a to try gaits of the atlas first."
            case "replay" if self.shown is not None and self.shown.genome:
                return "A changed gait is not in the atlas; export it as a gait file."
            case "stop" if not busy:
                return "No adaptation is running."
            case "joint" | "repair" | "physics" if subject is None:
                return NOT_READ
            case "repair" if not self.damage:
                return "The body is intact."
            case "physics" if subject and not subject.has_twin:
                return "The body has no twin in rigid-body physics."
        return super().obstacle(action)

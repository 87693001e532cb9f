"""Replay: any individual of a run in motion, alone or beside another."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path

from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.reactive import reactive

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Which, mark_of
from gaitsim.legged.damage import damage_options
from gaitsim.steering import create_drive, own_controllers
from gaitsim.storage.files.folder import EXPERIMENT, command
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen, PaletteCommand, RunChoice
from gaitsim.tui.screens.questions import Ask, AskText
from gaitsim.tui.screens.replay_loading import (
    describe,
    kind_of,
    last_of,
    number_of,
    options_of,
    parse_which,
    with_number,
)
from gaitsim.tui.screens.replay_pane import ReplayPane
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.scrubber import Scrubber

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
_WORDS = {0.25: "¼", 0.5: "½"}


class Replay(GaitScreen):
    """A body in motion, or two in synchrony.

    Args:
        run: folder of the run.
        which: first individual to show; None is the champion.
        beside: folder of the run to show beside it, which may be the same run; None for one body.
        damage: damage of the bodies of `run`, in the syntax of `--damage`.
        beside_which: first individual to show beside it; None is the champion.

    Attributes:
        panes: the pane of each body.
    """

    HELP_TEXT = """
The best individual of any generation, or a member of a front or archive, in motion.

- **Time** and **generation** each have a slider: drag it, or use the arrow keys when it has the
  focus; with shift, ten steps at a time.
- **Camera**: drag the body, or use the arrow keys when it has the focus; scroll to zoom. *View*
  switches between corner, side, above and front. *Follow* switches to a view of the whole path.
- Filled dots are feet on the ground. Below the body, bars mark when each foot is on the ground
  (Hildebrand 1965). Left and right feet differ in colour.
- The bar below the body is a scale; the arrow is the heading seen from above, upwards at the
  start.
- **Go to** shows a generation by number. **Export** writes plots, videos and gait files of the
  generation shown. **Why** explains its score. **3D** writes a page that plays the motion in 3D in
  any browser, and opens it.
- **Code** copies a challenge code of the individual: anyone can play it with `gaitsim verify`.
- **Split** shows a second body: the other run, or generation 1 of this run. Both move in
  synchrony and share the camera. The generation keys apply to the focused body.
- **Members**, if the search keeps a front or an archive: the slider and the generation keys step
  through the members, and the curve shows the member's position on the front. Press it again for
  generations.
- **Map** shows the archive as a map, or the front as a scatter plot, to choose any gait with the
  arrow keys.
- ★ is the champion of the run, or the member with the best score.
"""
    BINDINGS = bindings("replay")
    DEFAULT_CSS = """
    Replay {
        & #panes { height: 1fr; }
        & ReplayPane.second { border-left: solid $border-blurred; }
        & > Scrubber { padding: 0 1; }
    }
    """

    AUTO_FOCUS = "#frame"

    speed: reactive[float] = reactive(1.0, init=False)

    def __init__(
        self,
        run: Path,
        which: Which = None,
        beside: Path | None = None,
        damage: Sequence[str] = (),
        beside_which: Which = None,
    ) -> None:
        super().__init__()
        self._run, self._beside, self._damage = run, beside, tuple(damage)
        self._playing = True
        self._time = Scrubber("time      ", format_value=self._format_time, id="frame")
        self.panes = [ReplayPane(run, which, damage)]
        if beside is not None:
            self.panes.append(ReplayPane(beside, beside_which, classes="second"))

    def content(self) -> ComposeResult:
        with Horizontal(id="panes"):
            yield from self.panes
        yield self._time

    def on_mount(self) -> None:
        self._update_title()

    # Bodies

    @property
    def pane(self) -> ReplayPane:
        """The focused pane, or the first one."""
        inside = self.focused.ancestors if self.focused is not None else []
        return next((pane for pane in self.panes if pane in inside), self.panes[0])

    @property
    def leader(self) -> BodyCanvas:
        """The body that sets the time: the one with the longest motion."""
        return max((pane.canvas for pane in self.panes), key=lambda canvas: canvas.duration)

    @on(ReplayPane.IndividualShown)
    def _changed(self) -> None:
        """Adopt the longest motion and its number of frames."""
        leader = self.leader
        for pane in self.panes:
            canvas = pane.canvas
            canvas.speed = self.speed
            canvas.playing = self._playing and canvas is leader
            if canvas is not leader:
                pane.show_frame_of(leader.seconds)
        self._time.set_range(0, max(leader.frames - 1, 0))
        self._time.value = leader.frame
        self._update_title()

    @on(BodyCanvas.FrameShown)
    def _moved(self, event: BodyCanvas.FrameShown) -> None:
        if event.canvas is self.leader:
            self._synchronise()

    def _synchronise(self) -> None:
        leader = self.leader
        for pane in self.panes:
            pane.show_frame_of(leader.seconds)
        self._time.value = leader.frame

    @on(BodyCanvas.ViewChanged)
    def _turned(self, event: BodyCanvas.ViewChanged) -> None:
        """Move both cameras."""
        for pane in self.panes:
            pane.canvas.view = event.view
        self._update_title()

    @on(Scrubber.Scrubbed, "#frame")
    def _scrubbed(self, event: Scrubber.Scrubbed) -> None:
        self._play(False)
        self.leader.show_frame(event.value)
        self._synchronise()

    def _format_time(self, frame: int) -> str:
        """Return the slider's text for a frame."""
        leader = self.leader
        if leader.skeleton is None:
            return "–"
        last = leader.frames - 1
        seconds = frame / leader.skeleton.frame_rate
        return f"{seconds:6.2f} s  frame {frame:>{len(str(last))}}/{last}"

    def _update_title(self) -> None:
        """Show the state, speed and camera in the title, and update the action of space."""
        self.refresh_bindings()
        view = self.panes[0].canvas.view
        state = "playing" if self._playing else "paused"
        speed = _WORDS.get(self.speed, f"{self.speed:g}")
        way = "" if view.follow else ", whole path"
        name = {"": "turned", "iso": "corner"}.get(view.name, view.name)
        self.sub_title = f"replay · {state} · {speed}× speed · {name} view{way}"

    # Actions

    def action_play(self) -> None:
        self._play(True)

    def action_pause(self) -> None:
        self._play(False)

    def _play(self, playing: bool) -> None:
        if playing != self._playing:  # slow: checks all keys
            self._playing = self.leader.playing = playing
            self._update_title()

    def action_frame(self, steps: int) -> None:
        """Move by `steps` frames, wrapping round at the ends."""
        self._play(False)
        leader = self.leader
        leader.show_frame((leader.frame + steps) % max(leader.frames, 1))
        self._synchronise()

    def action_speed(self, steps: int) -> None:
        at = SPEEDS.index(self.speed) + steps
        self.speed = SPEEDS[min(max(at, 0), len(SPEEDS) - 1)]

    def watch_speed(self, speed: float) -> None:
        for pane in self.panes:
            pane.canvas.speed = speed
        self._update_title()

    def action_generation(self, steps: int) -> None:
        pane = self.pane
        if pane.which is not None:
            pane.request(with_number(pane.which, number_of(pane.which) + steps))

    @work(group="ask", exclusive=True)
    async def action_go_to(self) -> None:
        """Ask for the number of a generation or member and show it."""
        pane = self.pane
        shown = pane.shown
        if shown is None:
            return
        which = shown.which
        best = f"best: {describe(shown.best)}" if shown.best else "every individual failed"
        question = Ask(
            f"Go to {kind_of(which)}",
            check=partial(parse_which, which=which, shown=shown),
            about=f"1 to {last_of(shown, which):,}; {best}",
        )
        answer = await self.app.push_screen_wait(question)
        if answer is not None:
            pane.request(parse_which(answer, which, shown))

    def action_best(self) -> None:
        pane = self.pane
        on_front = pane.shown is not None and isinstance(pane.which, Member)
        pane.request(pane.shown.best_member if pane.shown and on_front else None)

    def action_members(self) -> None:
        """Switch from generations to members, the best first, or back."""
        pane = self.pane
        if pane.shown is not None:
            pane.request(None if isinstance(pane.which, Member) else pane.shown.best_member)

    def action_camera(self, name: str, *arguments: int) -> None:
        getattr(self.panes[0].canvas, f"action_{name}")(*arguments)

    def action_measures(self) -> None:
        shown = self.pane.measures_shown
        own = self.pane
        for pane in self.panes:
            pane.show_measures(not shown)
        # The arrow keys scroll the measures while they are shown.
        (self._time if shown else own.numbers).focus()

    async def action_split(self) -> None:
        if len(self.panes) > 1:
            await self.panes.pop().remove()
            self._changed()
            return
        run = self._beside or self._run
        first = Member(1) if isinstance(self.panes[0].which, Member) else 1
        damage = () if self._beside else self._damage
        pane = ReplayPane(run, None if self._beside else first, damage, classes="second")
        pane.canvas.view = self.panes[0].canvas.view
        self.panes.append(pane)
        await self.query_one("#panes").mount(pane)

    @property
    def choice(self) -> RunChoice:
        pane = self.pane
        others = {one.run for one in self.panes if one.run != pane.run}
        return RunChoice(pane.run, pane.which, pane.damage, tuple(others))

    def action_browser(self) -> None:
        """Write a page of the bodies shown and open it in a browser."""
        pane = self.pane
        same = [one for one in self.panes if (one.run, one.damage) == (pane.run, pane.damage)]
        which = [one.shown.which for one in same if one.shown is not None]
        numbers = [mark_of(one)[1:] for one in which if not isinstance(one, Member)]
        if len(numbers) == len(same) > 1:
            options = ["--generations", ",".join(numbers)]
        else:
            options = [str(word) for word in options_of(pane.which)]
        words = "export", str(pane.run), "--format", "html", *options, *damage_options(pane.damage)
        self.gaitsim.start_task(words, opens=True)

    @work(group="ask", exclusive=True)
    async def action_code(self) -> None:
        """Copy the challenge code of the individual, and show it in a dialog."""
        from gaitsim.sharing.challenge import code_of

        if self.pane.shown is None:
            return
        individual = self.pane.shown.individual
        try:
            code = await self.in_thread(code_of, individual)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
            return
        self.app.copy_to_clipboard(code)
        title = f"{individual.title}: copied a challenge code of {len(code):,} characters"
        about = "Anyone can play it: gaitsim verify CODE"
        if await self.app.push_screen_wait(AskText(title, code, "Copy", about=about)):
            self.app.copy_to_clipboard(code)

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield a command for each controller that the individual shown can replace."""
        pane = self.pane
        if pane.shown is not None:
            which, experiment = pane.shown.which, pane.shown.individual.experiment
            for one in own_controllers(experiment):
                given = {one.name: f"{pane.run}{mark_of(which)}"}
                line = command(
                    *("steer", pane.run / EXPERIMENT, "--controller"),
                    f"{one.name}={given[one.name]}",
                )
                load = partial(create_drive, experiment, given)
                do = partial(self.show_screen, "steering.Steering", load, line)
                about = (
                    f"Steer the body yourself; this individual's network takes over to {one.help}"
                )
                yield PaletteCommand(f"Steer: {one.name}", about, do)
        yield from super().palette()

    def command_line(self) -> str:
        pane = self.pane
        return command("play", pane.run, *options_of(pane.which), *damage_options(pane.damage))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if not self.is_mounted:
            return super().check_action(action, parameters)
        match action:
            case "play" | "pause":
                return self.leader.skeleton is not None and self._playing == (action == "pause")
            case "frame" | "speed" | "camera":
                return self.leader.skeleton is not None
            case "measures" | "export" | "browser" | "code" | "why" | "go_to" | "on_individual":
                return self.pane.shown is not None
            case "members":
                return self.pane.shown is not None and self.pane.shown.best_member is not None
            case "map":
                members = self.pane.shown.members if self.pane.shown is not None else None
                return members is not None
            case "generation" | "best":
                return self.pane.shown is not None or self.pane.problem is not None
        return super().check_action(action, parameters)

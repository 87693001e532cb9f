"""What the live screen asks before it does it: changes, how many generations, a copy."""

from abc import abstractmethod
from pathlib import Path

from textual import work

from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Overrides
from gaitsim.live.protocol import Snapshot
from gaitsim.tui.screens.base import GaitScreen


class LiveDialogs(GaitScreen):
    """A screen on a run that can be changed, go further, and be copied.

    Attributes:
        run: its folder.
    """

    run: Path

    @property
    @abstractmethod
    def snapshot(self) -> Snapshot:
        """How the run stands."""

    @property
    @abstractmethod
    def state(self) -> str:
        """The run's state."""

    @abstractmethod
    def go_on(self, overrides: Overrides) -> None:
        """Continue with options changed by key."""

    @abstractmethod
    def action_pause(self) -> None:
        """Pause, if it evolves here."""

    @abstractmethod
    def problem(self, error: GaitsimError | None) -> None:
        """Show what went wrong."""

    @work(group="ask", exclusive=True)
    async def action_change(self) -> None:
        """Ask for changes; they hold from the next generation on."""
        from gaitsim.tui.screens.change_dialog import ChangeDialog

        typed = ""
        if self.state == "finished":  # a stage has to have a generation
            typed = f"evolution.generations={self._further()} "
        wanted = await self.app.push_screen_wait(ChangeDialog(self.run, typed=typed))
        if wanted is not None:
            self.go_on(wanted.overrides)

    @work(group="ask", exclusive=True)
    async def action_goal(self) -> None:
        from gaitsim.tui.screens.questions import Ask

        further = str(self._further())
        about = f"It is at generation {self.snapshot.generation:,}."
        question = Ask("How many generations is the run to have?", further, self._check_goal, about)
        answer = await self.app.push_screen_wait(question)
        if answer is not None:
            self.go_on({"evolution.generations": int(answer)})

    def _further(self) -> int:
        """Half as many generations again."""
        planned = max(self.snapshot.generations, self.snapshot.generation)
        return planned + max(1, planned // 2)

    def _check_goal(self, text: str) -> None:
        done = self.snapshot.generation
        number = int(text) if text.isascii() and text.isdecimal() and len(text) < 10 else 0
        if not done < number <= 100_000_000:
            raise RunError(
                f"{text!r} is no number of generations to go on to",
                allowed=f"{done + 1:,} to 100,000,000",
            )

    @work(group="ask", exclusive=True)
    async def action_fork(self) -> None:
        from gaitsim.tui.screens.change_dialog import ChangeDialog

        self.action_pause()
        wanted = await self.app.push_screen_wait(ChangeDialog(self.run, fork=True))
        if wanted is not None:
            self._fork(wanted.out, wanted.overrides)

    @work(thread=True, group="fork")
    def _fork(self, out: Path | None, overrides: Overrides) -> None:
        from gaitsim.runs.fork import fork_run

        try:
            copy = fork_run(self.run, out, overrides, any_version=False)
        except GaitsimError as error:
            self.app.call_from_thread(self.problem, error)
        else:
            self.app.call_from_thread(self._forked, copy)

    def _forked(self, copy: Path) -> None:
        self.notify(f"{copy}: a copy of {self.run}", title="Forked", markup=False)
        self.gaitsim.open_run(copy, go=True)

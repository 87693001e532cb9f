"""Change options of a run, for its next generations or in a copy of it."""

from collections.abc import Callable
from pathlib import Path

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Input, Label

from gaitsim import toml
from gaitsim.experiment import Overrides
from gaitsim.storage.files.folder import EXPERIMENT, command
from gaitsim.storage.resume import plan_resume
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.builder import ExperimentBuilder, LoadedPreset, Validation
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.experiment_form import ExperimentForm


def describe_effect(run: RunSnapshot, overrides: Overrides) -> str:
    """Describe the effect of changes without applying them.

    Raises:
        GaitsimError: the run cannot continue with these changes.
    """
    plans = plan_resume(run, overrides, generations=None, any_version=True)
    if plans.last is None:
        return "The first generation will have these options." if overrides else ""
    if not plans.changes:
        planned = f"{plans.experiment.evolution.generations:,}"
        return f"No new stage: evolution continues to generation {planned}." if overrides else ""
    changes = "".join(f"▶ {change}\n" for change in plans.changes)
    rescored = "; scores are not comparable to earlier scores" if plans.reevaluates else ""
    return f"{changes}from generation {run.generation + 1}{rescored}"


class ChangeForm(ExperimentForm):
    """The form of a run's experiment.

    Args:
        run: folder of the run.
        done: function called with the changed options and the folder of the copy, if one is typed.
        fork: whether to fork the run, and ask for the folder of the copy.
        changes: initial changes by key.
    """

    HELP_TEXT = """
Change options of the run, starting with the next generation. Each tab is a part of the experiment.
The screen shows the **effect** of the changes, with the equivalent **command**. / or Ctrl-F
**searches** the options by words. Ctrl-R or Enter applies the changes; Esc discards them.
"""
    BINDINGS = bindings("change")
    AUTO_FOCUS = "#sections"  # not the folder, which would take the letters of a search

    def __init__(
        self,
        run: Path,
        done: Callable[[Overrides, Path | None], object],
        *,
        fork: bool = False,
        changes: dict[str, str] | None = None,
    ) -> None:
        super().__init__()
        self._run, self._done, self._fork, self._changes = run, done, fork, changes or {}
        self.title, self.sub_title = run.name, "fork" if fork else "change"

    def head(self) -> ComposeResult:
        if self._fork:
            with Horizontal(id="form-head"):
                yield Label("folder of the copy ")
                yield Input(placeholder=f"{self._run}-2", compact=True, id="out")

    def on_mount(self) -> None:
        self.load(lambda: self._builder(self._changes))

    def _builder(self, changes: dict[str, str]) -> ExperimentBuilder:
        text = RunSnapshot(self._run).experiment.to_toml()
        file = str(self._run / EXPERIMENT)
        return ExperimentBuilder(LoadedPreset(file, text, toml.parse(text, file)), changes)

    def effect(self, found: Validation) -> str:
        """Return the stage that the changes start."""
        return describe_effect(RunSnapshot(self._run), found.builder.overrides)

    def show(self, found: Validation) -> None:
        super().show(found)
        if not (found.problems or found.builder.changes or self._fork):
            self.show_status("Change any option; the effect on the run appears here.")

    @property
    def _out(self) -> Path | None:
        typed = self.query_one("#out", Input).value.strip() if self._fork else ""
        return Path(typed) if typed else None

    def command_line(self) -> str:
        changes = self.builder.changes if self.builder else {}
        more = ["--out", str(self._out)] if self._out else []
        sets = [word for key, text in changes.items() for word in ("--set", f"{key}={text}")]
        return command("fork" if self._fork else "resume", self._run, *more, *sets)

    @on(Input.Changed, "#out")
    def _out_changed(self) -> None:
        if self.validation is not None:
            self.show(self.validation)

    @on(Input.Submitted)
    def action_accept(self) -> None:
        self.accept()

    def action_reset(self) -> None:
        self.load(lambda: self._builder({}))

    async def use(self, found: Validation) -> None:
        """Apply the changes."""
        overrides, out = found.builder.overrides, self._out
        self.dismiss()
        if overrides or self._fork:
            self._done(overrides, out)

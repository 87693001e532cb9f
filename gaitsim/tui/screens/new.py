"""New run: a preset whose every option can be changed."""

import asyncio
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content
from textual.widgets import Button, Input, Label

from gaitsim.errors import GaitsimError
from gaitsim.steering import create_drive, offered_commands
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import RUNS, free_name
from gaitsim.tui.builder import ExperimentBuilder, Validation, load_preset
from gaitsim.tui.formatting import clip_name
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import PaletteCommand
from gaitsim.tui.screens.experiment_form import ExperimentForm
from gaitsim.tui.screens.files import ChooseFile
from gaitsim.tui.screens.presets import Presets
from gaitsim.tui.screens.questions import Ask, Confirm

KEYS = ("name", "seed")
PRESET = 26  # cells of the name of a preset
DEFAULT_PRESET = "spider"  # preset used if there is no draft


class New(ExperimentForm):
    """The form of a new run.

    Args:
        experiment: preset or file to start from; None restores the latest draft.
    """

    SUB_TITLE = "new run"
    HELP_TEXT = """
Start from a preset, or from a different one with Ctrl-G, and change any option. Each tab is a part
of the experiment, with the options that its plugin declares. Problems appear below the option as
you type, and a ✗ marks the tab. Only plugins that work with the body are offered; choosing a
different body also replaces parts that do not.

The screen shows the equivalent **command** and the experiment **file**. / or Ctrl-F **searches**
the options by words. Leaving the screen keeps your changes as a draft, which the next new run
restores; Ctrl-Z undoes all changes.
"""
    BINDINGS = bindings("new")

    def __init__(self, experiment: str | None = None) -> None:
        super().__init__()
        self._experiment = experiment
        self._requested = ""  # preset or file that is being loaded
        self._saved: ExperimentBuilder | None = None

    def head(self) -> ComposeResult:
        """Compose the preset, and two inputs whose IDs are the keys of their options."""
        with Horizontal(id="form-head"):
            yield Label("start from ")
            yield Button("…", compact=True, id="preset")
            yield Label(" name ")
            yield Input(compact=True, id="name")
            yield Label(" seed ")
            yield Input(compact=True, id="seed")

    def on_mount(self) -> None:
        self._load_preset(self._experiment or next(reversed(self.gaitsim.drafts), DEFAULT_PRESET))

    def _load_preset(self, reference: str) -> None:
        """Load a preset or a file, or the draft that began with it."""
        self._requested = reference
        draft = self.gaitsim.drafts.get(reference)
        self.load(lambda: draft or ExperimentBuilder(load_preset(reference)))

    def loaded(self, builder: ExperimentBuilder | None) -> None:
        """Show the preset, the name and the seed."""
        shown = builder or self.builder
        button = self.query_one("#preset", Button)
        reference = shown.preset.reference if shown else self._requested
        button.label = Content(f"{clip_name(reference, PRESET)} ▾")
        button.refresh(layout=True)  # a new label does not change the width by itself
        if builder is None:
            return
        for key in KEYS:
            with self.prevent(Input.Changed):
                text = builder.changes.get(key, str(builder.preset.values[key]))
                self.query_one(f"#{key}", Input).value = text
        if builder is self.gaitsim.drafts.get(reference):
            self.notify(f"Restored your draft: {builder.changes_text}. Ctrl-Z undoes all changes.")

    def effect(self, found: Validation) -> str:
        """Return the folder of the run."""
        wanted = self.gaitsim.folder / found.name
        run = free_name(wanted)
        taken = "" if run == wanted else f"; the name {wanted.name} is taken"
        return f"✓ Ready to run as {run}{taken}"

    def show(self, found: Validation) -> None:
        super().show(found)
        for key in KEYS:
            self.query_one(f"#{key}").set_class(key in found.problems, "-wrong")

    @on(Input.Changed, "#name,#seed")
    def _head_changed(self, event: Input.Changed) -> None:
        key = str(event.input.id)
        if self.builder is not None:
            same = event.value == str(self.builder.preset.values[key])
            self.assign(key, None if same else event.value)

    @on(Button.Pressed, "#preset")
    @work(group="ask", exclusive=True)
    async def action_preset(self) -> None:
        """Ask for a different preset."""
        now = self.builder.preset.reference if self.builder else ""
        reference = await self.app.push_screen_wait(Presets([*self.gaitsim.drafts], now))
        if reference is not None and reference != now:
            self._replace(reference)

    @work(group="ask", exclusive=True)
    async def _replace(self, reference: str) -> None:
        """Load a preset, after asking whether to discard changes."""
        if self.builder is not None and self.builder.changes:
            about = f"{self.builder.changes_text} will be discarded."
            same = reference == self.builder.preset.reference
            title, yes = ("Undo all changes?", "Undo") if same else (f"Load {reference}?", "Load")
            if not await self.app.push_screen_wait(Confirm(title, yes, about)):
                return
            self.gaitsim.drafts.pop(self.builder.preset.reference, None)
        self._load_preset(reference)

    def action_reset(self) -> None:
        if self.builder is not None:
            self._replace(self.builder.preset.reference)

    def _run(self) -> Path:
        name = self.validation.name if self.validation else DEFAULT_PRESET
        return self.gaitsim.folder / name

    def command_line(self) -> str:
        return self.validation.builder.command(self._run()) if self.validation else ""

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield the command that steers the current body."""
        found = self.validation
        if found is not None and found.experiment is not None:
            experiment = found.experiment
            if offered_commands(experiment):
                load = partial(create_drive, experiment, {})
                steer = partial(self.show_screen, "steering.Steering", load, "")
                yield PaletteCommand("Steer", "Steer this body yourself with the arrow keys", steer)
        yield from super().palette()

    async def may_leave(self) -> bool:
        """Keep unsaved changes as a draft."""
        builder, drafts = self.builder, self.gaitsim.drafts
        if builder is not None:
            drafts.pop(builder.preset.reference, None)
            if builder.changes and builder is not self._saved:
                drafts[builder.preset.reference] = builder
        return True

    def on_unmount(self) -> None:
        """Report the draft after the screen closes, not while quitting asks about it."""
        draft = self.gaitsim.drafts.get(self.builder.preset.reference) if self.builder else None
        if draft is not None:
            self.app.notify(
                f"Kept as a draft: {draft.changes_text}. Press n at home to restore it."
            )

    def action_run(self) -> None:
        self.accept()

    async def use(self, found: Validation) -> None:
        """Start the run."""
        assert found.experiment is not None, "it is valid"
        folder = None if self._run().parent == RUNS else self._run()
        try:
            path = await asyncio.to_thread(create_run, found.experiment, folder)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        else:
            self.gaitsim.drafts.pop(found.builder.preset.reference, None)
            self.dismiss()
            self.show_screen("live.Live", path, resume=True)

    @work(group="ask", exclusive=True)
    async def action_save(self) -> None:
        """Ask where to save the experiment file, and save it."""
        found = await self.require_valid()
        if found is None or found.experiment is None:
            return
        about = "The file lists every option."
        ask = Ask("Save the experiment file as", f"{found.name}.toml", about=about)
        answer = await self.app.push_screen_wait(ask)
        if answer is None:
            return
        path = Path(answer if answer.endswith(".toml") else f"{answer}.toml").expanduser()
        question = Confirm(f"Replace {path}?", "Replace", "The file exists.", danger=True)
        if path.exists() and not await self.app.push_screen_wait(question):
            return
        try:
            await asyncio.to_thread(write_bytes, path, found.experiment.to_toml().encode())
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        else:
            self._saved = found.builder
            self.notify(f"{path}\n$ gaitsim run {path}", title="Saved", markup=False)

    @work(group="ask", exclusive=True)
    async def action_load(self) -> None:
        reference = await self.app.push_screen_wait(ChooseFile())
        if reference is not None:
            self._replace(reference)

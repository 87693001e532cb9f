"""New run: a preset whose every option can be changed, checked while typing."""

import asyncio
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.command import CommandPalette
from textual.containers import Vertical
from textual.events import DescendantFocus
from textual.widgets import Input, Select, Static

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.creation import create_run
from gaitsim.runs.files.folder import RUNS, free_name
from gaitsim.steering import create_drive, offered_commands
from gaitsim.tui.actions import bindings
from gaitsim.tui.builder import (
    SECTIONS,
    ExperimentBuilder,
    Validation,
    choose_plugin,
    load_preset,
    validate,
)
from gaitsim.tui.catalogue import Catalogue, read_catalogue
from gaitsim.tui.option_search import OptionSearch
from gaitsim.tui.screens.base import GaitScreen, PaletteCommand
from gaitsim.tui.screens.experiment_files import ask_load, ask_save
from gaitsim.tui.screens.questions import Confirm
from gaitsim.tui.widgets.experiment_head import KEYS, ExperimentHead
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.form import Field
from gaitsim.tui.widgets.header import Header
from gaitsim.tui.widgets.part import Part
from gaitsim.tui.widgets.sections import Sections

DEFAULT_PRESET = "spider"  # preset used if there is no draft
DEBOUNCE = 0.15  # seconds without a key before the text is checked


class New(GaitScreen):
    """Forms for every part of an experiment.

    Args:
        experiment: preset or file to start from; None restores the latest draft.

    Attributes:
        builder: current experiment; None until the preset is read.
        catalogue: installed plugins; None until they are loaded.
        validation: latest check of the experiment.
    """

    SUB_TITLE = "new run"
    CSS_PATH = "new.tcss"
    HELP_TEXT = """
Start from a preset and change any option. Each tab is a part of the experiment, with the options
that its plugin declares. Problems appear below the option as you type, and a ✗ marks the tab. Only
plugins that work with the body are offered; choosing a different body also replaces parts that do
not.

The screen shows the equivalent **command** and the experiment **file**. / or Ctrl-F **searches**
the options by words. Leaving the screen keeps your changes as a draft, which the next new run
restores; Ctrl-Z undoes all changes.
"""
    BINDINGS = bindings("new")

    def __init__(self, experiment: str | None = None) -> None:
        super().__init__()
        self._experiment = experiment
        self._loading, self._run_once_loaded = True, False
        self._saved: ExperimentBuilder | None = None
        self.catalogue: Catalogue | None = None
        self.builder: ExperimentBuilder | None = None
        self.validation: Validation | None = None

    def compose(self) -> ComposeResult:
        yield Header()
        yield ExperimentHead(id="new-head")
        yield Sections(id="new-body")
        with Vertical(id="new-status"):
            yield Static("Loading the plugins …", id="status")
            yield Static(id="command", classes="command")
        yield Footer()

    def on_mount(self) -> None:
        self._load_preset(self._experiment or next(reversed(self.gaitsim.drafts), DEFAULT_PRESET))

    # Work in threads, because importing plugins is slow

    @work(exclusive=True, group="validate")
    async def _load_preset(self, reference: str) -> None:
        """Load a preset or a file."""
        self._loading = self.sections.disabled = True
        try:
            if self.catalogue is None:
                self.catalogue = await self.in_thread(read_catalogue)
            draft = self.gaitsim.drafts.get(reference)
            builder = draft or ExperimentBuilder(await self.in_thread(load_preset, reference))
            found = await self.in_thread(validate, builder, self.catalogue)
        except GaitsimError as error:
            self._fill_presets(self.builder.preset.reference if self.builder else reference)
            self._show_status(str(error), wrong=True)
            self._run_once_loaded = False
        else:
            self.builder = builder
            self._fill_presets(builder.preset.reference)
            self.query_one(ExperimentHead).fill(builder)
            self._show(found)
            if draft:
                self.notify(
                    f"Restored your draft: {builder.changes_text}. Ctrl-Z undoes all changes."
                )
        self._loading, self.sections.disabled = False, self.builder is None
        if self._run_once_loaded:
            self.action_run()

    @work(exclusive=True, group="validate")
    async def _validate(self, delay: float = 0.0) -> None:
        await asyncio.sleep(delay)
        if self.builder is not None and self.catalogue is not None:
            self._show(await self.in_thread(validate, self.builder, self.catalogue))

    # Showing

    def _fill_presets(self, reference: str) -> None:
        presets = self.catalogue.presets if self.catalogue else ()
        self.query_one(ExperimentHead).fill_presets([one.name for one in presets], reference)

    def _show(self, found: Validation) -> None:
        self.validation = found
        self.sections.show(found)
        self.query_one(ExperimentHead).show_problems(found.problems.keys())
        run = self._run() if found.problems else free_name(self._run())
        self._show_status(found.summary(run), wrong=bool(found.problems))
        self.query_one("#command", Static).update(Text(visible(f"$ {self.command_line()}")))
        self.refresh_bindings()

    def _show_status(self, text: str, *, wrong: bool) -> None:
        status = self.query_one("#status", Static)
        status.set_class(wrong, "problem")
        status.update(Text(visible_lines(text)))

    @property
    def sections(self) -> Sections:
        return self.query_one(Sections)

    @on(DescendantFocus, "#name,#seed")
    def _follow(self, event: DescendantFocus) -> None:
        self.sections.mark_line(str(event.widget.id))

    @work(group="search")
    async def action_search(self) -> None:
        """Search the options of all sections."""
        await self.app.push_screen_wait(
            CommandPalette(providers=[OptionSearch], placeholder="Search options: rate, noise, …")
        )

    def go_to(self, key: str, plugin: str = "") -> None:
        """Focus an option, after choosing its plugin if one is given."""
        section = key.partition(".")[0]
        self.sections.active = section
        if plugin:
            self._choose(section, plugin)
        self.sections.part(section).focus_on(key, later=bool(plugin))

    # Changing

    @on(Field.Changed)
    def _changed(self, event: Field.Changed) -> None:
        self._assign(event.key, event.text)

    @on(Input.Changed, "#name,#seed")
    def _head_changed(self, event: Input.Changed) -> None:
        key = str(event.input.id)
        if self.builder is not None:
            same = event.value == str(self.builder.preset.values[key])
            self._assign(key, None if same else event.value)

    def _assign(self, key: str, text: str | None) -> None:
        if self.builder is not None and not self._loading:
            self.builder = self.builder.assign(key, text)
            self._validate(DEBOUNCE)

    @on(Part.PluginChosen)
    def _plugin_chosen(self, event: Part.PluginChosen) -> None:
        self._choose(event.section, event.name)

    def _choose(self, section: str, plugin: str) -> None:
        if self.validation is not None and self.catalogue is not None:
            self.builder = choose_plugin(self.validation, section, plugin, self.catalogue)
            self._validate()

    @on(Select.Changed, "#preset")
    def _preset_chosen(self, event: Select.Changed) -> None:
        self._replace(str(event.value))

    @work(group="replace", exclusive=True)
    async def _replace(self, reference: str) -> None:
        """Load a different preset, after asking whether to discard changes."""
        if self.builder is not None and self.builder.changes:
            about = f"{self.builder.changes_text} will be discarded."
            if not await self.app.push_screen_wait(Confirm(f"Load {reference}?", "Load", about)):
                self._fill_presets(self.builder.preset.reference)
                return
            self.gaitsim.drafts.pop(self.builder.preset.reference, None)
        self._load_preset(reference)

    def action_reset(self) -> None:
        if self.builder is not None:
            self._replace(self.builder.preset.reference)

    def action_tab(self, by: int) -> None:
        self.sections.switch(by)

    def _run(self) -> Path:
        name = self.validation.name if self.validation else DEFAULT_PRESET
        return self.gaitsim.folder / name

    def command_line(self) -> str:
        return self.validation.builder.command(self._run()) if self.validation else ""

    async def _require_valid(self) -> Validation | None:
        """Return the checked experiment, or None after showing the first invalid option."""
        if self.builder is None or self.catalogue is None or self._loading:
            return None
        self.workers.cancel_group(self, "validate")
        found = await self.in_thread(validate, self.builder, self.catalogue)
        self._show(found)
        if found.experiment is not None:
            return found
        self.app.bell()
        key = next(iter(found.problems))
        section = key.partition(".")[0]
        if section in SECTIONS:
            self.go_to(key)
        elif key in KEYS:
            self.query_one(f"#{key}").focus()
        return None

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield the command that steers the current body."""
        found = self.validation
        if found is not None and found.experiment is not None:
            experiment = found.experiment
            if offered_commands(experiment):
                load = partial(create_drive, experiment, {})
                steer = partial(self.show_screen, "steering.Steering", load, "")
                yield PaletteCommand("Steer", "Fly this body yourself with the arrow keys", steer)
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

    @work(exclusive=True, group="create")
    async def action_run(self) -> None:
        """Start the run, after the experiment has been loaded."""
        self._run_once_loaded = self._loading
        if self._loading:
            self._show_status("Loading the plugins; the run starts after that …", wrong=False)
            return
        found = await self._require_valid()
        if found is None or found.experiment is None:
            return
        folder = None if self._run().parent == RUNS else self._run()
        try:
            path = await asyncio.to_thread(create_run, found.experiment, folder)
        except GaitsimError as error:
            self.gaitsim.show_error(error)
        else:
            self.gaitsim.drafts.pop(found.builder.preset.reference, None)
            self.dismiss()
            self.show_screen("live.Live", path, resume=True)

    @work(group="files", exclusive=True)
    async def action_save(self) -> None:
        found = await self._require_valid()
        if found is None or found.experiment is None:
            return
        if await ask_save(self, found.name, found.experiment.to_toml()):
            self._saved = found.builder

    @work(group="files", exclusive=True)
    async def action_load(self) -> None:
        reference = await ask_load(self)
        if reference is not None:
            self._replace(reference)

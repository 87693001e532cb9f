"""New run: a preset, any part of it changed, checked as it is typed."""

import asyncio
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.command import CommandPalette
from textual.containers import Vertical
from textual.events import DescendantFocus
from textual.widgets import Input, Select, Static

from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.files.folder import RUNS, create_run, free_name
from gaitsim.steering import drive_with, offered_commands
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

FIRST = "spider"  # the preset that is taken where none is asked for
CALM = 0.15  # seconds without a key before what is typed is checked


class New(GaitScreen):
    """Forms for every part of an experiment.

    Args:
        experiment: a preset's name or a file to begin with; None takes up the latest draft.

    Attributes:
        builder: the experiment as it is now; None until the preset is read.
        catalogue: the installed plugins; None until they are loaded.
        validation: the latest check of it.
    """

    SUB_TITLE = "new run"
    CSS_PATH = "new.tcss"
    HELP_TEXT = """
Begin with a preset and change what you like. Each tab is a part of it, with the options
that its plugin declares; what is wrong is said below the option as you type, and a ✗ marks the
tab. Only plugins that work with the body are offered; another body brings parts that work with it.

What you change is shown as the **command** that does the same, and as the experiment **file**.
/ or Ctrl-F **searches** the options by words. Leaving keeps your changes as a draft, with which a
new run begins; Ctrl-Z takes them back.
"""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+r", "run", "Run", id="new.run", tooltip="Begin the run"),
        Binding(
            "ctrl+f", "search", "Find", priority=True, id="new.search", tooltip="Search options"
        ),
        Binding("slash", "search", "Search", show=False, id="new.words", tooltip="Search options"),
        Binding("ctrl+s", "save", "Save", id="new.save", tooltip="Save the experiment file"),
        Binding("ctrl+l", "load", "Load", id="new.load", tooltip="Begin with a file"),
        Binding("ctrl+z", "reset", "Reset", id="new.reset", tooltip="Take all changes back"),
        Binding("ctrl+right", "tab(1)", "Next", show=False, id="new.next", tooltip="Next tab"),
        Binding("ctrl+left", "tab(-1)", "Back", show=False, id="new.before", tooltip="Tab before"),
        Binding(
            "ctrl+y", "app.copy_command", "Copy", show=False, id="new.copy", tooltip="The command"
        ),
    ]

    def __init__(self, experiment: str | None = None) -> None:
        super().__init__()
        self._experiment = experiment
        self._loading, self._starts = True, False  # whether the run begins once all is loaded
        self._saved: ExperimentBuilder | None = None
        self.catalogue: Catalogue | None = None
        self.builder: ExperimentBuilder | None = None
        self.validation: Validation | None = None

    def compose(self) -> ComposeResult:
        yield Header()
        yield ExperimentHead(id="new-head")
        yield Sections(id="new-body")
        with Vertical(id="new-status"):
            yield Static("Reading what is installed …", id="status")
            yield Static(id="command", classes="command")
        yield Footer()

    def on_mount(self) -> None:
        self._begin(self._experiment or next(reversed(self.gaitsim.drafts), FIRST))

    # Threads, as plugins are imported and asked

    @work(exclusive=True, group="validate")
    async def _begin(self, reference: str) -> None:
        """Begin with a preset or a file."""
        self._loading = self.sections.disabled = True
        try:
            if self.catalogue is None:
                self.catalogue = await self.in_thread(read_catalogue)
            draft = self.gaitsim.drafts.get(reference)
            builder = draft or ExperimentBuilder(await self.in_thread(load_preset, reference))
            found = await self.in_thread(validate, builder, self.catalogue)
        except GaitsimError as error:
            self._fill_presets(self.builder.preset.reference if self.builder else reference)
            self._say(str(error), wrong=True)
            self._starts = False
        else:
            self.builder = builder
            self._fill_presets(builder.preset.reference)
            self.query_one(ExperimentHead).fill(builder)
            self._show(found)
            if draft:
                self.notify(f"Your draft is back: {builder.counted}. Ctrl-Z begins afresh.")
        self._loading, self.sections.disabled = False, self.builder is None
        if self._starts:
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
        self._say(found.summary(run), wrong=bool(found.problems))
        self.query_one("#command", Static).update(Text(visible(f"$ {self.command_line()}")))
        self.refresh_bindings()

    def _say(self, text: str, *, wrong: bool) -> None:
        status = self.query_one("#status", Static)
        status.set_class(wrong, "problem")
        status.update(Text(visible_lines(text)))

    @property
    def sections(self) -> Sections:
        return self.query_one(Sections)

    @on(DescendantFocus, "#name,#seed")
    def _follow(self, event: DescendantFocus) -> None:
        self.sections.follow(str(event.widget.id))

    @work(group="search")
    async def action_search(self) -> None:
        """Search the options of all sections."""
        await self.app.push_screen_wait(
            CommandPalette(providers=[OptionSearch], placeholder="Search options: rate, noise, …")
        )

    def go_to(self, key: str, plugin: str = "") -> None:
        """Put the focus on an option, after choosing its plugin where one is named."""
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
            self._validate(CALM)

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
        """Begin with another preset, if the changes may be dropped."""
        if self.builder is not None and self.builder.changes:
            about = f"{self.builder.counted} will be discarded."
            if not await self.app.push_screen_wait(
                Confirm(f"Begin with {reference}?", "Begin", about)
            ):
                self._fill_presets(self.builder.preset.reference)
                return
            self.gaitsim.drafts.pop(self.builder.preset.reference, None)
        self._begin(reference)

    def action_reset(self) -> None:
        if self.builder is not None:
            self._replace(self.builder.preset.reference)

    def action_tab(self, by: int) -> None:
        self.sections.turn(by)

    def _run(self) -> Path:
        name = self.validation.name if self.validation else FIRST
        return self.gaitsim.folder / name

    def command_line(self) -> str:
        return self.validation.builder.command(self._run()) if self.validation else ""

    async def _checked(self) -> Validation | None:
        """Return the experiment as it is now; None after showing the option that is wrong."""
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
        """Yield the command that steers the body as it is now."""
        found = self.validation
        if found is not None and found.experiment is not None:
            experiment = found.experiment
            if offered_commands(experiment):
                load = partial(drive_with, experiment, {})
                steer = partial(self.gaitsim.open_steering, load, "")
                yield PaletteCommand("Steer", "Fly this body yourself, by the arrow keys", steer)

    async def may_leave(self) -> bool:
        """Keep what was changed and not saved as a draft."""
        builder, drafts = self.builder, self.gaitsim.drafts
        if builder is not None:
            drafts.pop(builder.preset.reference, None)
            if builder.changes and builder is not self._saved:
                drafts[builder.preset.reference] = builder
        return True

    def on_unmount(self) -> None:
        """Tell of the draft once the screen is left, not while quitting asks about it."""
        draft = self.gaitsim.drafts.get(self.builder.preset.reference) if self.builder else None
        if draft is not None:
            self.app.notify(f"Kept as a draft: {draft.counted}. n takes it up.")

    @work(exclusive=True, group="create")
    async def action_run(self) -> None:
        """Begin the run; once the experiment is loaded, where it is not yet."""
        self._starts = self._loading
        if self._loading:
            self._say("Reading what is installed; the run begins after that …", wrong=False)
            return
        found = await self._checked()
        if found is None or found.experiment is None:
            return
        folder = None if self._run().parent == RUNS else self._run()
        try:
            path = await asyncio.to_thread(create_run, found.experiment, folder)
        except GaitsimError as error:
            self.gaitsim.tell(error)
        else:
            self.gaitsim.drafts.pop(found.builder.preset.reference, None)
            self.dismiss()
            self.gaitsim.open_run(path, go=True)

    @work(group="files", exclusive=True)
    async def action_save(self) -> None:
        found = await self._checked()
        if found is None or found.experiment is None:
            return
        if await ask_save(self, found.name, found.experiment.to_toml()):
            self._saved = found.builder

    @work(group="files", exclusive=True)
    async def action_load(self) -> None:
        reference = await ask_load(self)
        if reference is not None:
            self._replace(reference)

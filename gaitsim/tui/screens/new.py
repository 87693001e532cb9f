"""New run: a preset, any part of it changed, checked as it is typed."""

import asyncio
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Header, Input, Label, Select, Static, TabbedContent, TabPane

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.files.folder import RUNS, create_run, free_name
from gaitsim.tui.builder import (
    SECTIONS,
    ExperimentBuilder,
    Validation,
    choose_plugin,
    load_preset,
    validate,
)
from gaitsim.tui.catalogue import Catalogue, read_catalogue
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.screens.experiment_files import ask_load, ask_save
from gaitsim.tui.screens.questions import Confirm
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.form import Field
from gaitsim.tui.widgets.part import Part
from gaitsim.tui.widgets.toml_view import coloured

FIRST = "spider"  # the preset that is taken where none is asked for
TITLES = {"evolution": "Search", "islands": "Islands", "organism": "Body"} | {
    kind: kind.capitalize() for kind in KINDS[1:]
}
FILE = "file"
CALM = 0.15  # seconds without a key before what is typed is checked


class New(GaitScreen):
    """Forms for every part of an experiment.

    Args:
        experiment: a preset's name or a file to begin with.

    Attributes:
        builder: the experiment as it is now; None until the preset is read.
        validation: the latest check of it.
    """

    SUB_TITLE = "new run"
    CSS_PATH = "new.tcss"
    HELP_TEXT = """
Begin with a preset and change what you like. Each tab is a part of it, with the options
that its plugin declares; what is wrong is said below the option as you type, and a ✗ marks the
tab. Only plugins that work with the body are offered; another body brings parts that work with it.

What you change is shown as the **command** that does the same, and as the experiment **file**.
"""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+r", "run", "Run", id="new.run", tooltip="Begin the run"),
        Binding("ctrl+s", "save", "Save file", id="new.save", tooltip="Save the experiment file"),
        Binding("ctrl+l", "load", "Load file", id="new.load", tooltip="Begin with a file"),
        Binding("ctrl+z", "reset", "Reset", id="new.reset", tooltip="Take all changes back"),
        Binding("ctrl+right", "tab(1)", "Next", show=False, id="new.next", tooltip="Next tab"),
        Binding("ctrl+left", "tab(-1)", "Back", show=False, id="new.before", tooltip="Tab before"),
        Binding(
            "ctrl+y", "app.copy_command", "Copy", show=False, id="new.copy", tooltip="The command"
        ),
    ]

    def __init__(self, experiment: str | None = None) -> None:
        super().__init__()
        self._experiment = experiment or FIRST
        self._catalogue: Catalogue | None = None
        self.builder: ExperimentBuilder | None = None
        self.validation: Validation | None = None

    def compose(self) -> ComposeResult:
        """Compose head, tabs and file, with status and command below."""
        yield Header()
        with Horizontal(id="new-head"):
            yield Label("begin with ")
            yield Select[str]([], prompt="…", compact=True, id="preset")
            yield Label(" name ")
            yield Input(compact=True, id="name")
            yield Label(" seed ")
            yield Input(compact=True, id="seed", type="text")
        with Horizontal(id="new-body"):
            with TabbedContent(id="parts"):
                for section in SECTIONS:
                    yield TabPane(TITLES[section], Part(section), id=f"part-{section}")
                with TabPane("File", id=f"part-{FILE}"), VerticalScroll():
                    yield Static(id="toml-tab", classes="toml")
            with VerticalScroll(id="beside"):
                yield Static(id="toml-beside", classes="toml")
        with Vertical(id="new-status"):
            yield Static("Reading what is installed …", id="status")
            yield Static(id="command", classes="command")
        yield Footer()

    def on_mount(self) -> None:
        self.query_one("#parts").disabled = True
        self._begin(self._experiment)

    # Threads, as plugins are imported and asked

    @work(exclusive=True, group="validate")
    async def _begin(self, reference: str) -> None:
        """Begin with a preset or a file."""
        try:
            if self._catalogue is None:
                self._catalogue = await self.in_thread(read_catalogue)
            builder = ExperimentBuilder(await self.in_thread(load_preset, reference))
            found = await self.in_thread(validate, builder, self._catalogue)
        except GaitsimError as error:
            self._fill_presets(self.builder.preset.reference if self.builder else reference)
            self._say(str(error), wrong=True)
        else:
            self._take(found)

    @work(exclusive=True, group="validate")
    async def _validate(self, delay: float = 0.0) -> None:
        """Check the experiment, unless it is changed meanwhile."""
        await asyncio.sleep(delay)
        if self.builder is not None and self._catalogue is not None:
            self._show(await self.in_thread(validate, self.builder, self._catalogue))

    # Showing

    def _take(self, found: Validation) -> None:
        """Show another preset."""
        preset = found.builder.preset
        self.builder = found.builder
        self._fill_presets(preset.reference)
        for key in ("name", "seed"):
            with self.prevent(Input.Changed):
                self.query_one(f"#{key}", Input).value = str(preset.values[key])
        self.query_one("#parts").disabled = False
        self._show(found)

    def _fill_presets(self, reference: str) -> None:
        known = [preset.name for preset in self._catalogue.presets] if self._catalogue else []
        names = known if reference in known else [*known, reference]
        select = self.query_one("#preset", Select)
        with self.prevent(Select.Changed):
            select.set_options([(Text(visible(name)), name) for name in names])
            select.value = reference

    def _show(self, found: Validation) -> None:
        self.validation = found
        self._show_part()
        for key in ("name", "seed"):
            self.query_one(f"#{key}").set_class(key in found.problems, "-wrong")
        tabs = self.query_one("#parts", TabbedContent)
        for section in SECTIONS:
            wrong = any(key.partition(".")[0] == section for key in found.problems)
            tabs.get_tab(f"part-{section}").label = "✗ " * wrong + TITLES[section]
        colours = self.app.theme_variables
        text = coloured(found.toml, colours["primary"], colours["secondary"])
        for place in ("#toml-tab", "#toml-beside"):
            self.query_one(place, Static).update(text if found.toml else "Once all is right.")
        run = self._run() if found.problems else free_name(self._run())
        self._say(found.summary(run), wrong=bool(found.problems))
        self.query_one("#command", Static).update(Text(visible(f"$ {self.command_line()}")))
        self.refresh_bindings()

    def _say(self, text: str, *, wrong: bool) -> None:
        status = self.query_one("#status", Static)
        status.set_class(wrong, "problem")
        status.update(Text(visible_lines(text)))

    @on(TabbedContent.TabActivated)
    def _show_part(self) -> None:
        """Update the visible part."""
        active = self.query_one("#parts", TabbedContent).active_pane
        if self.validation is not None and active is not None:
            for part in active.query(Part):
                part.show(self.validation)

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
        if self.builder is not None:
            self.builder = self.builder.assign(key, text)
            self._validate(CALM)

    @on(Part.PluginChosen)
    def _plugin_chosen(self, event: Part.PluginChosen) -> None:
        if self.validation is not None and self._catalogue is not None:
            self.builder = choose_plugin(
                self.validation, event.section, event.name, self._catalogue
            )
            self._validate()

    @on(Select.Changed, "#preset")
    def _preset_chosen(self, event: Select.Changed) -> None:
        self._replace(str(event.value))

    @work(group="replace", exclusive=True)
    async def _replace(self, reference: str) -> None:
        """Begin with another preset, if the changes may be dropped."""
        if self.builder is not None and self.builder.changes:
            count = len(self.builder.changes)
            about = "1 change is dropped." if count == 1 else f"{count} changes are dropped."
            question = Confirm(f"Begin with {reference}?", "Begin", about)
            if not await self.app.push_screen_wait(question):
                self._fill_presets(self.builder.preset.reference)
                return
        self._begin(reference)

    def action_reset(self) -> None:
        if self.builder is not None:
            self._replace(self.builder.preset.reference)

    def action_tab(self, by: int) -> None:
        tabs = self.query_one("#parts", TabbedContent)
        names = [f"part-{name}" for name in (*SECTIONS, FILE)]
        tabs.active = names[(names.index(tabs.active) + by) % len(names)]

    # Leaving with something

    def _run(self) -> Path:
        name = self.validation.name if self.validation else FIRST
        return self.gaitsim.folder / name

    def command_line(self) -> str:
        return self.validation.builder.command(self._run()) if self.validation else ""

    async def _checked(self) -> Validation | None:
        """Return the experiment as it is now; None after showing the option that is wrong."""
        if self.builder is None or self._catalogue is None:
            return None
        self.workers.cancel_group(self, "validate")
        found = await self.in_thread(validate, self.builder, self._catalogue)
        self._show(found)
        if found.experiment is not None:
            return found
        self.app.bell()
        key = next(iter(found.problems))
        section = key.partition(".")[0]
        if section in SECTIONS:
            self.query_one("#parts", TabbedContent).active = f"part-{section}"
            self.query_one(f"#part-{section} Part", Part).focus_on(key)
        elif key in ("name", "seed"):
            self.query_one(f"#{key}").focus()
        return None

    @work(exclusive=True, group="create")
    async def action_run(self) -> None:
        found = await self._checked()
        if found is None or found.experiment is None:
            return
        folder = None if self._run().parent == RUNS else self._run()
        try:
            path = await asyncio.to_thread(create_run, found.experiment, folder)
        except GaitsimError as error:
            self.gaitsim.tell(error)
        else:
            self.dismiss()
            self.gaitsim.open_run(path, go=True)

    @work(group="files", exclusive=True)
    async def action_save(self) -> None:
        found = await self._checked()
        if found is not None:
            await ask_save(self, found.name, found.toml)

    @work(group="files", exclusive=True)
    async def action_load(self) -> None:
        reference = await ask_load(self)
        if reference is not None:
            self._replace(reference)

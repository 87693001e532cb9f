"""New run: a preset, any part of it changed, checked as it is typed."""

from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.timer import Timer
from textual.widgets import Footer, Header, Input, Label, Select, Static, TabbedContent, TabPane

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS
from gaitsim.render.terminal.text import visible
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
from gaitsim.tui.screens.confirm import Confirm
from gaitsim.tui.screens.files import ask_load, ask_save
from gaitsim.tui.widgets.experiment_status import ExperimentStatus
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
        self._asked = experiment or FIRST
        self._catalogue: Catalogue | None = None
        self._builder: ExperimentBuilder | None = None
        self._validation: Validation | None = None
        self._serial = 0
        self._timer: Timer | None = None

    def compose(self) -> ComposeResult:
        """Head, tabs and file; status and command below."""
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
        yield ExperimentStatus("Reading what is installed …")
        yield Footer()

    def on_mount(self) -> None:
        """Read what is installed, in a thread: it imports every plugin."""
        self.query_one("#parts").disabled = True
        self._begin(self._asked)

    # Validation, in threads

    @work(thread=True, exclusive=True, group="ready")
    def _begin(self, reference: str) -> None:
        """Take a preset."""
        try:
            catalogue = self._catalogue or read_catalogue()
            self._catalogue = catalogue
            builder = ExperimentBuilder(load_preset(reference))
            found = validate(builder, catalogue)
        except GaitsimError as error:
            self.app.call_from_thread(self._not_begun, reference, error)
            return
        self.app.call_from_thread(self._take, found)

    def _not_begun(self, reference: str, error: GaitsimError) -> None:
        self._fill_presets(reference if self._builder is None else self._builder.preset.reference)
        self.query_one(ExperimentStatus).tell(str(error), wrong=True)

    def _check_soon(self) -> None:
        if self._timer is not None:
            self._timer.stop()
        self._timer = self.set_timer(CALM, self._check)

    def _check(self) -> None:
        if self._builder is not None:
            self._serial += 1
            self._read(self._builder, self._serial)

    @work(thread=True, exclusive=True, group="read")
    def _read(self, builder: ExperimentBuilder, serial: int) -> None:
        assert self._catalogue is not None
        found = validate(builder, self._catalogue)
        self.app.call_from_thread(self._checked, found, serial)

    def _checked(self, found: Validation, serial: int) -> None:
        if serial == self._serial:  # else something was typed meanwhile
            self._show(found)

    # Showing

    def _take(self, found: Validation) -> None:
        """Show a preset from the start."""
        self._builder = found.builder
        self._fill_presets(found.builder.preset.reference)
        values = found.builder.preset.values
        for key in ("name", "seed"):
            with self.prevent(Input.Changed):
                self.query_one(f"#{key}", Input).value = str(values[key])
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
        self._validation = found
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
        self.query_one(ExperimentStatus).show(found, run, self.command_line())
        self.refresh_bindings()

    @on(TabbedContent.TabActivated)
    def _show_part(self) -> None:
        """Bring the part that is in sight up to date."""
        active = self.query_one("#parts", TabbedContent).active_pane
        if self._validation is not None and active is not None:
            for part in active.query(Part):
                part.show(self._validation)

    # Changing

    @on(Field.Changed)
    def _changed(self, event: Field.Changed) -> None:
        self._assign(event.key, event.text)

    @on(Input.Changed, "#name,#seed")
    def _head_changed(self, event: Input.Changed) -> None:
        key = str(event.input.id)
        if self._builder is not None:
            same = event.value == str(self._builder.preset.values[key])
            self._assign(key, None if same else event.value)

    def _assign(self, key: str, text: str | None) -> None:
        if self._builder is not None:
            self._builder = self._builder.assign(key, text)
            self._serial += 1
            self._check_soon()

    @on(Part.PluginChosen)
    def _plugin_chosen(self, event: Part.PluginChosen) -> None:
        if self._validation is not None and self._catalogue is not None:
            self._builder = choose_plugin(
                self._validation, event.section, event.name, self._catalogue
            )
            self._check()

    @on(Select.Changed, "#preset")
    def _preset_chosen(self, event: Select.Changed) -> None:
        self._replace(str(event.value))

    @work(group="replace", exclusive=True)
    async def _replace(self, reference: str) -> None:
        """Begin with another preset, if what was changed may go."""
        if self._builder is not None:
            count, before = len(self._builder.changes), self._builder.preset.reference
            about = "1 change is dropped." if count == 1 else f"{count} changes are dropped."
            question = Confirm(f"Begin with {reference}?", "Begin", about)
            if count and not await self.app.push_screen_wait(question):
                self._fill_presets(before)
                return
        self._begin(reference)

    def action_reset(self) -> None:
        """Take all changes back."""
        if self._builder is not None:
            self._replace(self._builder.preset.reference)

    def action_tab(self, by: int) -> None:
        """Go to another part."""
        tabs = self.query_one("#parts", TabbedContent)
        names = [f"part-{name}" for name in (*SECTIONS, FILE)]
        tabs.active = names[(names.index(tabs.active) + by) % len(names)]

    # Leaving with something

    def _run(self) -> Path:
        name = self._validation.name if self._validation else FIRST
        return self.gaitsim.folder / name

    def command_line(self) -> str:
        """What begins the same run."""
        return self._validation.builder.command(self._run()) if self._validation else ""

    def _whole(self) -> Validation | None:
        """The experiment as it stands now; None, and said why, where it is wrong."""
        if self._builder is None or self._catalogue is None:
            return None
        found = validate(self._builder, self._catalogue)
        self._serial += 1
        self._show(found)
        if found.experiment is None:
            self.app.bell()
            self._go_to(next(iter(found.problems)))
            return None
        return found

    def _go_to(self, key: str) -> None:
        """Show the option that is wrong."""
        section = key.partition(".")[0]
        if section in SECTIONS:
            self.query_one("#parts", TabbedContent).active = f"part-{section}"
            self.query_one(f"#part-{section} Part", Part).focus_on(key)
        elif key in ("name", "seed"):
            self.query_one(f"#{key}").focus()

    def action_run(self) -> None:
        """Begin the run, and show it."""
        found = self._whole()
        if found is not None:
            self._create(found)

    @work(thread=True, exclusive=True, group="create")
    def _create(self, found: Validation) -> None:
        assert found.experiment is not None
        wanted = self._run()
        try:
            path = create_run(found.experiment, None if wanted.parent == RUNS else wanted)
        except GaitsimError as error:
            self.app.call_from_thread(self.gaitsim.tell, error)
            return
        self.app.call_from_thread(self._created, path)

    def _created(self, path: Path) -> None:
        self.dismiss()
        self.gaitsim.open_run(path, go=True)

    @work(group="files", exclusive=True)
    async def action_save(self) -> None:
        """Save the experiment file."""
        found = self._whole()
        if found is not None:
            await ask_save(self, found.name, found.toml)

    @work(group="files", exclusive=True)
    async def action_load(self) -> None:
        """Begin with an experiment file."""
        reference = await ask_load(self)
        if reference is not None:
            self._replace(reference)

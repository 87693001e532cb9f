"""New run: a preset whose every option can be changed, checked while typing."""

import asyncio
from collections.abc import Collection, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple, cast

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.events import DescendantFocus
from textual.widgets import Button, Input, Label, Static

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS, options
from gaitsim.registry.options import PLUGIN
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.steering import create_drive, offered_commands
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import RUNS, free_name
from gaitsim.tui.builder import (
    SECTIONS,
    ExperimentBuilder,
    Validation,
    choose_plugin,
    load_preset,
    validate,
)
from gaitsim.tui.catalogue import Catalogue, read_catalogue
from gaitsim.tui.formatting import clip_name
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import CommandPalette, GaitScreen, PaletteCommand
from gaitsim.tui.screens.files import ChooseFile
from gaitsim.tui.screens.presets import Presets
from gaitsim.tui.screens.questions import Ask, Confirm
from gaitsim.tui.widgets.form import Field, Part, Sections

KEYS = ("name", "seed")
PRESET = 26  # cells of the name of a preset
DEFAULT_PRESET = "spider"  # preset used if there is no draft
POLL = 0.02  # seconds between two looks whether the plugins are loaded
DEBOUNCE = 0.15  # seconds without a key before the text is checked


async def ask_save(screen: GaitScreen, name: str, toml: str) -> bool:
    """Ask where to save an experiment; return whether it was saved. Await it in a worker."""
    ask = Ask("Save the experiment file as", f"{name}.toml", about="The file lists every option.")
    answer = await screen.app.push_screen_wait(ask)
    if answer is None:
        return False
    path = Path(answer if answer.endswith(".toml") else f"{answer}.toml").expanduser()
    question = Confirm(f"Replace {path}?", "Replace", "The file exists.", danger=True)
    if path.exists() and not await screen.app.push_screen_wait(question):
        return False
    try:
        await asyncio.to_thread(write_bytes, path, toml.encode())
    except GaitsimError as error:
        screen.gaitsim.show_error(error)
        return False
    screen.notify(f"{path}\n$ gaitsim run {path}", title="Saved", markup=False)
    return True


class ExperimentHead(Horizontal):
    """The preset, and two inputs whose IDs are the keys of their options."""

    def compose(self) -> ComposeResult:
        yield Label("start from ")
        yield Button("…", compact=True, id="preset")
        yield Label(" name ")
        yield Input(compact=True, id="name")
        yield Label(" seed ")
        yield Input(compact=True, id="seed", type="text")

    def show_preset(self, reference: str) -> None:
        """Show the name of a preset or the path of a file."""
        button = self.query_one("#preset", Button)
        button.label = Content(f"{clip_name(reference, PRESET)} ▾")
        button.refresh(layout=True)  # a new label does not change the width by itself

    def fill(self, builder: ExperimentBuilder) -> None:
        """Show the name and the seed."""
        for key in KEYS:
            with self.prevent(Input.Changed):
                text = builder.changes.get(key, str(builder.preset.values[key]))
                self.query_one(f"#{key}", Input).value = text

    def show_problems(self, keys: Collection[str]) -> None:
        """Mark the invalid inputs."""
        for key in KEYS:
            self.query_one(f"#{key}").set_class(key in keys, "-wrong")


class FoundOption(NamedTuple):
    """An option: its key, value and meaning, and its plugin if a different one is chosen."""

    key: str
    text: str
    meaning: str
    plugin: str = ""

    def score(self, query: str) -> float:
        """Return the score of a match, 0 to 1; 0 if a word of the query is missing."""
        words = query.casefold().split()
        key, rest = self.key.casefold(), f"{self.text} {self.plugin} {self.meaning}".casefold()
        if not all(word in key or word in rest for word in words):
            return 0.0
        named = sum(word in key for word in words) / max(1, len(words))
        exact = key.rpartition(".")[2] in words
        return (0.1 + 0.4 * named + 0.2 * exact) * (0.5 if self.plugin else 1.0)


def known_options(found: Validation, catalogue: Catalogue) -> Iterator[FoundOption]:
    """Yield the options of the experiment, then those of other plugins that work with its body."""
    for section, form in found.forms.items():
        if form.plugin:
            yield FoundOption(f"{section}.{PLUGIN}", form.plugin, form.about.split("\n")[0])
        for one in form.options:
            yield FoundOption(one.key, one.text, options.meaning(one.field))
    for kind in KINDS:
        for name in found.offered[kind]:
            if kind in found.forms and name != found.forms[kind].plugin:
                for option, field in catalogue.classes[kind][name].model_fields.items():
                    text = "" if field.is_required() else options.default(field)
                    yield FoundOption(f"{kind}.{option}", text, options.meaning(field), name)


class OptionSearch(Provider):
    """Options as entries of the palette; a chosen option gets the focus."""

    def _rows(self) -> Iterator[tuple[FoundOption, Content, str, partial[None]]]:
        screen = cast(New, self.screen)
        if screen.validation is None or screen.catalogue is None:
            return
        for one in known_options(screen.validation, screen.catalogue):
            title = f"{one.key}  {one.text}" + (f"  (plugin {one.plugin})" if one.plugin else "")
            go = partial(screen.go_to, one.key, one.plugin)
            yield one, Content(visible(title)), visible(one.meaning).replace("[", "\\["), go

    async def discover(self) -> Hits:
        """Yield the options of the experiment while the query is empty."""
        for one, title, about, go in self._rows():
            if not one.plugin:
                yield DiscoveryHit(title, go, title.plain, about)

    async def search(self, query: str) -> Hits:
        """Yield the options that contain all words of the query."""
        for one, title, about, go in self._rows():
            if (score := one.score(query)) > 0:
                yield Hit(score, title, go, title.plain, about)


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
        self._loading, self._run_once_loaded = True, False
        self._saved: ExperimentBuilder | None = None
        self.catalogue: Catalogue | None = None
        self.builder: ExperimentBuilder | None = None
        self.validation: Validation | None = None

    def content(self) -> ComposeResult:
        yield ExperimentHead(id="new-head")
        yield Sections(id="new-body")
        with Vertical(id="new-status"):
            yield Static("Loading the plugins …", id="status")
            yield Static(id="command", classes="command")

    def on_mount(self) -> None:
        self._load_preset(self._experiment or next(reversed(self.gaitsim.drafts), DEFAULT_PRESET))

    # Work in threads, because importing plugins is slow

    @work(exclusive=True, group="validate")
    async def _load_preset(self, reference: str) -> None:
        """Load a preset or a file."""
        self._loading = self.sections.disabled = True
        try:
            if self.catalogue is None:
                known = self.gaitsim.catalogue
                self.catalogue = known or await self.in_thread(read_catalogue)
                self.gaitsim.catalogue = self.catalogue
            draft = self.gaitsim.drafts.get(reference)
            builder = draft or ExperimentBuilder(await self.in_thread(load_preset, reference))
            found = await self.in_thread(validate, builder, self.catalogue)
        except GaitsimError as error:
            self.head.show_preset(self.builder.preset.reference if self.builder else reference)
            self._show_status(str(error), wrong=True)
            self._run_once_loaded = False
        else:
            self.builder = builder
            self.head.show_preset(builder.preset.reference)
            self.head.fill(builder)
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

    def _show(self, found: Validation) -> None:
        self.validation = found
        self.sections.show(found)
        self.head.show_problems(found.problems.keys())
        run = self._run() if found.problems else free_name(self._run())
        taken = "" if run == self._run() else f"; the name {self._run().name} is taken"
        self._show_status(f"{found.summary(run)}{taken}", wrong=bool(found.problems))
        self.query_one("#command", Static).update(Text(visible(f"$ {self.command_line()}")))
        self.refresh_bindings()

    def _show_status(self, text: str, *, wrong: bool) -> None:
        status = self.query_one("#status", Static)
        status.set_class(wrong, "problem")
        status.update(Text(visible_lines(text)))

    @property
    def head(self) -> ExperimentHead:
        return self.query_one(ExperimentHead)

    @property
    def sections(self) -> Sections:
        return self.query_one(Sections)

    @on(DescendantFocus, "#name,#seed")
    def _follow(self, event: DescendantFocus) -> None:
        self.sections.mark_line(str(event.widget.id))

    @work(group="ask")
    async def action_search(self) -> None:
        """Search the options of all sections, once they are loaded."""
        while self._loading and self.validation is None:
            await asyncio.sleep(POLL)
        await self.app.push_screen_wait(
            CommandPalette(providers=[OptionSearch], placeholder="Search options: rate, noise, …")
        )

    def go_to(self, key: str, plugin: str = "") -> None:
        """Focus an option, after choosing its plugin if one is given."""
        if not self.query(Sections):  # the screen was closed since the option was chosen
            return
        section = key.partition(".")[0]
        self.sections.active = section
        if plugin:
            self._choose(section, plugin)
        self.sections.part(section).focus_on(key, later=bool(plugin))

    # Changing

    @on(Field.Edited)
    def _changed(self, event: Field.Edited) -> None:
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

    @work(group="ask", exclusive=True)
    async def action_save(self) -> None:
        found = await self._require_valid()
        if found is None or found.experiment is None:
            return
        if await ask_save(self, found.name, found.experiment.to_toml()):
            self._saved = found.builder

    @work(group="ask", exclusive=True)
    async def action_load(self) -> None:
        reference = await self.app.push_screen_wait(ChooseFile())
        if reference is not None:
            self._replace(reference)

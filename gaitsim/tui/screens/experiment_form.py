"""The form of an experiment, whose every option can be changed, checked while typing.

`New` and `ChangeForm` are such forms.
"""

import asyncio
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple, cast

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.command import DiscoveryHit, Hit, Hits, Provider
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Static

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment
from gaitsim.registry import KINDS, options
from gaitsim.registry.options import PLUGIN
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.builder import SECTIONS, ExperimentBuilder, Validation, choose_plugin, validate
from gaitsim.tui.catalogue import Catalogue, read_catalogue
from gaitsim.tui.screens.base import CommandPalette, GaitScreen
from gaitsim.tui.screens.presets import draw_body
from gaitsim.tui.widgets.form import Field, Part, Sections

POLL = 0.02  # seconds between two looks whether the plugins are loaded
DEBOUNCE = 0.15  # seconds without a key before the text is checked
NARROW, WIDE = (30, 8), (56, 18)  # columns and rows of the picture beside questions


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
        screen = cast(ExperimentForm, self.screen)
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


class ExperimentForm(GaitScreen):
    """Forms for every part of an experiment.

    Attributes:
        builder: current experiment; None until it is read.
        catalogue: installed plugins; None until they are loaded.
        validation: latest check of the experiment.
        loading_experiment: whether an experiment is being read.
    """

    CSS_PATH = "experiment_form.tcss"

    def __init__(self) -> None:
        super().__init__()
        self.loading_experiment, self._accept_once_loaded = True, False
        self.catalogue: Catalogue | None = None
        self.builder: ExperimentBuilder | None = None
        self.validation: Validation | None = None

    def content(self) -> ComposeResult:
        yield from self.head()
        yield Sections(id="form-body")
        with Horizontal(id="form-status"):
            with Vertical():
                yield Static("Loading the plugins …", id="status")
                yield Static(id="command", classes="command")
            yield Static(id="form-picture")

    def head(self) -> ComposeResult:
        """Compose what is above the sections."""
        yield from ()

    def effect(self, found: Validation) -> str:
        """Return a line about the effect of a valid experiment; called in a thread.

        Raises:
            GaitsimError: the experiment cannot be used here.
        """
        raise NotImplementedError

    @property
    def sections(self) -> Sections:
        """The forms of the sections."""
        return self.query_one(Sections)

    # Work in threads, because importing plugins is slow

    @work(exclusive=True, group="validate")
    async def load(self, make: Callable[[], ExperimentBuilder]) -> None:
        """Show the experiment that `make` returns."""
        self.loading_experiment = self.sections.disabled = True
        try:
            if self.catalogue is None:
                known = self.gaitsim.catalogue
                self.catalogue = known or await self.in_thread(read_catalogue)
                self.gaitsim.catalogue = self.catalogue
            builder = await self.in_thread(make)
            found = await self._check(builder)
        except GaitsimError as error:
            self.loaded(None)
            self.show_status(str(error), wrong=True)
            self._accept_once_loaded = False
        else:
            self.builder = builder
            self.loaded(builder)
            self.show(found)
        self.loading_experiment, self.sections.disabled = False, self.builder is None
        if self._accept_once_loaded:
            self.accept()

    def loaded(self, builder: ExperimentBuilder | None) -> None:
        """Show the name of a loaded experiment; None if it could not be loaded."""

    async def _check(self, builder: ExperimentBuilder) -> Validation:
        assert self.catalogue is not None, "it is read before an experiment"
        return await self.in_thread(validate, builder, self.catalogue, self.effect)

    @work(exclusive=True, group="validate")
    async def _validate(self, delay: float = 0.0) -> None:
        await asyncio.sleep(delay)
        if self.builder is not None:
            self.show(await self._check(self.builder))

    # Showing

    def show(self, found: Validation) -> None:
        """Show the result of a check."""
        self.validation = found
        self.sections.show(found)
        self.show_status(found.summary, wrong=bool(found.problems))
        self.query_one("#command", Static).update(Text(visible(f"$ {self.command_line()}")))
        self.set_class(bool(found.questions), "-asked")
        if found.questions and found.experiment is not None:
            self._draw(found.experiment)
        self.refresh_bindings()

    @work(exclusive=True, group="picture")
    async def _draw(self, experiment: Experiment) -> None:
        """Draw the standing body beside the questions about its file."""
        size = WIDE if self.has_class("-wide") else NARROW
        picture = await self.in_thread(partial(draw_body, named=True), experiment, size)
        self.query_one("#form-picture", Static).update(Text(picture, "$primary"))

    def show_status(self, text: str, *, wrong: bool = False) -> None:
        """Show a text below the sections."""
        status = self.query_one("#status", Static)
        status.set_class(wrong, "problem")
        status.update(Text(visible_lines(text)))

    @work(group="ask")
    async def action_search(self) -> None:
        """Search the options of all sections, once they are loaded."""
        while self.loading_experiment and self.validation is None:
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
        self.assign(event.key, event.text)

    def assign(self, key: str, text: str | None) -> None:
        """Change an option; None restores the original value."""
        if self.builder is not None and not self.loading_experiment:
            self.builder = self.builder.assign(key, text)
            self._validate(DEBOUNCE)

    @on(Part.PluginChosen)
    def _plugin_chosen(self, event: Part.PluginChosen) -> None:
        self._choose(event.section, event.name)

    def _choose(self, section: str, plugin: str) -> None:
        if self.validation is not None and self.catalogue is not None:
            self.builder = choose_plugin(self.validation, section, plugin, self.catalogue)
            self._validate()

    def action_tab(self, by: int) -> None:
        self.sections.switch(by)

    # Accepting

    async def require_valid(self) -> Validation | None:
        """Return the checked experiment, or None after showing the first invalid option."""
        if self.builder is None or self.loading_experiment:
            return None
        self.workers.cancel_group(self, "validate")
        found = await self._check(self.builder)
        self.show(found)
        if not found.problems:
            return found
        self.app.bell()
        key = next(iter(found.problems))
        if key.partition(".")[0] in SECTIONS:
            self.go_to(key)
        elif key in ("name", "seed", "out"):
            self.query_one(f"#{key}").focus()
        return None

    @work(exclusive=True, group="leaving")  # holds the keys that follow
    async def accept(self) -> None:
        """Use the experiment, after it has been loaded, if it is valid."""
        self._accept_once_loaded = self.loading_experiment
        if self.loading_experiment:
            self.show_status("Loading the plugins; this continues after that …")
            return
        found = await self.require_valid()
        if found is not None:
            await self.use(found)

    async def use(self, found: Validation) -> None:
        """Use a valid experiment and close the screen."""
        raise NotImplementedError

"""Forms of options from their declarations; the sections of an experiment, each with its form."""

import asyncio
from dataclasses import dataclass
from typing import ClassVar

from pydantic.fields import FieldInfo
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.message import Message
from textual.widget import Widget
from textual.widgets import ContentSwitcher, Input, Label, Select, Static, Tab, Tabs

from gaitsim.errors import GaitsimError
from gaitsim.registry import KINDS, options
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.builder import SECTIONS, Option, Validation
from gaitsim.tui.formatting import clip
from gaitsim.tui.widgets.toml_view import TomlView

NAME = 22  # cells of an option's name
FILE = "file"
TITLES = {
    "evolution": "Run",
    "islands": "Islands",
    "worlds": "Worlds",
    "transferability": "Reality",
    "organism": "Body",
}
TITLES |= {kind: kind.capitalize() for kind in KINDS[1:]} | {FILE: "File"}


class Field(Vertical):
    """One option: its name, an input or a choice, and its unit, with its meaning below."""

    DEFAULT_CSS: ClassVar[str] = """
    Field { height: auto; margin-bottom: 1; }
    Field Horizontal { height: 1; }
    Field .field-name { width: 23; text-style: bold; }
    Field Input, Field Select { width: 30; }
    Field Input { background: $panel; padding: 0 1 !important; }
    Field Input:focus { background: $primary 25%; }
    Field .field-unit { width: 1fr; padding-left: 1; color: $text-muted; }
    Field .field-about { color: $text-muted; padding-left: 2; height: auto; }
    Field.-changed .field-name { color: $accent; }
    Field.-wrong .field-about { color: $error; }
    """

    @dataclass
    class Edited(Message):
        """Posted when the text of an option has changed; None stands for the preset's text."""

        key: str
        text: str | None

    def __init__(self, option: Option) -> None:
        super().__init__()
        self.option = option
        self._choices = options.choices(option.field)
        # Not all texts that are reported are edits: a choice reports its first value, too.
        self._text = option.text
        self.set_class(options.allowed(option.field) == "a string", "-text")

    def compose(self) -> ComposeResult:
        option = self.option
        name = option.key.rpartition(".")[2]
        with Horizontal():
            yield Label(Text(clip(name, NAME)), classes="field-name")
            if self._choices and option.text in self._choices:
                yield Select(
                    [(Text(choice), choice) for choice in self._choices],
                    value=option.text,
                    allow_blank=False,
                    compact=True,
                )
            else:
                unset = option.text == options.NOT_SET or (option.long and not self._is_changed)
                value = "" if unset else option.text
                yield Input(value, placeholder=_empty_value(option), compact=True)
            yield Label(Text(visible(options.unit(option.field))), classes="field-unit")
        yield Static(self._about(), classes="field-about")

    def on_mount(self) -> None:
        self.set_class(self._is_changed, "-changed")

    @property
    def _is_changed(self) -> bool:
        return self.option.text != self.option.preset

    def _about(self) -> Text:
        field: FieldInfo = self.option.field
        takes = (
            "" if self._choices else options.type_and_bounds(field)
        )  # the unit is beside the input
        if takes == "a string" and options.meaning(field):
            takes = ""
        parts = [part for part in (options.meaning(field), takes) if part]
        return Text(visible(" · ".join(parts)))

    def show_problem(self, problem: GaitsimError | None) -> None:
        """Show a short form of the problem below the input, or the option's description."""
        self.set_class(problem is not None, "-wrong")
        about = (
            self._about() if problem is None else Text(f"✗ {visible(self._short_problem(problem))}")
        )
        self.query_one(".field-about", Static).update(about)

    def _short_problem(self, problem: GaitsimError) -> str:
        """Return the allowed values of the option, or the problem if they do not explain it."""
        allowed = problem.allowed
        if allowed == options.allowed(self.option.field):
            return allowed
        parts = [problem.what, allowed and f"allowed: {allowed}", problem.remedy]
        return "; ".join(part for part in parts if part)

    @on(Input.Changed)
    def _typed(self, event: Input.Changed) -> None:
        event.stop()
        self._post(event.value or _empty_value(self.option))

    @on(Select.Changed)
    def _chosen(self, event: Select.Changed) -> None:
        event.stop()
        self._post(str(event.value))

    def _post(self, text: str) -> None:
        if text == self._text:
            return
        self._text = text
        changed = text != self.option.preset
        self.set_class(changed, "-changed")
        self.post_message(self.Edited(self.option.key, text if changed else None))


def _empty_value(option: Option) -> str:
    """Return the meaning of an empty input: not set, or the preset's value."""
    unset = options.optional(option.field) and not option.long
    return options.NOT_SET if unset else option.preset


class Part(VerticalScroll):
    """The form of a section; only a different plugin rebuilds it."""

    @dataclass
    class PluginChosen(Message):
        """Posted when a user chooses a plugin for a section."""

        section: str
        name: str

    def __init__(self, section: str, id: str) -> None:
        super().__init__(can_focus=False, id=id)
        self.section = section
        self._built_from: tuple[object, ...] = ()
        self._select: Select[str] | None = None  # of the plugin
        self._plugin = ""
        self._validation: Validation | None = None
        self._wanted_key = ""
        self._building = asyncio.Lock()

    def show(self, found: Validation) -> None:
        """Show the section of a validation."""
        self._validation = found
        form = found.forms[self.section]
        source = (found.builder.preset, form.plugin, found.offered.get(self.section))
        if source != self._built_from:
            self._built_from = source
            self._build(source, found)
        else:
            self._show_problems()

    def _show_problems(self) -> None:
        for field in self.query(Field):
            if self._validation is not None:
                field.show_problem(self._validation.problems.get(field.option.key))

    @work(group="build")
    async def _build(self, source: tuple[object, ...], found: Validation) -> None:
        # Wait for an earlier build: a widget whose mounting is cancelled never gets its children.
        async with self._building:
            if source == self._built_from:
                await self._build_form(found)

    async def _build_form(self, found: Validation) -> None:
        form = found.forms[self.section]
        await self.remove_children()
        parts: list[Widget] = []
        if self.section in KINDS:
            names = found.offered[self.section]
            known = names if form.plugin in names else (*names, form.plugin)
            choices = [(Text(visible(name)), name) for name in known]
            self._plugin = form.plugin
            self._select = Select(
                choices, value=form.plugin, allow_blank=False, compact=True, classes="plugin"
            )
            name = Label("plugin", classes="field-name")
            parts.append(Horizontal(name, self._select, classes="row"))
        if form.about:
            parts.append(Static(Text(visible(form.about.split("\n\n")[0])), classes="about"))
        if form.problem is not None:
            parts.append(Static(Text(visible_lines(str(form.problem))), classes="problem"))
        elif not form.options:
            parts.append(Static("This part has no options.", classes="about"))
        await self.mount_all([*parts, *map(Field, form.options)])
        self._show_problems()
        self.focus_on(self._wanted_key)

    def focus_on(self, key: str, *, later: bool = False) -> None:
        """Focus the field of a key: an option, or the choice of the plugin.

        Args:
            key: key of the option.
            later: whether to wait for the form of a different plugin.
        """
        self._wanted_key = ""
        fields = {} if later else {field.option.key: field for field in self.query(Field)}
        if key in fields:
            fields[key].query("Input, Select").first().focus()
        elif key.endswith(".plugin") and self.query(".plugin"):
            self.query(".plugin").first().focus()
        else:
            self._wanted_key = key  # retried once the form is built

    @on(Select.Changed, ".plugin")
    def _chosen(self, event: Select.Changed) -> None:
        event.stop()
        # A choice reports its first value, too, even after the form was built again.
        if event.select is self._select and event.value != self._plugin:
            self._plugin = str(event.value)
            self.post_message(self.PluginChosen(self.section, self._plugin))


class Sections(Vertical):
    """Tabs across the full width; below them, the form of one section and the experiment file."""

    def __init__(self, id: str) -> None:
        super().__init__(id=id)
        self._validation: Validation | None = None

    def compose(self) -> ComposeResult:
        """Compose the tabs, a form for each section, and the file."""
        yield Tabs(*(Tab(title, id=name) for name, title in TITLES.items()), id="sections")
        with Horizontal():
            with ContentSwitcher(id="parts", initial=f"part-{SECTIONS[0]}"):
                for section in SECTIONS:
                    yield Part(section, id=f"part-{section}")
                yield TomlView(id=f"part-{FILE}")
            yield TomlView(id="beside")

    @property
    def active(self) -> str:
        """The name of the visible section."""
        return self.query_one(Tabs).active

    @active.setter
    def active(self, name: str) -> None:
        self.query_one(Tabs).active = name

    def switch(self, by: int) -> None:
        """Show the section that is `by` tabs further."""
        used = self._validation.used_sections if self._validation else SECTIONS
        names = [name for name in TITLES if name in (*used, FILE)]
        self.active = names[(names.index(self.active) + by) % len(names)]

    def part(self, section: str) -> Part:
        """Return the form of a section."""
        return self.query_one(f"#part-{section}", Part)

    def show(self, found: Validation) -> None:
        """Show a validation: the active form, the tabs with problems, and the file."""
        self._validation = found
        self._show_part()
        tabs = self.query_one(Tabs)
        for section in SECTIONS:
            (tabs.show if section in found.used_sections else tabs.hide)(section)
            wrong = any(key.partition(".")[0] == section for key in found.problems)
            self.query_one(f"#{section}", Tab).label = "✗ " * wrong + TITLES[section]
        for view in self.query(TomlView):
            view.show(found.toml)

    @on(Tabs.TabActivated)
    def _on_tab(self, event: Tabs.TabActivated) -> None:
        event.stop()
        self.query_one(ContentSwitcher).current = f"part-{self.active}"
        self._show_part()

    def _show_part(self) -> None:
        """Update only the visible form, as updates are slow."""
        if self._validation is not None and self.active in self._validation.used_sections:
            self.part(self.active).show(self._validation)

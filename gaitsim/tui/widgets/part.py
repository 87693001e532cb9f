"""The form of a section of an experiment: the choice of a plugin, and its options."""

import asyncio
from dataclasses import dataclass

from rich.text import Text
from textual import on, work
from textual.containers import Horizontal, VerticalScroll
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Input, Label, Select, Static

from gaitsim.registry import KINDS
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.builder import Validation
from gaitsim.tui.widgets.form import Field


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
            select = Select(
                choices, value=form.plugin, allow_blank=False, compact=True, classes="plugin"
            )
            parts.append(Horizontal(Label("plugin", classes="field-name"), select, classes="row"))
        if form.about:
            parts.append(Static(Text(visible(form.about.split("\n\n")[0])), classes="about"))
        if form.problem is not None:
            parts.append(Static(Text(visible_lines(str(form.problem))), classes="problem"))
        elif not form.options:
            parts.append(Static("This part has no options.", classes="about"))
        with self.prevent(Select.Changed, Input.Changed):
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
        name = str(event.value)
        if self._validation is not None and name != self._validation.forms[self.section].plugin:
            self.post_message(self.PluginChosen(self.section, name))

"""Choose a product of a run, such as a video, and its options."""

import asyncio
import shlex
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Literal

from pydantic.fields import FieldInfo
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Button, Input, OptionList, Static
from textual.widgets.option_list import Option as Row

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Which, mark_of
from gaitsim.registry import options
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.builder import Option
from gaitsim.tui.keys import bindings
from gaitsim.tui.products import (
    CommandForm,
    default,
    forms,
    remember,
    remembered,
    unavailable_products,
)
from gaitsim.tui.screens.base import Dialog, PaletteCommand
from gaitsim.tui.widgets.form import Field
from gaitsim.tui.widgets.lists import ChoiceList

Answer = tuple[str, ...] | Literal["files"] | None


class ExportDialog(Dialog[Answer]):
    """Ask what to export from a run; return the command's arguments, or 'files' to list files.

    Args:
        run: folder of the run.
        which: individual to export; None for the champion.
        others: folders of runs to compare with.
        damage: damage of the body, in the syntax of `--damage`.
        menu: menu of the commands of packages to offer instead; see `Action.menu`.
    """

    BINDINGS = bindings("export")

    def __init__(
        self,
        run: Path,
        which: Which = None,
        others: Sequence[Path] = (),
        damage: Sequence[str] = (),
        menu: str = "",
    ) -> None:
        super().__init__()
        self._run, self._menu = run, menu
        self._forms = forms(menu)
        self._all = tuple(form for found in self._forms.values() for form in found)
        # Typed texts by option, shared by all products.
        self._texts: dict[str, str] = {}
        for form in self._all:
            self._texts |= remembered(form)
        if isinstance(which, Member):
            self._texts["member"] = str(which.number)
        elif which is not None:
            self._texts["generation"] = mark_of(which).removeprefix("@")
        if damage:
            self._texts["damage"] = ", ".join(damage)
        if others:
            self._texts["runs"] = shlex.join(map(str, others))
        self._building = asyncio.Lock()
        self._lacking: Mapping[CommandForm, GaitsimError] = {}
        self._built: tuple[CommandForm, GaitsimError | None] | None = None  # what the form shows

    @property
    def takes_terminal(self) -> bool:
        """Whether the chosen command needs the terminal."""
        action = self._built[0].action if self._built else None
        return action is not None and action.terminal

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog", id="export") as box:
            verb = "Start" if self._menu else "Export"
            title = f"{self._menu or 'Export'}: {self._run}"
            box.border_title = Content(visible(title))
            files = "exported files · esc: cancel"
            box.border_subtitle = f"enter: {verb.lower()} · tab: options · f: {files}"
            with Horizontal(id="export-body"):
                yield ChoiceList(id="products")
                yield VerticalScroll(id="export-form", can_focus=False)
            yield Static(id="export-command", classes="command")
            with Horizontal(classes="dialog-buttons"):
                yield Button(verb, variant="primary", compact=True, id="make")
                yield Button("Show files", compact=True, id="show-files")
                yield Button("Cancel", compact=True, id="cancel")

    def on_mount(self) -> None:
        self._list()
        self._checking = self._check()

    @work
    async def _check(self) -> None:
        """Find the products that this run does not support, by simulating its champion."""
        try:
            self._lacking = await asyncio.to_thread(unavailable_products, self._run, self._all)
        except GaitsimError as error:
            self._lacking = dict.fromkeys(self._all, error)
        if self.is_attached:
            self._list()

    def _list(self) -> None:
        menu = self.query_one("#products", OptionList)
        at = menu.highlighted
        rows = []
        for group, found in self._forms.items():
            heading = "bold $secondary"
            rows.append(Row(Text(group, heading), disabled=True))
            for product in found:
                bad = product in self._lacking
                text = Text(f" ✗ {product.title}" if bad else f" {product.title}")
                text.stylize("dim" if bad else "")
                rows.append(Row(text, id=str(self._all.index(product))))
        menu.clear_options()
        menu.add_options(rows)
        menu.highlighted = 1 if at is None else at
        if self.focused is None:
            menu.focus()

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield a command for each product that the run supports."""
        menu = self.query_one("#products", OptionList)
        for place, product in enumerate(self._all):
            if product not in self._lacking and product in sum(self._forms.values(), ()):
                choose = partial(setattr, menu, "highlighted", menu.get_option_index(str(place)))
                about = f"Show the options of 'gaitsim {shlex.join(product.command)}'"
                yield PaletteCommand(product.title, about, choose)
        yield from super().palette()

    @property
    def _product(self) -> CommandForm:
        row = self.query_one("#products", OptionList).highlighted_option
        first = next(iter(self._forms.values()))[0]
        return self._all[int(row.id)] if row and row.id else first

    @on(OptionList.OptionHighlighted, "#products")
    @work(group="form")
    async def _show(self) -> None:
        """Show the options of the highlighted product, or why it is not available."""
        product = self._product
        async with self._building:  # one at a time: a half-built form cannot be removed
            wanted = product, self._lacking.get(product)
            # What was typed before the check ended stays, and keeps the focus.
            if product is self._product and self.is_attached and wanted != self._built:
                self._built = wanted
                await self._build(product)
                self._show_command()

    async def _build(self, product: CommandForm) -> None:
        form, error = self.query_one("#export-form"), self._lacking.get(product)
        parts: list[Widget] = []
        if error is not None:
            parts.append(Static(Text(visible_lines(f"✗ {error}")), classes="problem"))
        else:
            for name, field in product.fields().items():
                parts.append(Field(Option(name, field, default(field), self._text(name, field))))
        await form.remove_children()
        await form.mount_all(parts)
        form.scroll_home(animate=False)

    def _text(self, name: str, field: FieldInfo) -> str:
        """Return the text typed for an option, if it is valid for this product."""
        text, choices = self._texts.get(name, default(field)), options.choices(field)
        return text if not choices or text in choices else default(field)

    def _show_command(self) -> None:
        arguments = self._arguments()
        line = f"$ {shlex.join(['gaitsim', *arguments])}" if arguments else ""
        self.query_one("#export-command", Static).update(Text(visible(line)))
        self.query_one("#make", Button).disabled = not arguments

    def _arguments(self, *, asked: bool = False) -> tuple[str, ...]:
        """Return the command's arguments, or () after marking invalid options.

        With `asked`, missing values are marked too.
        """
        product = self._product
        if product in self._lacking:
            return ()
        fields = {field.option.key: field for field in self.query(Field)}
        texts = {name: self._text(name, field.option.field) for name, field in fields.items()}
        arguments, problems = product.read(self._run, texts)
        for name, field in fields.items():
            field.show_problem(problems.get(name) if asked or name in self._texts else None)
        return arguments

    @on(Field.Edited)
    def _changed(self, event: Field.Edited) -> None:
        if event.text is None:
            self._texts.pop(event.key, None)
        else:
            self._texts[event.key] = event.text
        self._show_command()

    @on(OptionList.OptionSelected, "#products")
    @on(Input.Submitted)
    @on(Button.Pressed, "#make")
    def action_make(self) -> None:
        self._make()

    @work(exclusive=True, group="make")
    async def _make(self) -> None:
        """Return the arguments, after the check that the run supports the product."""
        await self._checking.wait()
        async with self._building:  # until the form shows the highlighted product
            arguments = self._arguments(asked=True)
        if arguments:
            if self._built is not None:
                remember(self._built[0], self._texts)
            self.dismiss(arguments)
            return
        self.app.bell()
        for field in self.query("Field.-wrong"):
            field.query("Input, Select").first().focus()
            break

    @on(Button.Pressed, "#show-files")
    def action_files(self) -> None:
        self.dismiss("files")

    @on(Button.Pressed, "#cancel")
    def _cancel(self) -> None:
        self.dismiss(None)

"""Start a study, or a comparison of experiments over repeats."""

import asyncio
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field as Declared
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Static

from gaitsim.choices import PlotFormat
from gaitsim.errors import GaitsimError
from gaitsim.registry import STUDIES, entries
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.files.folder import free_name
from gaitsim.study.results import DEFAULT_FOLDERS
from gaitsim.tui.actions import bindings
from gaitsim.tui.builder import Option
from gaitsim.tui.product_options import Settings, split_words
from gaitsim.tui.products import Product, default
from gaitsim.tui.widgets.form import Field


class StudyOptions(Settings):
    """The options of `gaitsim study`."""

    study: Annotated[str, Declared(description="name of a bundled study, or a TOML file")] = ""
    workers: Annotated[
        int | None,
        Declared(ge=1, description="maximum number of parallel workers; none: one per core"),
    ] = None

    def arguments(self, run: Path) -> list[str]:
        """Return the study and the options."""
        return [self.study, *self._flags("study")]

    def folder(self) -> Path:
        """Check the request and return the folder to write."""
        from gaitsim.study.file import cells, read_study

        study, _ = read_study(self.study)
        cells(study, source=self.study)
        return free_name(DEFAULT_FOLDERS[0] / study.name)


class ComparisonOptions(Settings):
    """The options of `gaitsim compare`."""

    experiments: Annotated[
        str, Declared(description="two or more presets or files, separated by spaces")
    ] = ""
    repeats: Annotated[
        int, Declared(ge=2, le=100_000, description="number of repeats of each experiment")
    ] = 30
    evaluations: Annotated[
        int | None,
        Declared(
            ge=1,
            description="evaluations per repeat; none: the smallest number among the experiments",
        ),
    ] = None
    generations: Annotated[
        int | None,
        Declared(ge=1, description="number of generations per repeat, instead of evaluations"),
    ] = None
    population: Annotated[
        int | None,
        Declared(
            ge=1, description="number of individuals per generation; none: as in each experiment"
        ),
    ] = None
    targets: Annotated[
        str | None,
        Declared(
            description="target scores, such as 1.5,2; none: derived from the scores of all repeats"
        ),
    ] = None
    format: Annotated[PlotFormat, Declared(description="file format of the figures")] = "png"
    workers: Annotated[
        int | None,
        Declared(ge=1, description="maximum number of parallel workers; none: one per core"),
    ] = None

    def arguments(self, run: Path) -> list[str]:
        """Return the experiments and the options."""
        return [*split_words(self.experiments), *self._flags("experiments")]

    def folder(self) -> Path:
        """Check the request and return the folder to write."""
        from gaitsim.study.comparison import check_request, equal_budgets, load_experiments

        check_request(self.targets, self.evaluations, self.generations)
        given = {"generations": self.generations, "population": self.population}
        changes = {f"evolution.{key}": value for key, value in given.items() if value is not None}
        loaded = load_experiments(split_words(self.experiments), changes)
        equal_budgets(loaded, self.evaluations)
        return free_name(
            DEFAULT_FOLDERS[1] / "-against-".join(one.name for one in loaded.values())[:150]
        )


SWEEP = Product("New study", ("study",), StudyOptions)
COMPARISON = Product("New comparison", ("compare",), ComparisonOptions)


class StudyDialog(ModalScreen[tuple[str, ...] | None]):
    """Ask for the options of a study or a comparison; return the arguments of the command.

    Args:
        product: `SWEEP` or `COMPARISON`.
        texts: initial texts of the fields by option.
    """

    BINDINGS = bindings("study")
    DEFAULT_CSS = """
    StudyDialog {
        & VerticalScroll { height: auto; max-height: 38vh; }
        & Static { height: auto; }
    }
    """

    def __init__(self, product: Product, texts: Mapping[str, str] | None = None) -> None:
        super().__init__()
        self._product, self._texts = product, dict(texts or {})

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = self._product.title
            box.border_subtitle = "ctrl+r or enter: start · esc: cancel"
            if self._product is SWEEP:
                known = ", ".join(entries(STUDIES))
                yield Static(Text(visible(f"Bundled: {known}")), classes="dialog-about")
            with VerticalScroll(can_focus=False):
                for name, field in self._product.fields().items():
                    usual = default(field)
                    yield Field(Option(name, field, usual, self._texts.get(name, usual)))
            yield Static(id="study-problem", classes="problem")
            yield Static(id="study-command", classes="command")
            with Horizontal(classes="dialog-buttons"):
                yield Button("Start", variant="primary", compact=True, id="begin")
                yield Button("Cancel", compact=True, id="cancel")

    def on_mount(self) -> None:
        self._show()

    def _read(self, *, marked: bool = False) -> Any:
        """Return the options, or None if some are invalid; with `marked`, mark those."""
        found, problems = self._product.read(self._texts)
        for field in self.query(Field):
            if marked or field.option.key not in problems:
                field.show_problem(problems.get(field.option.key))
        return found

    def _show(self) -> None:
        found = self._read()
        words = () if found is None else self._arguments(found)
        line = f"$ {shlex.join(['gaitsim', *words])}" if words else ""
        self.query_one("#study-command", Static).update(Text(visible(line)))

    def _arguments(self, found: Any) -> tuple[str, ...]:
        return (*self._product.command, *found.arguments(Path()))

    @on(Field.Changed)
    def _changed(self, event: Field.Changed) -> None:
        if event.text is None:
            self._texts.pop(event.key, None)
        else:
            self._texts[event.key] = event.text
        self.query_one("#study-problem", Static).update("")
        self._show()

    @on(Input.Submitted)
    @on(Button.Pressed, "#begin")
    def action_start(self) -> None:
        self._submit()

    @work(exclusive=True, group="begin")
    async def _submit(self) -> None:
        """Close with the arguments if the experiments are valid."""
        found = self._read(marked=True)
        if found is None:
            self.app.bell()
            return
        problem = self.query_one("#study-problem", Static)
        problem.update(Text("Checking the experiments …"))
        try:
            folder = await asyncio.to_thread(found.folder)
        except GaitsimError as error:
            if self.is_attached:
                problem.update(Text(visible_lines(str(error))))
            return
        if self.is_attached:
            self.dismiss((*self._arguments(found), "--out", str(folder)))

    @on(Button.Pressed, "#cancel")
    def _cancel(self) -> None:
        self.dismiss(None)

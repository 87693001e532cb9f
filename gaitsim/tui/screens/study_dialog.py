"""Begin a study, or a comparison of experiments over repeats."""

import asyncio
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field as Declared
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Button, Input, Static

from gaitsim.choices import PlotFormat
from gaitsim.errors import GaitsimError
from gaitsim.registry import STUDIES, entries
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.files.folder import free_name
from gaitsim.study.folders import PLACES
from gaitsim.tui.builder import Option
from gaitsim.tui.product_options import Settings, split_words
from gaitsim.tui.products import Product, default
from gaitsim.tui.widgets.form import Field


class Sweep(Settings):
    """The options of `gaitsim study`."""

    study: Annotated[str, Declared(description="A bundled study, or a TOML file of your own.")] = ""
    workers: Annotated[int | None, Declared(ge=1, description="Processes. None: one a core.")] = (
        None
    )

    def words(self, run: Path) -> list[str]:
        """Return study and options."""
        return [self.study, *self._flags("study")]

    def folder(self) -> Path:
        """Return the folder to write, after a check.

        Raises:
            GaitsimError: the study has problems.
        """
        from gaitsim.study.file import cells, read_study

        study, _ = read_study(self.study)
        cells(study, source=self.study)
        return free_name(PLACES[0] / study.name)


class Contest(Settings):
    """The options of `gaitsim compare`."""

    experiments: Annotated[
        str, Declared(description="Two or more presets or files, with spaces.")
    ] = ""
    repeats: Annotated[int, Declared(ge=2, le=100_000, description="Of each experiment.")] = 30
    evaluations: Annotated[
        int | None,
        Declared(ge=1, description="Of each repeat. None: those of the shortest experiment."),
    ] = None
    generations: Annotated[
        int | None, Declared(ge=1, description="Of each repeat, instead of evaluations.")
    ] = None
    population: Annotated[int | None, Declared(ge=1, description="None: as in the experiment.")] = (
        None
    )
    targets: Annotated[
        str | None,
        Declared(description="Scores to reach, as 1.5,2. None: quartiles of all."),
    ] = None
    format: Annotated[PlotFormat, Declared(description="Of the figures.")] = "png"
    workers: Annotated[int | None, Declared(ge=1, description="Processes. None: one a core.")] = (
        None
    )

    def words(self, run: Path) -> list[str]:
        """Return experiments and options."""
        return [*split_words(self.experiments), *self._flags("experiments")]

    def folder(self) -> Path:
        """Return the folder to write, after a check.

        Raises:
            GaitsimError: an experiment has problems.
        """
        from gaitsim.study.comparison import check_request
        from gaitsim.study.competitors import equal_budgets, load_experiments

        check_request(self.targets, self.evaluations, self.generations)
        given = {"generations": self.generations, "population": self.population}
        changes = {f"evolution.{key}": value for key, value in given.items() if value is not None}
        loaded = load_experiments(split_words(self.experiments), changes)
        equal_budgets(loaded, self.evaluations)
        return free_name(PLACES[1] / "-against-".join(one.name for one in loaded.values())[:150])


SWEEP = Product("New study", ("study",), Sweep)
COMPARISON = Product("New comparison", ("compare",), Contest)


class StudyDialog(ModalScreen[tuple[str, ...] | None]):
    """Ask for the options of a study or a comparison; return the arguments of the command.

    Args:
        product: `SWEEP` or `COMPARISON`.
        texts: what stands in the fields at first, by option.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Cancel", id="study.cancel", tooltip="Begin nothing"),
        Binding("ctrl+r", "begin", "Begin", id="study.begin", tooltip="Begin, from any field"),
    ]
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
            box.border_subtitle = "ctrl-r or enter begins it · esc cancels"
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
                yield Button("Begin", variant="primary", compact=True, id="begin")
                yield Button("Cancel", compact=True, id="cancel")

    def on_mount(self) -> None:
        self._show()

    def _read(self, *, marked: bool = False) -> Any:
        """Return the options; None where some are wrong, which are marked if asked for."""
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
        return (*self._product.command, *found.words(Path()))

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
    def action_begin(self) -> None:
        self._begin()

    @work(exclusive=True, group="begin")
    async def _begin(self) -> None:
        """Return the arguments if the experiments have no problem."""
        found = self._read(marked=True)
        if found is None:
            self.app.bell()
            return
        said = self.query_one("#study-problem", Static)
        said.update(Text("Checking the experiments …"))
        try:
            folder = await asyncio.to_thread(found.folder)
        except GaitsimError as error:
            if self.is_attached:
                said.update(Text(visible_lines(str(error))))
            return
        if self.is_attached:
            self.dismiss((*self._arguments(found), "--out", str(folder)))

    @on(Button.Pressed, "#cancel")
    def _cancel(self) -> None:
        self.dismiss(None)

"""Start a study, or a comparison of experiments over repeats."""

import asyncio
import shlex
from collections.abc import Mapping

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.widgets import Button, Input, Static

from gaitsim.plugin import STUDIES, GaitsimError, entries
from gaitsim.plugin.pictures import visible, visible_lines
from gaitsim.screen import CommandForm, Dialog, Field, Option, bindings, default
from gaitsim_studies.compare_command import CompareExperiments
from gaitsim_studies.study_command import RunStudy

SWEEP = CommandForm("New study", ("study",), RunStudy)
COMPARISON = CommandForm("New comparison", ("compare",), CompareExperiments)


class StudyDialog(Dialog[tuple[str, ...] | None]):
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

    def __init__(self, product: CommandForm, texts: Mapping[str, str] | None = None) -> None:
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

    def _read(self, *, marked: bool = False) -> tuple[str, ...]:
        """Return the arguments, or () if some options are invalid; with `marked`, mark those."""
        arguments, problems = self._product.read(None, self._texts)
        for field in self.query(Field):
            if marked or field.option.key not in problems:
                field.show_problem(problems.get(field.option.key))
        return arguments

    def _show(self) -> None:
        words = self._read()
        line = f"$ {shlex.join(['gaitsim', *words])}" if words else ""
        self.query_one("#study-command", Static).update(Text(visible(line)))

    @on(Field.Edited)
    def _changed(self, event: Field.Edited) -> None:
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
        arguments = self._read(marked=True)
        if not arguments:
            self.app.bell()
            return
        problem = self.query_one("#study-problem", Static)
        problem.update(Text("Checking the experiments …"))
        try:
            action = self._product.build(self._texts)
            assert isinstance(action, RunStudy | CompareExperiments)
            folder = await asyncio.to_thread(action.free_folder)
        except GaitsimError as error:
            if self.is_attached:
                problem.update(Text(visible_lines(str(error))))
            return
        if self.is_attached:
            self.dismiss((*arguments, "--out", str(folder)))

    @on(Button.Pressed, "#cancel")
    def _cancel(self) -> None:
        self.dismiss(None)

"""Ask for new values of options with which to continue a run, checked while typing."""

import asyncio
import shlex
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.events import Key
from textual.widgets import Button, Input, Label, OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import TRANSFERABILITY, Overrides, Typed, parse_assignments
from gaitsim.experiment.overrides import COMMAND_LINE
from gaitsim.registry import options
from gaitsim.registry.options import PLUGIN
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.storage.files.folder import command
from gaitsim.storage.resume import plan_resume
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import Dialog, PaletteCommand

_NEED_DATA = {"enter", "tab"}  # keys that must wait until the data has been read
DEBOUNCE = 0.15  # seconds without a key before the text is checked


class AssignmentsField(Input):
    """The field for typed changes, which processes each key completely before the next one.

    Textual passes a key that is not a letter to the parents of a field before its binding runs.
    Letters that arrive together with it, as in a paste, would take effect first.

    Attributes:
        reading: whether Enter and Tab, and the keys after them, wait for `catch_up`.
    """

    BINDINGS = bindings("change field")

    def __init__(self, *values: Any, reading: bool = False, **settings: Any) -> None:
        super().__init__(*values, **settings)
        self.reading = reading
        self._held: list[Key] = []

    async def on_key(self, event: Key) -> None:
        if not (event.is_printable or self._own_binding(event)):
            return
        event.stop()
        event.prevent_default()
        if self._held or (self.reading and event.key in _NEED_DATA):
            self._held.append(event)
        else:
            await self._process(event)

    async def catch_up(self) -> None:
        """Process the waiting keys."""
        self.reading = False
        while self._held:  # keys that arrive meanwhile are appended
            await self._process(self._held[0])
            del self._held[0]

    async def _process(self, event: Key) -> None:
        if event.is_printable and event.character:
            self.replace(event.character, *self.selection)
        elif binding := self._own_binding(event):
            await self.app.run_action(binding.action, self)

    async def action_submit(self) -> None:
        await self.run_action("screen.accept")  # not deferred

    def _own_binding(self, event: Key) -> Binding | None:
        """Return the field's own binding of a key."""
        if not self.has_focus:  # the focus has moved in the meantime
            return next(iter(self._bindings.key_to_bindings.get(event.key, ())), None)
        found = self.screen.active_bindings.get(event.key)
        return found.binding if found and found.node is self else None


@dataclass(frozen=True)
class ChangeableOption:
    """A changeable option: its key, its current value, and its allowed values and meaning."""

    key: str
    value: str
    about: str


def changeable_options(run: RunSnapshot) -> list[ChangeableOption]:
    """Return the changeable options of a run's experiment, those that choose plugins last."""
    experiment = run.experiment
    models: dict[str, BaseModel] = {
        kind: experiment.plugin(kind) for kind in reversed(experiment.kinds)
    }
    models["evolution"] = experiment.evolution
    if experiment.islands.number > 1:
        models["islands"] = experiment.islands
    if experiment.reality is not None:
        models[TRANSFERABILITY] = experiment.transferability
    found = []
    for section, model in models.items():
        given = options.values(model)
        for name, declared in type(model).model_fields.items():
            if f"{section}.{name}" in ("evolution.population", "islands.number"):
                continue  # fixed after the start
            value = (
                options.format_brief(declared, given[name]) if name in given else options.NOT_SET
            )
            about = f"{options.allowed(declared)}. {options.meaning(declared)}"
            found.append(ChangeableOption(f"{section}.{name}", value, about))
    terms = ", ".join(run.checkpoint.terms) if run.checkpoint is not None else ""
    notes = {
        "organism": "name of a different body",
        "fitness": "name of a different fitness" + (terms and f"; terms of the score now: {terms}"),
    }
    chosen = [
        ChangeableOption(
            f"{kind}.{PLUGIN}",
            experiment.entries[kind].name,
            notes.get(kind, f"name of a different {kind}"),
        )
        for kind in experiment.kinds
        if kind != "search"  # fixed too
    ]
    return [*found, *chosen]


def parse_words(text: str) -> tuple[str, ...]:
    """Split a text as a shell does."""
    try:
        return tuple(shlex.split(text))
    except ValueError:
        raise GaitsimError("a quotation mark is not closed") from None


def describe_effect(run: RunSnapshot, overrides: Overrides) -> str:
    """Describe the effect of changes without applying them."""
    plans = plan_resume(run, overrides, generations=None, any_version=True)
    if plans.last is None:
        return "The first generation will have these options." if overrides else ""
    if not plans.changes:
        planned = f"{plans.experiment.evolution.generations:,}"
        return f"No new stage: evolution continues to generation {planned}." if overrides else ""
    changes = "".join(f"▶ {change}\n" for change in plans.changes)
    rescored = "; scores are not comparable to earlier scores" if plans.reevaluates else ""
    return f"{changes}from generation {run.generation + 1}{rescored}"


def format_error(error: GaitsimError) -> str:
    """Return an error's text without the location 'command line'."""
    for one in error.problems if isinstance(error, ExperimentError) else (error,):
        one.where = one.where.removeprefix(COMMAND_LINE).removeprefix(", ")
    return str(error)


@dataclass(frozen=True)
class ChangeRequest:
    """The answer of the dialog.

    Attributes:
        overrides: changed options by key.
        out: folder of the copy; None appends a number to the name of the run.
    """

    overrides: Overrides
    out: Path | None = None


class ChangeDialog(Dialog[ChangeRequest | None]):
    """Ask for changes of the experiment; return the request, or None.

    The list shows the options whose keys or meanings contain the typed word. Enter or Tab on such
    a word, or Enter in the list, completes it; Enter after a value accepts the changes.

    Args:
        run: folder of the run.
        fork: whether to fork the run, and ask for the folder of the copy.
        typed: initial text.
    """

    AUTO_FOCUS = "#change-text"
    BINDINGS = bindings("change")
    DEFAULT_CSS = """
    ChangeDialog {
        & OptionList {
            height: 1fr; min-height: 1; margin: 0; padding: 0; border: none; background: $panel;
            text-wrap: nowrap; text-overflow: ellipsis;
            &:focus { border: none; }
        }
        & Input { margin-bottom: 1; }
        & #change-about { height: auto; min-height: 2; max-height: 7; margin-top: 1; }
        & Label { color: $text-muted; }
    }
    """

    def __init__(self, run: Path, *, fork: bool = False, typed: str = "") -> None:
        super().__init__()
        self._run, self._fork = run, fork
        self._known: list[ChangeableOption] = []
        self._matched_word: str | None = None  # the word that filters the listed options
        self._seen: tuple[str, str] | None = None  # texts of both fields at the last check
        self._input = AssignmentsField(
            typed,
            reading=True,
            placeholder="KEY=VALUE …",
            select_on_focus=False,
            compact=True,
            id="change-text",
        )
        self._folder = Input(placeholder=f"{run}-2", compact=True, id="change-out")
        self._options = OptionList(id="change-options")
        self._message = Static("Reading the experiment …", id="change-message")
        self._shell = Static(id="change-command", classes="command")

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = what = "Fork" if self._fork else "Change"
            box.border_subtitle = "enter: accept · ↓: options · esc: cancel"
            if self._fork:
                yield Label("folder of the copy; the original run is not changed")
                yield self._folder
            yield Label("changes for the next generations, such as evolution.generations=900")
            yield self._input
            yield self._options
            with VerticalScroll(id="change-about", can_focus=False):
                yield self._message
            yield self._shell
            with Horizontal(classes="dialog-buttons"):
                yield Button(what, variant="primary", compact=True, id="change-do")
                yield Button("Cancel", compact=True, id="change-cancel")

    def on_mount(self) -> None:
        self._read()

    @work(group="read")
    async def _read(self) -> None:
        """Read the options in a thread, as this imports plugins."""
        try:
            self._known = await asyncio.to_thread(changeable_options, RunSnapshot(self._run))
        except GaitsimError as error:
            self._show_message(format_error(error), wrong=True)
        else:
            self._check()
        await self._input.catch_up()

    @on(Input.Changed)
    def _changed(self) -> None:
        self._list_matches()
        # This event may arrive after an Enter, whose request must not be lost.
        if self._texts != self._seen:
            self._check(DEBOUNCE)

    @on(Input.Submitted, "#change-out")
    def _submit(self) -> None:
        self._check(submit=True)

    def action_accept(self) -> None:
        """Complete the typed word, or accept the changes."""
        if not self._complete():
            self._check(submit=True)

    @on(Button.Pressed)
    def _pressed(self, event: Button.Pressed) -> None:
        if event.button.id == "change-do":
            self._check(submit=True)
        else:
            self.dismiss()

    def palette(self) -> Iterable[PaletteCommand]:
        """Yield a command for each option that can be changed."""
        for one in self._known:
            insert = partial(self._insert, one.key)
            yield PaletteCommand(visible(one.key), visible(f"{one.value}  {one.about}"), insert)
        yield from super().palette()

    @property
    def _texts(self) -> tuple[str, str]:
        return self._input.value, self._folder.value

    def _check(self, delay: float = 0.0, *, submit: bool = False) -> None:
        """Show the effect of the changes, unless the text changes before.

        Args:
            delay: seconds to wait for further typing.
            submit: whether to accept the changes if they are valid.
        """
        self._seen = self._texts
        self._list_matches()
        if submit:
            self._accept()
        else:
            self._show_effect(delay)

    @work(exclusive=True)
    async def _show_effect(self, delay: float) -> None:
        await asyncio.sleep(delay)
        await self._effect(submit=False)

    @work(exclusive=True, group="leaving")  # holds the keys that follow Enter
    async def _accept(self) -> None:
        self.workers.cancel_group(self, "default")
        await self._effect(submit=True)

    async def _effect(self, *, submit: bool) -> None:
        """Show the effect of the changes; accept them if they are to be submitted and valid."""
        try:
            words = parse_words(self._input.value)
            self._shell.update(Text(f"$ {self._command(words)}"))
            if self.focused is self._options and not submit:
                self._describe()
                return
            if words and "=" not in words[-1] and not submit:
                known = self._options.option_count
                self._show_message(
                    "Continue typing, or choose an option with ↓"
                    if known
                    else f"No option contains {words[-1]!r} in its name or meaning"
                )
                return
            overrides = parse_assignments(words)
            if missing := self._without_value(overrides):
                self._show_message(
                    f"Type a value for {missing.key}. "
                    f"Current value: {missing.value}; {missing.about}"
                )
                return
            self._show_message(
                await asyncio.to_thread(describe_effect, RunSnapshot(self._run), overrides)
            )
        except GaitsimError as error:
            self._show_message(format_error(error), wrong=True)
            return
        if submit:
            wanted = ChangeRequest(overrides, self._out())
            self.dismiss(wanted if overrides or self._fork else None)

    def _without_value(self, overrides: dict[str, Typed]) -> ChangeableOption | None:
        """Return the first option typed without a value, or None."""
        empty = [key for key, value in overrides.items() if not value]
        return next((one for one in self._known if one.key in empty), None)

    def _list_matches(self) -> None:
        """List the options that contain the beginning of the last word."""
        wanted = self._word.partition("=")[0]
        if not self._known or wanted == self._matched_word:
            return
        self._matched_word = wanted
        width = max(len(one.key) for one in self._known)
        self._options.clear_options()
        self._options.add_options(
            Option(
                Text.assemble(
                    one.key.ljust(width),
                    (f"  {visible(one.value)}  ", "bold"),
                    (visible(one.about), "dim"),
                    no_wrap=True,
                    overflow="ellipsis",
                ),
                one.key,
            )
            for one in self._matching(wanted)
        )
        self._options.highlighted = 0 if self._options.option_count else None

    def _matching(self, wanted: str) -> list[ChangeableOption]:
        """Return the options with the word in their keys, then those with it elsewhere."""
        named = [one for one in self._known if wanted in one.key]
        described = [
            one
            for one in self._known
            if one not in named and wanted.casefold() in f"{one.value} {one.about}".casefold()
        ]
        return named + described

    def _show_message(self, text: str, *, wrong: bool = False) -> None:
        self._message.set_class(wrong, "problem")
        self._shell.display = not wrong
        self._message.update(Text(visible_lines(text)))

    def _command(self, assignments: tuple[str, ...]) -> str:
        out = self._out()
        more = ["--out", str(out)] if out else []
        sets = [word for text in assignments for word in ("--set", text)]
        return command("fork" if self._fork else "resume", self._run, *more, *sets)

    def _out(self) -> Path | None:
        typed = self._folder.value.strip()
        return Path(typed) if typed else None

    # The list of options

    @property
    def _word(self) -> str:
        """The last typed word."""
        return self._input.value.rpartition(" ")[2]

    @on(OptionList.OptionHighlighted)
    def _describe(self) -> None:
        """Show the whole description of the highlighted option while the list has the focus."""
        at = self._options.highlighted_option
        if self.focused is self._options and at is not None:
            one = next(one for one in self._known if one.key == at.id)
            self._show_message(f"{one.key}: {one.about}")

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        self._insert(str(event.option.id))

    def _complete(self) -> bool:
        """Complete a word that is part of a key; return whether there was one."""
        self._list_matches()
        highlighted = self._options.highlighted_option
        if not self._word or "=" in self._word or highlighted is None:
            return False
        self._insert(str(highlighted.id))
        return True

    def _insert(self, key: str) -> None:
        """Replace the key in the typed word and keep the value."""
        before, space, word = self._input.value.rpartition(" ")
        self._input.value = f"{before}{space}{key}={word.partition('=')[2]}"
        self._focus_input()

    def _focus_input(self) -> None:
        self.set_focus(self._input)  # not deferred
        self._input.cursor_position = len(self._input.value)

    async def on_key(self, event: Key) -> None:
        """Return from the list to the text field when letters are typed."""
        if not self._options.has_focus:
            return
        if event.key == "up" and not self._options.highlighted:
            self._focus_input()
        elif event.key == "backspace" or (event.key == "enter" and self._input.reading):
            self._focus_input()
            await self._input.on_key(event)
        elif event.key == "enter" and (highlighted := self._options.highlighted_option):
            self._insert(str(highlighted.id))
        elif event.is_printable and event.character:
            self._focus_input()
            await self._input.on_key(event)
        else:
            return
        event.stop()
        event.prevent_default()

    def action_options(self) -> None:
        """Focus the list."""
        self.set_focus(self._options)
        self._describe()

    def action_complete(self) -> None:
        """Complete the typed word, or move to the next field."""
        if not self._complete():
            self.focus_next()

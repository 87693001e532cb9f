"""Asks which options a run is to go on under, checked as they are typed."""

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from pydantic import BaseModel
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.timer import Timer
from textual.widgets import Input, Label, OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides, parse_assignments
from gaitsim.registry import KINDS, options
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.files.folder import command
from gaitsim.runs.resume import plan
from gaitsim.runs.snapshot import RunSnapshot

CALM = 0.15  # seconds without a key before what is typed is checked


@dataclass(frozen=True)
class ChangeRequest:
    """What was asked for.

    Attributes:
        overrides: values of options by key.
        out: of a copy, the folder to make; None numbers the run's own name.
    """

    overrides: Overrides
    out: Path | None = None


@dataclass(frozen=True)
class KnownOption:
    """An option that can be changed: its key, its value now, what it takes and means."""

    key: str
    value: str
    about: str


def known_options(run: RunSnapshot) -> list[KnownOption]:
    """All options of a run's experiment, rates and weights before the choice of plugins.

    Raises:
        GaitsimError: the experiment has problems.
    """
    experiment = run.experiment
    models: dict[str, BaseModel] = {kind: experiment.plugin(kind) for kind in reversed(KINDS)}
    models["evolution"] = experiment.evolution
    if experiment.islands.number > 1:
        models["islands"] = experiment.islands
    found = []
    for section, model in models.items():
        given = options.values(model)
        for name, declared in type(model).model_fields.items():
            if f"{section}.{name}" in ("evolution.population", "islands.number"):
                continue  # of a run that goes on, it stays
            value = options.written(declared, given[name]) if name in given else options.NOT_SET
            about = f"{options.allowed(declared)}. {options.meaning(declared)}"
            found.append(KnownOption(f"{section}.{name}", value, about))
    chosen = [
        KnownOption(f"{kind}.{PLUGIN}", experiment.entries[kind].name, f"another {kind}")
        for kind in KINDS
    ]
    return [*found, *chosen]


def words_of(text: str) -> tuple[str, ...]:
    """What was typed, as a shell splits it.

    Raises:
        GaitsimError: a quotation is not closed.
    """
    try:
        return tuple(shlex.split(text))
    except ValueError:
        raise GaitsimError("a quotation mark is not closed") from None


class Change(ModalScreen[ChangeRequest | None]):
    """Asks for changes of the experiment; dismissed with what is wanted.

    Args:
        run: its folder.
        fork: whether they are those of a copy, whose folder is asked for as well.
        typed: what stands there at first.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Cancel", id="change.cancel", tooltip="Change nothing"),
        Binding("down", "options", "Options", show=False, id="change.options",
                tooltip="To the list of options"),
    ]  # fmt: skip
    DEFAULT_CSS = """
    Change {
        & .dialog { width: 90; }
        & OptionList {
            height: 9; margin: 1 0; padding: 0; border: none; background: $panel;
            text-wrap: nowrap; text-overflow: ellipsis;
        }
        & Input { margin-bottom: 1; }
        & OptionList { margin-top: 0; }
        & #change-said { height: auto; max-height: 8; }
        & Label { color: $text-muted; }
    }
    """

    def __init__(self, run: Path, *, fork: bool = False, typed: str = "") -> None:
        super().__init__()
        self._run, self._fork = run, fork
        self._known: list[KnownOption] = []
        self._checked: str | None = None  # the text that was found right
        self._submitted = False
        self._timer: Timer | None = None
        # Held, as what threads find may come when the screen is being taken down.
        self._input = Input(typed, placeholder="KEY=VALUE …", compact=True, id="change-text")
        self._folder = Input(placeholder=f"{run}-2", compact=True, id="change-out")
        self._options = OptionList(id="change-options")
        self._said = Static("Reading the experiment …", id="change-said")
        self._shell = Static(id="change-command", classes="command")

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "Fork" if self._fork else "Change"
            box.border_subtitle = "enter takes it, ↓ to the options, esc cancels"
            if self._fork:
                yield Label("folder of the copy")
                yield self._folder
            yield Label("changes from here on, such as mutation.rate=0.1")
            yield self._input
            yield self._options
            yield self._said
            yield self._shell

    def on_mount(self) -> None:
        """Read the options, in a thread: their plugins are imported for it."""
        self._input.focus()
        self._read()

    @work(thread=True, group="read")
    def _read(self) -> None:
        try:
            known = known_options(RunSnapshot(self._run))
        except GaitsimError as error:
            self.app.call_from_thread(self._say, str(error), wrong=True)
            return
        self.app.call_from_thread(self._take, known)

    def _take(self, known: list[KnownOption]) -> None:
        self._known = known
        if self.is_attached:
            self._check_now()

    # What is typed

    @property
    def _text(self) -> str:
        return self._input.value

    @on(Input.Changed)
    def _changed(self) -> None:
        self._checked = None
        if self._timer is not None:
            self._timer.stop()
        self._timer = self.set_timer(CALM, self._check_now)

    def _check_now(self) -> None:
        if not self._known or not self.is_attached:
            return
        self._offer()
        text = self._text
        try:
            assignments = words_of(text)
        except GaitsimError as error:
            self._found(text, error, "")
            return
        self._shell.update(Text(f"$ {self._command(assignments)}"))
        if assignments and "=" not in assignments[-1] and not self._submitted:
            self._say("Type on, or choose an option: ↓", wrong=False)
            return
        self._check(text, assignments)

    def _offer(self) -> None:
        """List the options that have what the last word begins with."""
        typing = "" if self._text.endswith(" ") else (self._text.split(" ") or [""])[-1]
        wanted = typing.partition("=")[0]
        fitting = [one for one in self._known if wanted in one.key]
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
            for one in fitting
        )

    @work(thread=True, group="check", exclusive=True)
    def _check(self, text: str, assignments: tuple[str, ...]) -> None:
        """See what the changes come to, in a thread. Writes nothing."""
        run = RunSnapshot(self._run)
        try:
            overrides = parse_assignments(assignments)
            opening = plan(run, overrides, generations=None, any_version=True)
        except GaitsimError as error:
            self.app.call_from_thread(self._found, text, error, "")
            return
        first = run.generation + 1
        said = "".join(f"▶ {change}\n" for change in opening.changes)
        if said:
            said += f"from generation {first} on"
            if opening.reevaluates:
                said += "; its scores begin anew"
        elif assignments:
            said = "No new stage: evolution goes on in the same way."
        self.app.call_from_thread(self._found, text, None, said)

    def _found(self, text: str, error: GaitsimError | None, said: str) -> None:
        if not self.is_attached or text != self._text:
            return
        self._say(str(error) if error else said, wrong=error is not None)
        self._checked = None if error else text
        if self._submitted and error is None:
            self._done()
        self._submitted = False

    def _say(self, text: str, *, wrong: bool) -> None:
        self._said.set_class(wrong, "problem")
        self._said.update(Text(visible_lines(text)))

    def _command(self, assignments: tuple[str, ...]) -> str:
        out = self._out()
        more = ["--out", str(out)] if out else []
        sets = [word for text in assignments for word in ("--set", text)]
        return command("fork" if self._fork else "resume", self._run, *more, *sets)

    def _out(self) -> Path | None:
        typed = self._folder.value.strip()
        return Path(typed) if typed else None

    # What is done

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        """Put an option where it is typed, its value to be changed."""
        before = self._input.value.rpartition(" ")[0]
        self._input.value = f"{before} {event.option.id}=".lstrip()
        self._input.focus()
        self._input.cursor_position = len(self._input.value)

    def action_options(self) -> None:
        self._options.focus()

    @on(Input.Submitted)
    def _entered(self) -> None:
        """Take it once it is found right."""
        if self._checked == self._text:
            self._done()
        else:
            self._submitted = True
            self._check_now()

    def _done(self) -> None:
        overrides = parse_assignments(words_of(self._text))
        if overrides or self._fork:
            self.dismiss(ChangeRequest(overrides, self._out()))
        else:
            self.dismiss(None)

"""Ask for the options under which a run continues, and check them while they are typed."""

import asyncio
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
from textual.widgets import Input, Label, OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Overrides, parse_assignments
from gaitsim.registry import KINDS, options
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.runs.files.folder import command
from gaitsim.runs.resume import plan_resume
from gaitsim.runs.snapshot import RunSnapshot

CALM = 0.15  # seconds without a key before what is typed is checked


@dataclass(frozen=True)
class ChangeRequest:
    """The answer of the dialog.

    Attributes:
        overrides: changed options by key.
        out: the folder of a copy; None numbers the name of the run.
    """

    overrides: Overrides
    out: Path | None = None


@dataclass(frozen=True)
class KnownOption:
    """An option that can be changed: its key, current value, and allowed values and meaning."""

    key: str
    value: str
    about: str


def known_options(run: RunSnapshot) -> list[KnownOption]:
    """Return all options of a run's experiment, rates and weights before the choice of plugins.

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
                continue  # fixed once a run has begun
            value = options.written(declared, given[name]) if name in given else options.NOT_SET
            about = f"{options.allowed(declared)}. {options.meaning(declared)}"
            found.append(KnownOption(f"{section}.{name}", value, about))
    chosen = [
        KnownOption(f"{kind}.{PLUGIN}", experiment.entries[kind].name, f"another {kind}")
        for kind in KINDS
    ]
    return [*found, *chosen]


def words_of(text: str) -> tuple[str, ...]:
    """Split a text as a shell does.

    Raises:
        GaitsimError: a quotation is not closed.
    """
    try:
        return tuple(shlex.split(text))
    except ValueError:
        raise GaitsimError("a quotation mark is not closed") from None


def effect_of(run: RunSnapshot, overrides: Overrides) -> str:
    """Describe the effect of changes, without making them.

    Raises:
        GaitsimError: they are invalid, or the run cannot be continued.
    """
    plans = plan_resume(run, overrides, generations=None, any_version=True)
    if not plans.changes:
        return "No new stage: evolution continues unchanged." if overrides else ""
    changes = "".join(f"▶ {change}\n" for change in plans.changes)
    anew = "; its scores begin anew" if plans.reevaluates else ""
    return f"{changes}from generation {run.generation + 1} on{anew}"


class ChangeDialog(ModalScreen[ChangeRequest | None]):
    """Ask for changes of the experiment; return the request.

    Args:
        run: its folder.
        fork: whether to ask for a copy and its folder.
        typed: the text to begin with.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Cancel", id="change.cancel", tooltip="Change nothing"),
        Binding("down", "options", "Options", show=False, id="change.options",
                tooltip="To the list of options"),
    ]  # fmt: skip
    DEFAULT_CSS = """
    ChangeDialog {
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
        self._input.focus()
        self._check()

    @on(Input.Changed)
    def _changed(self) -> None:
        self._check(CALM)

    @on(Input.Submitted)
    def _entered(self) -> None:
        self._check(submit=True)

    @work(exclusive=True)
    async def _check(self, delay: float = 0.0, *, submit: bool = False) -> None:
        """Show the effect of the changes, unless others are typed meanwhile.

        Args:
            delay: seconds to wait for that.
            submit: whether to take the changes if they are valid.
        """
        await asyncio.sleep(delay)
        try:
            if not self._known:  # in a thread: plugins are imported for it
                self._known = await asyncio.to_thread(known_options, RunSnapshot(self._run))
            self._offer()
            words = words_of(self._input.value)
            self._shell.update(Text(f"$ {self._command(words)}"))
            if words and "=" not in words[-1] and not submit:
                self._say("Type on, or choose an option: ↓")
                return
            overrides = parse_assignments(words)
            self._say(await asyncio.to_thread(effect_of, RunSnapshot(self._run), overrides))
        except GaitsimError as error:
            self._say(str(error), wrong=True)
            return
        if submit:
            wanted = ChangeRequest(overrides, self._out())
            self.dismiss(wanted if overrides or self._fork else None)

    def _offer(self) -> None:
        """List the options whose keys contain the beginning of the last word."""
        wanted = self._input.value.split(" ")[-1].partition("=")[0]
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
            for one in self._known
            if wanted in one.key
        )

    def _say(self, text: str, *, wrong: bool = False) -> None:
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

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        """Insert the chosen option, ready for its value."""
        before = self._input.value.rpartition(" ")[0]
        self._input.value = f"{before} {event.option.id}=".lstrip()
        self._input.focus()
        self._input.cursor_position = len(self._input.value)

    def action_options(self) -> None:
        self._options.focus()

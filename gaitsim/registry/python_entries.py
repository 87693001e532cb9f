"""Fitness functions and bodies passed in Python, registered by name in this process.

The name, such as `python:forward@1a2b3c4d`, ends with a checksum of the code, so that a changed
function gets another name. An experiment with a function that is not registered can be read, but
its individuals can neither move nor be scored.
"""

from dataclasses import dataclass, field
from keyword import iskeyword
from typing import TYPE_CHECKING

from gaitsim.errors import MissingFunctionError
from gaitsim.registry.entry_points import PYTHON, Entry

if TYPE_CHECKING:
    from gaitsim.contracts import Plugin

ARGUMENTS = {"fitness": "fitness", "organism": "body"}
"""The argument of `gs.evolve` for a plugin of a kind."""
SCORE = f"{PYTHON}score"
"""The name of the fitness for a body that computes its own score; always available."""


def is_outside(name: str) -> bool:
    """Return whether a plugin's name refers to a user's code outside any package."""
    return name.startswith(PYTHON) and name != SCORE


@dataclass(frozen=True)
class PythonEntry(Entry):
    """A function or class that a user passed in Python.

    Attributes:
        model: plugin class of the function or class; None if it is not registered in this process.
        file: path of the file that contains the code; '' if unknown.
    """

    model: "type[Plugin] | None" = field(default=None, repr=False, compare=False)
    file: str = field(default="", repr=False, compare=False)

    @property
    def label(self) -> str:
        """The name of the function or class."""
        return self.name.removeprefix(PYTHON).partition("@")[0]

    @property
    def argument(self) -> str:
        """The argument that passes it to `gs.evolve`, such as `fitness=forward`.

        A name from a file can be any text, even code that a reader would paste and run. The
        argument therefore contains only an identifier.
        """
        usable = self.label.isidentifier() and not iskeyword(self.label)
        value = self.label if usable else "…"
        return f"{ARGUMENTS.get(self.kind, self.kind)}={value}"

    @property
    def remedy(self) -> str:
        """The remedy for a violation of its contract."""
        return f"correct {self.label}"

    def __str__(self) -> str:
        return f"Python {ARGUMENTS.get(self.kind, self.kind)} {self.label!r}"

    def place_of(self, error: BaseException) -> str:
        """Return the file and the innermost line of its code in the traceback of an error."""
        place, at = self.target, error.__traceback__
        while at is not None:
            if at.tb_frame.f_code.co_filename == self.file:
                place = f"{self.file}, line {at.tb_lineno}"
            at = at.tb_next
        return place

    @property
    def notice(self) -> str:
        """A warning for readers of the experiment, one sentence."""
        return f"The {self} is code outside the run: the run's files alone cannot reproduce it"

    def load(self) -> "type[Plugin]":
        """Return the plugin class, or a placeholder if it is not registered."""
        from gaitsim.registry.python_plugins import placeholder  # imports NumPy

        return self.model or placeholder(self)

    @property
    def missing_error(self) -> MissingFunctionError:
        """The error to raise if it is used without being registered in this process."""
        space = ", space=…" if self.kind == "organism" else ""
        note = " (space only if the body is a function)" if space else ""
        return MissingFunctionError(
            f"the {self} is not stored in the experiment's file and must be passed again",
            where=f"{self.kind}.plugin = {self.name!a}",
            remedy=f"in Python, gs.load(RUN, {self.argument}{space}) or "
            f"gs.evolve(…, {self.argument}{space}){note}",
        )


_registered: dict[tuple[str, str], PythonEntry] = {}


def register(entry: PythonEntry) -> None:
    """Register an entry in this process; it replaces an earlier entry of the same name."""
    _registered[entry.kind, entry.name] = entry


def find_registered(kind: str, name: str) -> PythonEntry:
    """Return the entry of a `python:` name; its model is None if the name is not registered."""
    if (kind, name) == ("fitness", SCORE):
        from gaitsim.registry.python_plugins import ScoreChannel

        return PythonEntry(kind, name, "gaitsim", "gaitsim", "", ScoreChannel)
    return _registered.get((kind, name)) or PythonEntry(kind, name, "Python", OUTSIDE, "")


OUTSIDE = "Python code outside the run"
"""The text shown instead of a package for plugins passed in Python."""

"""Fitness functions and bodies given in Python: known to this process alone, under a name.

The name, such as `python:forward@1a2b3c4d`, ends with a checksum of the code, so that a changed
function is another one. An experiment that names a function which this process was not given can
be read, but neither moved nor scored.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gaitsim.errors import MissingFunctionError
from gaitsim.registry.entry_points import PYTHON, Entry

if TYPE_CHECKING:
    from gaitsim.contracts import Plugin

ARGUMENTS = {"fitness": "fitness", "organism": "body"}
"""The argument of `gs.evolve` that gives a plugin in Python, by the plugin's kind."""
SCORE = f"{PYTHON}score"
"""The fitness of a body that computes its own score; always known."""


def is_outside(name: str) -> bool:
    """Return whether a plugin's name is that of code of a user's, which no package has."""
    return name.startswith(PYTHON) and name != SCORE


@dataclass(frozen=True)
class PythonEntry(Entry):
    """A function or class that was given in Python.

    Attributes:
        model: its plugin class; None if this process was not given it.
        file: the file that contains its code; '' if unknown.
    """

    model: "type[Plugin] | None" = field(default=None, repr=False, compare=False)
    file: str = field(default="", repr=False, compare=False)

    @property
    def label(self) -> str:
        """The name of the function or class."""
        return self.name.removeprefix(PYTHON).partition("@")[0]

    @property
    def argument(self) -> str:
        """The argument that gives it, such as `fitness=forward`."""
        return f"{ARGUMENTS.get(self.kind, self.kind)}={self.label}"

    @property
    def remedy(self) -> str:
        """What to do where it breaks its contract."""
        return f"correct {self.label}"

    def __str__(self) -> str:
        return f"Python {ARGUMENTS.get(self.kind, self.kind)} {self.label!r}"

    def place_of(self, error: BaseException) -> str:
        """Return the file and line of its code in which an error was raised, or passed."""
        place, at = self.target, error.__traceback__
        while at is not None:
            if at.tb_frame.f_code.co_filename == self.file:
                place = f"{self.file}, line {at.tb_lineno}"
            at = at.tb_next
        return place

    @property
    def notice(self) -> str:
        """What a reader of the experiment has to know, one sentence."""
        return f"The {self} is code outside the run: this cannot be reproduced from its files alone"

    def load(self) -> "type[Plugin]":
        """Return its class, or one that stands in where this process was not given it."""
        from gaitsim.registry.python_plugins import stand_in  # it needs NumPy

        return self.model or stand_in(self)

    @property
    def missing(self) -> MissingFunctionError:
        """The error of using it where this process was not given it."""
        return MissingFunctionError(
            f"the {self} is not part of the experiment's file: it has to be given again",
            where=f"{self.kind}.plugin = {self.name!a}",
            remedy=f"in Python, gs.load(RUN, {self.argument}) or gs.evolve(…, {self.argument})",
        )


_given: dict[tuple[str, str], PythonEntry] = {}


def give(entry: PythonEntry) -> None:
    """Make an entry known to this process; of entries of one name, the last one counts."""
    _given[entry.kind, entry.name] = entry


def find_given(kind: str, name: str) -> PythonEntry:
    """Return the entry of a name that begins with `python:`; its model may be missing."""
    if (kind, name) == ("fitness", SCORE):
        from gaitsim.registry.python_plugins import ScoreChannel

        return PythonEntry(kind, name, "gaitsim", "gaitsim", "", ScoreChannel)
    return _given.get((kind, name)) or PythonEntry(kind, name, "Python", OUTSIDE, "")


OUTSIDE = "Python code outside the run"
"""What stands for the package of a function."""

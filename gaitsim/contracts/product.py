"""Files made from runs: the contracts of plots and exporters."""

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator

from gaitsim.choices import Theme
from gaitsim.contracts.plugin import Plugin, option
from gaitsim.errors import GaitsimError

# Contracts import nothing that stands on them.
Individual = Any  # gaitsim.Individual
RunSnapshot = Any  # gaitsim.storage.snapshot.RunSnapshot
Figure = Any  # matplotlib.figure.Figure

Input = Literal["run", "individual", "individuals"]
RESERVED = (
    *("run", "kind", "format", "out", "options", "help"),
    *(
        "generation",
        "member",
        "damage",
        "world",
        "engine",
        "gait",
        "gait_unit",
        "gait_repeat",
        "generations",
    ),
)
"""Options of the commands themselves, whose names no product may use."""


def _split(value: Any) -> Any:
    """Return the names in a comma-separated string, or in a list of names and paths."""
    if isinstance(value, str | int | float):
        return tuple(name for part in str(value).split(",") if (name := part.strip()))
    if isinstance(value, list | tuple):
        return tuple(str(one) if isinstance(one, Path) else one for one in value)
    return value


def _parse_window(value: Any) -> Any:
    """Return the start and end in seconds of a string such as '2:5'."""
    if not isinstance(value, str):
        return value
    try:
        first, last = (float(part) for part in value.split(":"))
        if not 0 <= first < last < math.inf:
            raise ValueError
    except ValueError:
        raise GaitsimError(
            f"invalid time window: {value!r}",
            where="--window",
            allowed="START:END in seconds, such as 2:5",
        ) from None
    return first, last


def _check_two(names: tuple[str, ...]) -> tuple[str, ...]:
    if names and len(names) != 2:
        raise ValueError("two names are needed")
    return names


Names = Annotated[tuple[str, ...], BeforeValidator(_split)]
"""Several names; on the command line, one for each use of the flag; elsewhere, with commas."""
TWO = "two"
Pair = Annotated[Names, AfterValidator(_check_two), TWO]
"""Two names; on the command line, two values of a flag."""
Window = Annotated[tuple[float, float], BeforeValidator(_parse_window)]
"""Part of a motion: its start and end in seconds, which a user types as '2:5'."""


@dataclass(frozen=True, eq=False)
class Subject:
    """The input of a plot or an export.

    Attributes:
        run: run on disk; None for an individual without a run.
        individuals: individuals to show; () for products of a whole run.
        begin: function called with the total number of items, such as gaits or generations.
        advance: function called with the number of items finished since the last call.
    """

    run: RunSnapshot | None
    individuals: tuple[Individual, ...] = ()
    begin: Callable[[int], object] = lambda total: None
    advance: Callable[[int], object] = lambda done: None

    @property
    def individual(self) -> Individual:
        """The individual, for products that show only one."""
        return self.individuals[0]

    @property
    def whole_run(self) -> RunSnapshot:
        """The run, for products that show a whole run."""
        assert self.run is not None, "the input of this product is a run"
        return self.run


class Product(Plugin):
    """A file that is made from a run or from individuals; its fields are the options.

    Commands, forms and documentation are generated from the declaration. Import modules that take
    long, such as Matplotlib, in the methods rather than at the top, so that `--help` stays quick.

    Attributes:
        title: name in menus, such as 'Footfalls'.
        group: heading in menus and help texts, such as 'Joint angles'.
        note: addition to the name in help texts, such as 'MATLAB, Octave'.
        input: 'run' for a whole run, or one individual or several individuals.
        items: plural noun for the items in the progress bar; '' if the product is quick.
    """

    title: ClassVar[str]
    group: ClassVar[str]
    note: ClassVar[str] = ""
    input: ClassVar[Input] = "individual"
    items: ClassVar[str] = ""

    def check(self, individual: Individual) -> None:
        """Check that the individual's run, body and motion have the data.

        Raises:
            GaitsimError: data are missing, or a package that is needed is not installed.
        """

    def words(self, subject: Subject) -> tuple[str, ...]:
        """Return the words in the default file name that distinguish it from similar files."""
        return ()


class Plot(Product):
    """A kind of `gaitsim plot`.

    Raise a `NothingToPlotError` if the data are missing; `gaitsim plot --kind all` skips the kind.
    """

    theme: Theme = option("light", "colour theme")

    def check_among_all(self, subject: Subject) -> None:
        """Raise a `NothingToPlotError` if `gaitsim plot --kind all` should omit the plot."""

    @abstractmethod
    def draw(self, subject: Subject) -> Figure:
        """Return the figure, at the width of a journal column.

        Raises:
            NothingToPlotError: the run, the body or the motion lacks the data.
            GaitsimError: an option does not fit the data.
        """


@dataclass(frozen=True)
class Exported:
    """The result of an export.

    Attributes:
        summary: description of the exported content, one line.
        notices: notices for the user.
    """

    summary: str
    notices: tuple[str, ...] = ()


class Exporter(Product):
    """A format of `gaitsim export`.

    Attributes:
        suffix: suffix of a default file name, with its dot; '' for a folder.
        other_suffixes: suffixes of other files that the format can write.
        stem: first word of a default file name.
    """

    suffix: ClassVar[str]
    other_suffixes: ClassVar[tuple[str, ...]] = ()
    stem: ClassVar[str] = "gait"

    @property
    def other_file(self) -> Path | None:
        """The file that is written instead of the export, with some options; None for none."""
        return None

    def file_name(self, subject: Subject) -> str:
        """Return the default name of the file or folder."""
        shown = subject.individuals
        parts = [self.stem, *self.words(subject)]
        if len(shown) == 1:
            parts.append(shown[0].stem)
        elif shown:
            parts.append(f"generations-{shown[0].generation}-to-{shown[-1].generation}")
        return f"{'-'.join(parts)}{self.suffix}"

    @abstractmethod
    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file or folder atomically, and describe its content.

        Raises:
            GaitsimError: the data are missing, or an option does not fit them.
            RunError: the file cannot be written.
        """

    def embedded(self, subject: Subject) -> bytes:
        """Return the page, HTML in UTF-8, for a frame in a notebook, as `gs.view` shows it.

        Raises:
            GaitsimError: the format is not a page, or the individuals cannot be shown.
        """
        raise GaitsimError(
            f"the format {self.suffix!r} cannot be shown in a notebook", allowed="the format 'html'"
        )

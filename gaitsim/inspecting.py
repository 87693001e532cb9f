"""Analyses, tests, plots, exports and tables of runs and individuals, and individuals with them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from numpy.typing import NDArray

from gaitsim.arguments import check_workers
from gaitsim.contracts import Exported, Exporter, Plot, Subject
from gaitsim.contracts.product import Product
from gaitsim.errors import GaitsimError, not_installed
from gaitsim.evaluation.worlds import Ranges
from gaitsim.gait.channels import motion_columns
from gaitsim.gait.report import GaitAnalysis, analyse_individual
from gaitsim.gait.worlds import (
    CheckResults,
    FeedbackResults,
    UnseenResults,
    check_gait,
    compare_blind,
    evaluate_unseen,
)
from gaitsim.individual import Individual, Which
from gaitsim.registry.loading import call_product, load_product, products
from gaitsim.render.notebook import enable_notebook_display
from gaitsim.sharing.challenge import code_of
from gaitsim.storage.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DataFrame: TypeAlias = Any  # pandas.DataFrame; pandas is an extra
DEFAULT = "mat"  # format


def data_frame(columns: Mapping[str, NDArray[Any]]) -> DataFrame:
    """Return columns as a DataFrame of pandas.

    Raises:
        GaitsimError: pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise not_installed("to_pandas()", "pandas", "pandas") from None
    return pandas.DataFrame(dict(columns))


def plot(
    kind: str,
    shown: RunSnapshot | Individual,
    which: Sequence[Which] | Which,
    options: Mapping[str, Any],
    *,
    dark: bool,
) -> "Figure":
    """Return a plot of a run, of individuals of a run, or of one individual."""
    from matplotlib.figure import Figure

    from gaitsim.render.plots.style import THEMES

    product = load_product("plot", kind, {**options, **({"theme": "dark"} if dark else {})})
    assert isinstance(product, Plot)
    subject = _subject(product, f"the plot {kind!r}", shown, which)
    figure = call_product("plot", kind, "drawing", Figure, product.draw, subject)
    return enable_notebook_display(figure, THEMES[product.theme])


def export(
    shown: RunSnapshot | Individual,
    path: Path,
    format: str | None,
    which: Sequence[Which] | Which,
    options: Mapping[str, Any],
) -> Exported:
    """Write a run, individuals of a run, or one individual to a file or folder."""
    name = format or format_of(path, f"pass a format: {', '.join(products('exporter'))}")
    product = load_product("exporter", name, options)
    assert isinstance(product, Exporter)
    subject = _subject(product, f"the format {name!r}", shown, which)
    return write(name, product, subject, product.other_file or path)


def write(name: str, exporter: Exporter, subject: Subject, path: Path) -> Exported:
    """Write a file or folder with a loaded exporter, whose errors name its package."""
    return call_product("exporter", name, "exporting", Exported, exporter.write, subject, path)


def formats() -> dict[str, str]:
    """Return the format that each extension of a file chooses."""
    every: Mapping[str, Any] = products("exporter")
    others = {suffix: name for name, one in every.items() for suffix in one.other_suffixes}
    own = {one.suffix: name for name, one in every.items() if one.suffix == f".{name}"}
    return others | own


def format_of(path: Path, remedy: str, where: str = "") -> str:
    """Return the format that the extension of a file chooses.

    Raises:
        GaitsimError: the extension is unknown.
    """
    known = formats()
    if (suffix := path.suffix.lower()) not in known:
        raise GaitsimError(
            f"unknown extension for gaits: {path}",
            where=where,
            allowed=", ".join(known),
            remedy=f"change the extension, or {remedy}",
        )
    return known[suffix]


def _subject(
    product: Product, name: str, shown: RunSnapshot | Individual, which: Sequence[Which] | Which
) -> Subject:
    """Return the input of a plot or an exporter."""
    if isinstance(shown, Individual):
        if product.input == "run":
            raise GaitsimError(
                f"{name} needs a whole run, not one individual",
                remedy="use the run itself, from gaitsim.load()",
            )
        return Subject(None, (shown,))
    individuals = () if product.input == "run" else shown.individuals(which)
    if product.input == "individual" and len(individuals) > 1:
        raise GaitsimError(f"{name} takes one individual", allowed="one generation or member")
    return Subject(shown, individuals)


@dataclass(frozen=True, eq=False, repr=False)
class InspectedIndividual(Individual):
    """An individual with methods for analyses, plots, files and tables: `gs.Individual`."""

    @classmethod
    def of(cls, individual: Individual) -> Self:
        """Return an individual with these methods; both keep what either has computed."""
        found = cls.__new__(cls)
        object.__setattr__(found, "__dict__", individual.__dict__)
        return found

    @property
    def gait(self) -> str:
        """The name of the gait, such as 'tetrapod'; see `analyse` for its measures.

        Raises:
            PluginError: the body cannot be moved or drawn.
        """
        return self.analyse().name.name

    def analyse(self) -> GaitAnalysis:
        """Return the analysis of the gait: its name, footfalls and measures.

        Raises:
            PluginError: the body cannot be moved or drawn.
        """
        return analyse_individual(self)

    def in_worlds(
        self,
        number: int = 100,
        *,
        seed: int = 0,
        ranges: Ranges | None = None,
        workers: int | None = None,
    ) -> UnseenResults:
        """Evaluate the individual in unseen worlds.

        Args:
            number: number of worlds.
            seed: seed of the worlds.
            ranges: lowest and highest value of each varying condition, by name; None for the
                ranges of the experiment's worlds or, if it has none, the body's usual ranges.
            workers: number of parallel workers; None chooses the body's default.

        Raises:
            GaitsimError: the body lacks these conditions or has none, or an argument is invalid.
        """
        check_workers(workers)
        return evaluate_unseen(self, number, seed=seed, ranges=ranges, workers=workers)

    def checks(self, workers: int | None = None) -> CheckResults | None:
        """Check whether the gait holds in the body's checks; None for a body without checks.

        Args:
            workers: number of parallel workers; None chooses the body's default.
        """
        check_workers(workers)
        return check_gait(self, workers=workers)

    def feedback(self, workers: int | None = None) -> FeedbackResults | None:
        """Compare the gait with and without its reflexes; None for a body without reflexes.

        The servo horns have errors of 2°, drawn 10 times.

        Args:
            workers: number of parallel workers; None chooses the body's default.
        """
        check_workers(workers)
        return compare_blind(self, workers=workers)

    def plot(self, kind: str = "path", *, dark: bool = False, **options: Any) -> "Figure":
        """Return a plot of the motion, as `Run.plot` does.

        Args:
            kind: a kind of plot for an individual, such as 'footfall' or 'joints'.
            dark: whether the background is dark.
            **options: options of the kind, such as `channel` or `window`.

        Raises:
            GaitsimError: the kind or an option is unknown, or the body lacks the data.
        """
        return plot(kind, self, (), options, dark=dark)

    def export(self, path: str | Path, format: str | None = None, **options: Any) -> Exported:
        """Write the individual to a file; see `gaitsim.export`."""
        return export(self, Path(path), format, (), options)

    def share(self) -> str:
        """Return the challenge code of the individual, which `gaitsim.verify` verifies.

        Raises:
            GaitsimError: it has no genome or score, or the code would be too large.
        """
        return code_of(self)

    def to_pandas(self) -> DataFrame:
        """Return all channels of the motion as a DataFrame, with a row for each frame.

        The columns are `generation`, `score`, `frame` and `time (s)`, for some bodies `trial`, and
        one for each entry of a channel with its unit, such as `feet L1 x (m)`.

        Raises:
            GaitsimError: pandas is not installed.
            PluginError: the body cannot be moved.
        """
        return data_frame(motion_columns(self))


InspectedIndividual.__name__ = "Individual"  # as users know it, in representations

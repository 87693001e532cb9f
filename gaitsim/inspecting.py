"""Analyses, tests, plots, exports and tables behind the methods of runs and individuals.

`gaitsim.individual` imports this module in its methods, against the order of the layers, so that
`run.champion.plot()` and `gs.analyse(run)` call the same functions.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from numpy.typing import NDArray

from gaitsim.contracts import Exported, Exporter, Plot, Subject
from gaitsim.contracts.product import Product
from gaitsim.errors import GaitsimError, not_installed
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

__all__ = [
    "CheckResults",
    "Exported",
    "FeedbackResults",
    "GaitAnalysis",
    "UnseenResults",
    "analyse_individual",
    "check_gait",
    "code_of",
    "compare_blind",
    "evaluate_unseen",
]

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


def motion_frame(individual: Individual) -> DataFrame:
    """Return all channels of a motion as a DataFrame; see `Individual.to_pandas`."""
    return data_frame(motion_columns(individual))


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

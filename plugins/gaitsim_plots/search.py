"""Plot the figures of a search, such as coverage, against the evaluations."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Search
from gaitsim.errors import NothingToPlotError
from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.render.plots.components import finite_or_nan
from gaitsim.render.plots.fitness import draw_curve, stages
from gaitsim.render.plots.labels import add_heading, heading_of_run, shorten
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim.runs.files.folder import unfinished_error
from gaitsim.runs.files.history import FIGURE, figures_of
from gaitsim.runs.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOGARITHMIC = 100  # ratio of largest to smallest value above which an axis is logarithmic


def require_figures(individual: Individual) -> None:
    """Check that the search of an individual's run records figures."""
    if type(individual.experiment.search).figures is Search.figures:
        raise _no_figures(individual.experiment)


def _no_figures(experiment: Experiment) -> NothingToPlotError:
    return NothingToPlotError(
        f"the search {experiment.entries['search'].name!r} records no quantities of its own, such "
        "as coverage",
        allowed="a search that records some, such as 'cma-es', 'nsga-2' or 'map-elites'",
    )


def search_figure(run: RunSnapshot, theme: Theme) -> "Figure":
    """Plot each figure of the search, such as coverage, in a panel against the evaluations."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    history = run.history
    if not history:
        raise unfinished_error(run.path)
    names = figures_of(history)
    if not names:
        raise _no_figures(run.experiment)
    over = {**history, "generation": history["evaluations"]}
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 0.75 + 1.05 * len(names)))
        panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
        for index, (axes, name) in enumerate(zip(panels, names, strict=True)):
            values = history[FIGURE + name]
            draw_curve(axes, over, values, None, color=theme.colours[index % len(theme.colours)])
            axes.set_ylabel(shorten(name, 24))
            if _logarithmic(values):
                axes.set_yscale("log")
            for before, part in pairwise(stages(history)):
                start = history["evaluations"][[before.stop - 1, part.start]].mean()
                axes.axvline(start, color=theme.ink, linewidth=0.6, linestyle=":")
        panels[-1].set_xlabel("evaluations")
        panels[-1].set_xlim(0, history["evaluations"][-1])
        panels[-1].xaxis.set_major_locator(MaxNLocator(4, integer=True, min_n_ticks=2))
        panels[-1].xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
        figure.align_ylabels()
        plugin = run.experiment.entries["search"].name
        add_heading(figure, heading_of_run(run.path.resolve().name, run.experiment, f", {plugin}"))
    return figure


def _logarithmic(values: NDArray[np.float64]) -> bool:
    known = finite_or_nan(values)
    known = known[~np.isnan(known)]
    return bool(len(known)) and bool(known.min() > 0) and known.max() > _LOGARITHMIC * known.min()

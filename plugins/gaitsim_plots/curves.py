"""Plot terms, diversity and the figures of the search over the generations."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import BitSpace, NothingToPlotError, RunError, Search
from gaitsim.plugin.pictures import (
    STEPS,
    WIDTH,
    Theme,
    add_heading,
    draw_curve,
    finite_or_nan,
    grid,
    heading_of_run,
    mark_stages,
    set_generations,
    shorten,
    stages,
    styled,
)
from gaitsim.plugin.runs import (
    COLUMNS,
    FIGURE,
    MEAN,
    Experiment,
    Individual,
    RunSnapshot,
    figures_of,
    unfinished_error,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MAX_PANELS = 40  # maximum number of panels, each of which takes 0.1 s


def terms_figure(
    run: RunSnapshot, theme: Theme, scale: Literal["own", "common", "share"] = "own"
) -> "Figure":
    """Plot a panel for each term, with the best individual's term and the population's mean.

    Args:
        run: run with at least one generation.
        theme: colours of the plot.
        scale: 'own' for a scale of each panel, 'common' for the same scale in all panels, or
            'share' for terms divided by the sum of the absolute terms, on the same scale.
    """
    from matplotlib.ticker import PercentFormatter

    history = run.history
    if not history:
        raise unfinished_error(run.path)
    names = [name for name in history if name not in COLUMNS and MEAN + name in history]
    if len(names) > MAX_PANELS:
        raise RunError(
            f"the history has {len(names)} terms, too many for one figure",
            where=str(run.path),
            allowed=f"at most {MAX_PANELS}",
            remedy="plot them from history.csv",
        )
    means, bests = ([history[of + name] for name in names] for of in (MEAN, ""))
    if scale == "share":
        means, bests = _shares(means), _shares(bests)
    with styled(theme):
        figure, panels = grid(
            len(names),
            WIDTH,
            columns=2 if len(names) > 1 else 1,
            height=1.0,
            share_y=scale != "own",
        )
        for axes, name, mean, best in zip(panels, names, means, bests, strict=True):
            for values, label, colour, style in (
                (mean, "mean of the population", theme.ink, "--"),
                (best, "best individual", theme.colours[0], "-"),
            ):
                draw_curve(axes, history, values, label, color=colour, linestyle=style)
            low, high = axes.get_ylim()
            if low <= 0 <= high:
                axes.axhline(0, color=theme.ink, linewidth=0.4, zorder=1)
            axes.set_title(shorten(name, 28), fontsize=7, pad=2)
            axes.margins(x=0)
            mark_stages(axes, history, theme, named=False)
            set_generations(axes, history, ticks=3 if len(names) > 1 else 6)
        figure.supxlabel("generation", fontsize=8)
        unit = run.experiment.fitness.unit
        label = f"term of the score{f' ({unit})' if unit else ''}"
        if scale == "share":
            label = "share of all gains and losses"
            panels[0].yaxis.set_major_formatter(PercentFormatter(1.0))
        figure.supylabel(label, fontsize=8)
        add_heading(
            figure,
            heading_of_run(
                run.path.resolve().name,
                run.experiment,
                ", scales differ" if scale == "own" and len(names) > 1 else "",
            ),
            *panels[0].get_legend_handles_labels(),
        )
    return figure


def _shares(terms: Sequence[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
    """Divide terms by the sum of their absolute values in each generation."""
    total = np.nansum(np.abs(terms), axis=0)
    return [np.divide(term, total, out=np.zeros_like(term), where=total > 0) for term in terms]


def diversity_figure(run: RunSnapshot, theme: Theme) -> "Figure":
    """Plot the diversity of the genomes and, below it, the standard deviation of the scores."""
    from matplotlib.figure import Figure

    history = run.history
    if not history:
        raise unfinished_error(run.path)
    bits = isinstance(run.experiment.space(), BitSpace)
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 2.9))
        genes, scores = figure.subplots(2, 1, sharex=True)
        draw_curve(genes, history, history["diversity"], None, color=theme.colours[0])
        genes.set_ylabel("s.d. of the bits" if bits else "s.d. of the genes\n(share of range)")
        draw_curve(scores, history, history["std"], None, color=theme.colours[1])
        unit = run.experiment.fitness.unit
        scores.set_ylabel("s.d. of the\nscores" + (f" ({unit})" if unit else ""))
        for axes in (genes, scores):
            axes.set_ylim(bottom=0)
            mark_stages(axes, history, theme, named=axes is scores)
        set_generations(scores, history)
        scores.set_xlabel("generation")
        figure.align_ylabels()
        size = int(np.shape(run.finished.genomes)[0])
        add_heading(
            figure, heading_of_run(run.path.resolve().name, run.experiment, f", {size} individuals")
        )
    return figure


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
            elif (finite_or_nan(values) % 1 == 0).all():  # a count, such as of restarts
                axes.yaxis.set_major_locator(MaxNLocator(4, integer=True, steps=STEPS))
                top = max(1.0, float(values.max()))
                axes.set_ylim(-0.05 * top, 1.05 * top)
            for before, part in pairwise(stages(history)):
                start = history["evaluations"][[before.stop - 1, part.start]].mean()
                axes.axvline(start, color=theme.ink, linewidth=0.6, linestyle=":")
        panels[-1].set_xlabel("evaluations")
        panels[-1].set_xlim(0, history["evaluations"][-1])
        panels[-1].xaxis.set_major_locator(MaxNLocator(4, integer=True, min_n_ticks=2, steps=STEPS))
        panels[-1].xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
        figure.align_ylabels()
        plugin = run.experiment.entries["search"].name
        add_heading(figure, heading_of_run(run.path.resolve().name, run.experiment, f", {plugin}"))
    return figure


def _logarithmic(values: NDArray[np.float64]) -> bool:
    known = finite_or_nan(values)
    known = known[~np.isnan(known)]
    return bool(len(known)) and bool(known.min() > 0) and known.max() > _LOGARITHMIC * known.min()

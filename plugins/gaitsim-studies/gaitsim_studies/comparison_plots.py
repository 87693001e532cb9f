"""Plot compared experiments against evaluations: best scores, and the ECDF of runtimes."""

from collections.abc import Callable, Mapping
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import ComparisonPlot
from gaitsim.plugin.pictures import LIGHT, WIDTH, Theme, add_heading, finite_or_nan, shorten, styled
from gaitsim_studies.comparison import Findings
from gaitsim_studies.comparison_report import target_words
from gaitsim_studies.statistics import quantiles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Values = NDArray[np.float64]


def convergence_figure(findings: Findings, theme: Theme = LIGHT) -> "Figure":
    """Draw the median best scores so far, with bands from the lower to the upper quartile."""
    bests = np.concatenate([one.best.ravel() for one in findings.samples.values()])
    lowest = bests[np.isfinite(bests)].min()

    def draw(axes: "Axes", label: str, index: int) -> None:
        sample, style = findings.samples[label], theme.line(index)
        low, middle, high = finite_or_nan(quantiles(sample.best, [0.25, 0.5, 0.75]))
        low = np.where(np.isnan(low), lowest, low)  # failed repeats are below the plot
        at = np.append(sample.evaluations, findings.evaluations)
        axes.fill_between(
            at,
            _extended(low),
            _extended(high),
            step="post",
            color=style["color"],
            alpha=0.15,
            linewidth=0,
        )
        axes.step(at, _extended(middle), where="post", label=shorten(label, 40), **style)

    text = f"median and quartiles of {findings.repeats} repeats"
    units = {one.experiment.fitness.unit for one in findings.samples.values()}
    unit = units.pop() if len(units) == 1 else ""
    return _figure(
        findings, theme, draw, "best score so far" + (f" ({unit})" if unit else ""), text
    )


def ecdf_figure(findings: Findings, theme: Theme = LIGHT) -> "Figure":
    """Draw the share of (repeat, target) pairs that are reached, with the area under each curve."""

    def draw(axes: "Axes", label: str, index: int) -> None:
        one, sample = findings.ecdfs[label], findings.samples[label]
        at = np.concatenate([[0], sample.evaluations, [findings.evaluations]])
        share = 100 * _extended(np.append(0.0, one.share))
        name = f"{shorten(label, 40)}, area {one.area:.3f}"
        axes.step(at, share, where="post", label=name, **theme.line(index))
        axes.set_ylim(0, 102)

    text = f"{findings.repeats} repeats, {target_words(findings)}"
    return _figure(findings, theme, draw, "targets reached (%)", text)


FIGURES: Mapping[ComparisonPlot, Callable[[Findings, Theme], "Figure"]] = {
    "convergence": convergence_figure,
    "ecdf": ecdf_figure,
}


def _extended(values: Values) -> Values:
    """Return the values of a step function, with the last repeated for the end of the budget."""
    return np.append(values, values[-1])


def _figure(
    findings: Findings,
    theme: Theme,
    draw: "Callable[[Axes, str, int], None]",
    quantity: str,
    text: str,
) -> "Figure":
    from matplotlib.figure import Figure

    with styled(theme):
        figure = Figure(figsize=(1.5 * WIDTH, 3.0))
        axes = figure.subplots()
        for index, label in enumerate(findings.samples):
            draw(axes, label, index)
        axes.set_xlim(0, findings.evaluations)
        axes.set_xlabel("evaluations")
        axes.set_ylabel(quantity)
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
        axes.set_title("\n".join(wrap(findings.warning, 84)), color=theme.colours[1], size=7)
        add_heading(figure, text, *axes.get_legend_handles_labels())
    return figure

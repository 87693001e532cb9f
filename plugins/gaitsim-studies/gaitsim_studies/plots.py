"""Plot comparisons and studies: best scores, ECDFs of runtimes and surfaces."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import ComparisonPlot
from gaitsim.plugin.pictures import (
    LIGHT,
    WIDTH,
    Theme,
    add_heading,
    finite_or_nan,
    save,
    shorten,
    styled,
)
from gaitsim.plugin.runs import writing
from gaitsim_studies.comparison import Findings
from gaitsim_studies.comparison_report import target_words
from gaitsim_studies.file import EXPERIMENT, Cell, Scalar, Study
from gaitsim_studies.running import Best, recorded_generations
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


def surface_axis(study: Study) -> str | None:
    """Return the only axis of a study, if its values are numbers; else None."""
    if len(study.axes) != 1 or {*study.axes} & {"evolution.generations", "seed"}:
        return None
    (axis,) = study.axes
    values = study.values(axis)
    return axis if _are_numbers(values) and len(values) > 1 else None


def _are_numbers(values: Sequence[Scalar]) -> bool:
    return all(isinstance(one, int | float) and not isinstance(one, bool) for one in values)


def plot_surfaces(folder: Path, study: Study, results: Sequence[tuple[Cell, Best]]) -> None:
    """Draw the surface of each experiment into a folder, after removing old surfaces."""
    for old in folder.glob("surface-*.png"):
        with writing(old):
            old.unlink()
    axis = surface_axis(study)
    if axis is not None:
        for place, experiment in enumerate(study.experiments, 1):
            file = folder / f"surface-{place}-{Path(experiment).stem}.png"
            _plot_surface(study, axis, experiment, results, file)


@np.errstate(over="ignore")
def _plot_surface(
    study: Study, axis: str, experiment: str, results: Sequence[tuple[Cell, Best]], path: Path
) -> None:
    """Draw the surface of an experiment, unless it has only one generation or no scores."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    mine = [(cell, best) for cell, best in results if cell.point[EXPERIMENT] == experiment]
    generations = recorded_generations(mine[0][0].experiment, study.record_every)
    along = np.array([cell.point[axis] for cell, _ in mine], dtype=float)
    means = np.stack([best.mean(axis=0) for _, best in mine])
    means[~np.isfinite(means)] = np.nan  # a repeat without a score leaves a hole in the surface
    if means.shape[1] < 2 or np.isnan(means).all():
        return
    with styled(LIGHT):
        figure = Figure(figsize=(5.4, 4.2))
        figure.set_layout_engine("none")  # the layout engine cannot place 3D axes
        axes = figure.add_axes((0.0, -0.02, 0.96, 1.0), projection="3d")
        x, y = np.meshgrid(generations, along)
        axes.plot_surface(  # type: ignore[attr-defined]
            x,
            y,
            means,
            cmap="viridis",
            rcount=len(along),
            ccount=len(generations),
            linewidth=0.1,
            antialiased=True,
        )
        axes.set_xlabel("generations")
        axes.set_ylabel(
            axis.removeprefix("evolution.").replace("_", " ")
            + " size" * (axis == "evolution.population")
        )
        axes.set_zlabel("mean best score")  # type: ignore[attr-defined]
        lowest, highest = min(0.0, float(np.nanmin(means))), float(np.nanmax(means))
        low, *_, high = MaxNLocator(5).tick_values(lowest, highest)
        axes.set_zlim(low, high)  # type: ignore[attr-defined]
        for one in (axes.xaxis, axes.yaxis, axes.zaxis):  # type: ignore[attr-defined]
            one.set_major_locator(MaxNLocator(5))
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        if (along % 1 == 0).all():
            axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.set_box_aspect(None, zoom=0.88)  # type: ignore[call-arg]
        axes.view_init(elev=24, azim=-128)  # type: ignore[attr-defined]
        axes.set_title(
            f"{experiment}, mean of {study.repeats} repeat{'s' * (study.repeats > 1)}",
            fontsize="medium",
            y=0.95,
        )
    save(figure, path)

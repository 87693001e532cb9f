"""Plot several runs in one figure: the median and quartiles of the repeats of an experiment."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.plugin import GaitsimError, NothingToPlotError
from gaitsim.plugin.pictures import WIDTH, Theme, add_heading, finite_or_nan, shorten, styled
from gaitsim.plugin.runs import (
    ComparedRun,
    RunSnapshot,
    RunsReader,
    find_run,
    list_runs,
    unfinished_error,
    warning,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def runs_figure(run: RunSnapshot, theme: Theme, beside: Sequence[str | Path] = ()) -> "Figure":
    """Plot the best score so far of one or several runs, each with its repeats.

    Repeats are in the same folder as the run and differ from it only in seed, name and length.
    Repeats of less than half the length are left out. The median ends with the shortest repeat.
    """
    from matplotlib.figure import Figure

    paths = [run.path, *(find_run(str(other)) for other in beside)]
    groups = [_check_readable(RunsReader(repeats_of(path)).read()) for path in dict.fromkeys(paths)]
    if sum(map(len, groups)) == 1:
        raise NothingToPlotError(
            f"no other run repeats the experiment of {run.path} with a different seed",
            allowed="runs that differ only in seed, name and generations",
            remedy="evolve the experiment with other values of --seed, or add runs with --beside",
        )
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 2.5))
        axes = figure.subplots()
        for index, group in enumerate(groups):
            _draw(axes, group, theme.line(index))
        axes.margins(x=0)
        axes.set_xlabel("evaluations")
        units = {RunSnapshot(path).experiment.fitness.unit for path in dict.fromkeys(paths)}
        unit = units.pop() if len(units) == 1 else ""
        axes.set_ylabel("best score so far" + (f" ({unit})" if unit else ""))
        note = warning([group[0] for group in groups])
        axes.set_title("\n".join(wrap(note, 56)), color=theme.colours[1], size=7)
        bands = any(len(group) > 1 for group in groups)
        text = "median and quartiles over seeds" if bands else f"{len(groups)} runs"
        add_heading(figure, text, *axes.get_legend_handles_labels())
    return figure


def repeats_of(path: Path) -> list[Path]:
    """Return a run and the runs in its folder that repeat its experiment with other seeds.

    Each seed counts once. A run with several stages has no repeats.
    """
    one, seeds = RunSnapshot(path), dict[int, Path]()
    if len(one.stages) > 1:
        return [path]
    wanted = _experiment(one)
    for other in [path, *list_runs(path.parent)]:
        run = RunSnapshot(other)
        try:
            if (
                run.outline.seed not in seeds
                and _experiment(run) == wanted
                and len(run.stages) == 1
            ):
                seeds[run.outline.seed] = other
        except (GaitsimError, OSError):
            continue
    return [*seeds.values()]


def _experiment(run: RunSnapshot) -> Mapping[str, Any]:
    """Return the options of a run that affect the evolution, except its seed."""
    return {kind: table for kind, table in run.outline.search_options().items() if kind}


def _check_readable(runs: Sequence[ComparedRun]) -> list[ComparedRun]:
    for run in runs:
        if run.problem is not None:
            raise run.problem
        if not run.history:
            raise unfinished_error(run.path)
    return [*runs]


def _draw(axes: "Axes", group: Sequence[ComparedRun], style: Mapping[str, Any]) -> None:
    """Draw the median and quartiles of a group, or the line of a single run."""
    group = [run for run in group if 2 * run.generation >= group[0].generation]
    length = min(run.generation for run in group)
    first = max(run.first_comparable for run in group) - 1
    part = slice(first, length)
    bests = np.stack(
        [np.fmax.accumulate(finite_or_nan(run.history["best"][part])) for run in group]
    )
    evaluations, label = group[0].axis("evaluations")[part], shorten(group[0].label, 30)
    if len(group) > 1:
        low, middle, high = np.quantile(bests, [0.25, 0.5, 0.75], axis=0)
        axes.fill_between(evaluations, low, high, color=style["color"], alpha=0.2, linewidth=0)
        label += f" ({len(group)} seeds)"
    else:
        (middle,) = bests
    axes.plot(evaluations, middle, label=label, marker="." if len(middle) == 1 else None, **style)

"""Plot several runs in one figure."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap

from gaitsim.errors import RunError
from gaitsim.render.plots.components import finite_or_nan
from gaitsim.render.plots.labels import add_heading, shorten
from gaitsim.render.plots.style import LIGHT, WIDTH, Theme, check_target, save, styled
from gaitsim.render.series import run_curves
from gaitsim.storage.compare_runs import ComparedRun, quantity_label, warning


def plot_overlay(
    runs: Sequence[ComparedRun], quantity: str, by: str, path: Path, theme: Theme = LIGHT
) -> None:
    """Draw a line for each run, with a dot at each new stage, and a warning if scores differ.

    Args:
        runs: runs to compare.
        quantity: vertical axis, a name in `gaitsim.storage.compare_runs.QUANTITIES`.
        by: horizontal axis, a name in `gaitsim.storage.compare_runs.AXES`.
        path: path of the file.
        theme: colours of the plot.
    """
    from matplotlib.figure import Figure

    check_target(path)
    drawn = run_curves(runs, quantity, by)
    if not drawn:
        raise RunError("none of these runs has a finished generation yet")
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 2.4))
        axes = figure.subplots()
        for index, one in enumerate(drawn):
            axes.plot(
                one.x,
                finite_or_nan(one.y),
                label=shorten(one.name, 40),
                marker="." if one.stages or len(one.x) == 1 else None,
                markevery=list(one.stages) or [0],
                **theme.line(index),
            )
        axes.margins(x=0)
        axes.set_xlabel(f"{by} (s)" if by == "seconds" else by)
        axes.set_ylabel(quantity_label(quantity))
        axes.set_title("\n".join(wrap(warning(runs), 56)), color=theme.colours[1], size=7)
        add_heading(figure, f"{len(drawn)} runs", *axes.get_legend_handles_labels())
    save(figure, path, theme)

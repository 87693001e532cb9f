"""Plot the terms of the score by generation."""

from typing import TYPE_CHECKING

from gaitsim.errors import RunError
from gaitsim.render.plots.fitness import draw_curve, mark_stages, set_generations
from gaitsim.render.plots.labels import add_heading, heading_of_run, shorten
from gaitsim.render.plots.panels import grid
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim.runs.files.folder import unfinished_error
from gaitsim.runs.files.history import COLUMNS, MEAN
from gaitsim.runs.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MAX_PANELS = 40  # maximum number of panels, each of which takes 0.1 s


def terms_figure(run: RunSnapshot, theme: Theme) -> "Figure":
    """Plot a panel for each term, with the best individual's term and the population's mean.

    Each panel has its own scale, and a line at zero if zero is within it.
    """
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
    with styled(theme):
        figure, panels = grid(len(names), WIDTH, columns=2 if len(names) > 1 else 1, height=1.0)
        for axes, name in zip(panels, names, strict=True):
            for values, label, colour, style in (
                (history[MEAN + name], "mean of the population", theme.ink, "--"),
                (history[name], "best individual", theme.colours[0], "-"),
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
        figure.supylabel(f"term of the score{f' ({unit})' if unit else ''}", fontsize=8)
        add_heading(
            figure,
            heading_of_run(run.path.resolve().name, run.experiment),
            *panels[0].get_legend_handles_labels(),
        )
    return figure

"""Plot the diversity of the population by generation."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.contracts import BitSpace
from gaitsim.render.plots.fitness import draw_curve, mark_stages, set_generations
from gaitsim.render.plots.labels import add_heading, heading_of_run
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim.runs.files.folder import unfinished_error
from gaitsim.runs.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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

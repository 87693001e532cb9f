"""Convergence of compared experiments: best score against evaluations, with bands."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gaitsim.render.plots import COLOURS, save
from gaitsim.study.comparison import Sample

# They tell curves apart in grey, too.
STYLES = ("-", "--", "-.", ":")


def plot_convergence(samples: Mapping[str, Sample], path: Path) -> None:
    """Draw medians and quartile bands over the repeats.

    Raises:
        RunError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 3.4), layout="constrained")
    axes = figure.subplots()
    for index, (label, sample) in enumerate(samples.items()):
        colour, style = COLOURS[index % len(COLOURS)], STYLES[index % len(STYLES)]
        low, middle, high = np.quantile(
            np.where(np.isfinite(sample.best), sample.best, np.nan), [0.25, 0.5, 0.75], axis=0
        )
        axes.fill_between(sample.evaluations, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(sample.evaluations, middle, color=colour, linestyle=style, label=label)
    repeats = len(next(iter(samples.values())).best)
    axes.set_xlabel("evaluations")
    axes.set_ylabel("best score so far")
    axes.set_title(f"median and quartiles of {repeats} repeats", fontsize="medium")
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.3, linewidth=0.5)
    axes.margins(x=0.01)
    axes.legend(frameon=False, fontsize="small", loc="lower right")
    save(figure, path)

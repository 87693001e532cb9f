"""Plot the convergence of compared experiments: best score over evaluations, with bands."""

from collections.abc import Mapping
from pathlib import Path
from textwrap import wrap

import numpy as np

from gaitsim.render.plots.components import finite
from gaitsim.render.plots.labels import head, shortened
from gaitsim.render.plots.style import LIGHT, WIDTH, save, styled
from gaitsim.study.comparison import Sample


def plot_convergence(samples: Mapping[str, Sample], path: Path, warning: str = "") -> None:
    """Draw medians and quartile bands over the repeats, under a warning if there is one.

    Raises:
        RunError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    with styled(LIGHT):
        figure = Figure(figsize=(1.5 * WIDTH, 3.4))
        axes = figure.subplots()
        for index, (label, sample) in enumerate(samples.items()):
            low, middle, high = np.quantile(finite(sample.best), [0.25, 0.5, 0.75], axis=0)
            style = LIGHT.line(index)
            axes.fill_between(
                sample.evaluations, low, high, color=style["color"], alpha=0.15, linewidth=0
            )
            axes.plot(sample.evaluations, middle, label=shortened(label, 40), **style)
        repeats = len(next(iter(samples.values())).best)
        axes.set_xlabel("evaluations")
        axes.set_ylabel("best score so far")
        axes.set_title("\n".join(wrap(warning, 84)), color=LIGHT.colours[1], size=7)
        axes.margins(x=0.01)
        text = f"median and quartiles of {repeats} repeats"
        head(figure, text, *axes.get_legend_handles_labels())
    save(figure, path)

"""Plot the genome of each generation's best as a heat map."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import BitSpace, GenomeSpace, NothingToPlotError, RealSpace
from gaitsim.plugin.pictures import (
    STEPS,
    WIDTH,
    Theme,
    add_heading,
    heading_of_run,
    mark_stages,
    shorten,
    styled,
)
from gaitsim.plugin.runs import RunSnapshot, unfinished_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MAX_GENERATIONS = (
    1000  # maximum number of generations drawn, about the horizontal dots of the picture
)
MAX_GENES = 48  # maximum number of genes drawn, whose names are legible


def genome_figure(run: RunSnapshot, theme: Theme) -> "Figure":
    """Plot the genes of each generation's best: a row for each gene, a column per generation.

    The colour shows the position of a gene between its bounds. If nearly all genes are in a small
    part of that range, the colours cover only this part. Of a long genome, the genes that differ
    most between the generations are drawn; of many generations, evenly spaced ones.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    history, bests = run.history, run.bests
    if not len(bests):
        raise unfinished_error(run.path)
    space, last = run.experiment.space(), len(bests)
    columns = np.unique(np.linspace(0, last - 1, min(last, _MAX_GENERATIONS)).round().astype(int))
    bits, places = isinstance(space, BitSpace), _positions(space, bests["genome"][columns], run)
    rows = np.sort(np.argsort(-places.std(axis=0), kind="stable")[:MAX_GENES])
    places = places[:, rows]
    low, high = (0.0, 1.0) if bits else _range(places)
    with styled(theme):
        height = float(np.clip(0.1 * len(rows), 1.0, 4.8))
        figure = Figure(figsize=(WIDTH, height + 1.15))
        axes = figure.subplots()
        image = axes.imshow(
            places.T,
            cmap=ListedColormap([theme.faint, theme.colours[0]]) if bits else "cividis",
            vmin=low,
            vmax=high,
            aspect="auto",
            interpolation="nearest",
            extent=(0.5, last + 0.5, len(rows) - 0.5, -0.5),
        )
        mark_stages(axes, history, theme, named=False)
        axes.set_yticks(range(len(rows)), [shorten(space.labels[row], 24) for row in rows])
        axes.tick_params(axis="y", labelsize=5.5, length=0)
        axes.grid(visible=False)
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1, steps=STEPS))
        axes.set_xlabel("generation")
        bar = figure.colorbar(
            image,
            ax=axes,
            location="bottom",
            aspect=40,
            pad=0.02,
            shrink=0.8,
            extend="neither" if (low, high) == (0.0, 1.0) else "both",
        )
        bar.outline.set_visible(False)
        if bits:
            bar.set_ticks([0.25, 0.75], labels=["bit 0", "bit 1"])
        else:
            bar.ax.xaxis.set_major_formatter(lambda place, _: f"{100 * place:.3g} %")
            bar.set_label("position of the gene between its bounds", fontsize=7, labelpad=1)
        bar.ax.tick_params(length=0)
        more = ", best of each generation"
        if len(rows) < space.genes:
            axes.set_title(
                f"the {len(rows)} of {space.genes} genes that differ most between generations",
                fontsize=7,
            )
        add_heading(figure, heading_of_run(run.path.resolve().name, run.experiment, more))
    return figure


def _positions(
    space: GenomeSpace, genomes: NDArray[np.generic], run: RunSnapshot
) -> NDArray[np.float64]:
    """Return the positions of genes between their bounds, 0 to 1, (generations, genes)."""
    values = np.asarray(genomes, dtype=np.float64)
    if isinstance(space, RealSpace):
        return (values - space.lower) / space.width
    if isinstance(space, BitSpace):
        return values
    raise NothingToPlotError(
        f"the genes of {run.experiment.entries['organism']} have no bounds",
        allowed="a body with a genome of real numbers or bits",
    )


def _range(places: NDArray[np.float64]) -> tuple[float, float]:
    """Return the part of the range 0 to 1 that the colours cover."""
    low, high = np.quantile(places, [0.03, 0.97])
    return (float(low), float(high)) if 0 < high - low < 0.6 else (0.0, 1.0)

"""Plot the genome of each generation's best as a heat map."""

import re
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import BitSpace, GenomeSpace, RealSpace
from gaitsim.errors import NothingToPlotError
from gaitsim.render.plots.fitness import mark_stages
from gaitsim.render.plots.labels import add_heading, heading_of_run, shorten
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim.storage.files.folder import unfinished_error
from gaitsim.storage.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MAX_GENERATIONS = (
    1000  # maximum number of generations drawn, about the horizontal dots of the picture
)
_MAX_NAMES = 48  # maximum number of genes with names
_MAX_GROUPS = 24  # maximum number of groups of genes with names


def genome_figure(run: RunSnapshot, theme: Theme) -> "Figure":
    """Plot the genes of each generation's best: a row for each gene, a column per generation.

    The colour shows the position of a gene between its bounds. If nearly all genes are in a small
    part of that range, the colours cover only this part. If there are more than a thousand
    generations, evenly spaced ones are drawn.
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
    low, high = (0.0, 1.0) if bits else _range(places)
    with styled(theme):
        height = float(np.clip(0.1 * space.genes, 1.0, 4.8))
        figure = Figure(figsize=(WIDTH, height + 1.15))
        axes = figure.subplots()
        image = axes.imshow(
            places.T,
            cmap=ListedColormap([theme.faint, theme.colours[0]]) if bits else "cividis",
            vmin=low,
            vmax=high,
            aspect="auto",
            interpolation="nearest",
            extent=(0.5, last + 0.5, space.genes - 0.5, -0.5),
        )
        mark_stages(axes, history, theme, named=False)
        _name_rows(axes, space.labels, theme)
        axes.grid(visible=False)
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
        axes.set_xlabel("generation")
        bar = figure.colorbar(image, ax=axes, location="bottom", aspect=40, pad=0.02, shrink=0.8)
        bar.outline.set_visible(False)
        if bits:
            bar.set_ticks([0.25, 0.75], labels=["bit 0", "bit 1"])
        else:
            bar.ax.xaxis.set_major_formatter(lambda place, _: f"{100 * place:.3g} %")
            bar.set_label("position of the gene between its bounds", fontsize=7, labelpad=1)
        bar.ax.tick_params(length=0)
        add_heading(
            figure,
            heading_of_run(run.path.resolve().name, run.experiment, ", best of each generation"),
        )
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
    low, high = np.quantile(places, [0.005, 0.995])
    return (float(low), float(high)) if 0 < high - low < 0.6 else (0.0, 1.0)


def _name_rows(axes: "Axes", labels: tuple[str, ...], theme: Theme) -> None:
    """Write the name of each gene, or, of too many genes, the first words that groups share."""
    axes.tick_params(axis="y", labelsize=5.5, length=0)
    if len(labels) <= _MAX_NAMES:
        axes.set_yticks(range(len(labels)), [shorten(label, 24) for label in labels])
        return
    groups = [(name, len([*same])) for name, same in groupby(labels, _group)]
    ends = np.cumsum([count for _, count in groups])
    if len(groups) > _MAX_GROUPS:
        axes.set_ylabel("gene")
        return
    middles = ends - np.array([count for _, count in groups]) / 2 - 0.5
    # The names of small neighbouring groups would overlap.
    room, kept = len(labels) / 40, list[int]()
    for place in np.argsort([-count for _, count in groups], kind="stable").tolist():
        if all(abs(middles[place] - middles[other]) > room for other in kept):
            kept.append(place)
    names = [f"{shorten(groups[place][0], 16)} ({groups[place][1]})" for place in kept]
    axes.set_yticks(middles[kept], names)
    for end in ends[:-1]:
        axes.axhline(end - 0.5, color=theme.background, linewidth=0.4)


def _group(label: str) -> str:
    """Return the first word of a gene's name, such as W1 for W1[0,3]."""
    return re.split(r"[\s\[(_.]", label, maxsplit=1)[0]

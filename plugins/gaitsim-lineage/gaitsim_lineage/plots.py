"""Figures of lines of ancestors and of family trees."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from gaitsim.plugin import NothingToPlotError, shortened
from gaitsim.plugin.pictures import (
    WIDTH,
    Theme,
    add_heading,
    finite_or_nan,
    heading_of,
    set_generations,
    styled,
)
from gaitsim_lineage.genealogy import Floats, Rows
from gaitsim_lineage.lineage import Lineage, signed

NAMED = 4  # largest rises with a label
LONGEST = 40  # characters of a label


def lineage_figure(found: Lineage, theme: Theme) -> Figure:
    """Return the scores of a line of ancestors over the generations."""
    run, steps = found.run, found.steps
    generations = np.array([step.place.generation for step in steps])
    scores = finite_or_nan(np.array([step.score for step in steps]))
    if not np.isfinite(scores).any():
        raise NothingToPlotError("all ancestors failed")
    with styled(theme):
        figure = Figure((WIDTH, 0.9 * WIDTH), layout="constrained")
        axes, text = figure.subplots(2, 1, height_ratios=(4, 1))
        best = finite_or_nan(run.history["best"][: generations[-1]])
        numbers = np.arange(1, len(best) + 1)
        (curve,) = axes.plot(numbers, best, color=theme.faint, lw=3)
        (line,) = axes.plot(generations, scores, color=theme.ink, lw=1, marker="o", ms=2.5)
        unit = found.individual.experiment.fitness.unit
        axes.set_ylabel(f"score ({unit})" if unit else "score")
        axes.set_xlabel("generation")
        set_generations(axes, {"generation": numbers.astype(float)})
        chosen = sorted(found.rises[:NAMED])
        labels = []
        for place, index in enumerate(chosen, 1):
            step = steps[index]
            axes.annotate(
                str(place),
                (generations[index], scores[index]),
                xytext=(0, 4),
                textcoords="offset points",
                color=theme.colours[0],
                weight="bold",
                ha="center",
            )
            what = shortened(step.what, LONGEST)
            labels.append(
                f"{place}  generation {step.place.generation}, {signed(step.gain)}: {what}"
            )
        text.axis("off")
        words = text.text(-0.13, 1, "\n".join(labels), va="top", transform=text.transAxes)
        words.set_fontsize(6.5)
        words.set_in_layout(False)  # it may be wider than the axes
        names = ["best of the generation", "the line of ancestors"]
        add_heading(figure, heading_of([found.individual]), [curve, line], names)
    return figure


def genealogy_figure(found: Lineage, theme: Theme) -> Figure:
    """Return the family tree of the individuals that a search had, with the line of one of them."""
    rows = found.living
    across, up = rows.generation.astype(np.float64), _places(rows)
    child = np.flatnonzero(rows.parent >= 0)
    parent = rows.parent[child]
    corners = ((parent, parent), (parent, child), (child, child))
    bends = np.stack([np.stack([across[one], up[two]], axis=1) for one, two in corners], axis=1)
    ours = np.isin(child, found.line)
    with styled(theme):
        figure = Figure((WIDTH, 0.9 * WIDTH), layout="constrained")
        axes = figure.subplots()
        axes.add_collection(LineCollection([*bends[~ours]], colors=theme.ink, lw=0.4, alpha=0.5))
        axes.add_collection(LineCollection([*bends[ours]], colors=theme.colours[0], lw=1.6))
        axes.set_ylim(-0.5, max(up.max(), 1) + 0.5)
        axes.set_yticks([])
        axes.set_xlabel("generation of birth")
        set_generations(axes, {"generation": np.array([across.max()])})
        leaves = len(rows) - len(np.unique(parent))
        axes.set_ylabel(f"{leaves:,} individual{'s' * (leaves != 1)} without children")
        since, founders = found.coalescence, int((rows.parent < 0).sum())
        text = f"{founders:,} founder{'s' * (founders != 1)}, "
        if not found.named:
            text += "parents: the nearest samples"
        else:
            text += (
                "no common ancestor" if since is None else f"common ancestor: generation {since}"
            )
        axes.set_title(text, fontsize=6.5, loc="left")
        add_heading(figure, heading_of([found.individual]))
    return figure


def _places(rows: Rows) -> Floats:
    """Return the height of each row in the tree: leaves in order, parents amid their children."""
    count = len(rows)
    children: list[list[int]] = [[] for _ in range(count)]
    stack: list[int] = []
    for row, parent in enumerate(rows.parent.tolist()):
        (children[parent] if parent >= 0 else stack).append(row)
    up, leaves, order = np.zeros(count), 0, []
    while stack:
        row = stack.pop()
        order.append(row)
        if not children[row]:
            up[row] = leaves
            leaves += 1
        stack += children[row]
    for row in reversed(order):
        if children[row]:
            up[row] = np.mean(up[children[row]])
    return up

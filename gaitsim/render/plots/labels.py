"""Headings, legends and names on plots."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.render.plots.style import WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HEADING = 58  # characters of 8 points in a column's width
_LEGEND = 62  # characters of 7 points in a row of a legend, without marks
STEPS = [1, 2, 5, 10]  # steps between ticks, times a power of ten
_MARK = 7  # width of a legend's mark, in characters


def shorten(text: str, length: int) -> str:
    """Shorten text to at most `length` characters by replacing its middle with an ellipsis."""
    if len(text) <= length:
        return text
    kept = length * 2 // 3
    return f"{text[:kept]}…{text[kept - length + 1 :]}"


def format_number(value: float) -> str:
    """Format a number with four significant digits and a true minus sign, as axes do."""
    return f"{value:.4g}".replace("-", "−")


def format_score(individual: Individual) -> str:
    """Format a score with its unit and the number of worlds, such as 'score 2.53 m'."""
    score = f"score {format_number(individual.score)} {individual.experiment.fitness.unit}".rstrip()
    return score + individual.over_worlds


def heading_of_run(run: str, experiment: Experiment, more: str = "", width: float = WIDTH) -> str:
    """Return a run's name, its experiment's name if different, the seed, and `more`.

    Names are shortened to fit a figure of `width` inches.
    """
    rest = f", seed {experiment.seed}{more}"
    room = max(10, int(_HEADING * width / WIDTH) - len(rest))
    name, kind = (" ".join(text.split()) for text in (run, experiment.name))
    both = f"{name} ({kind})"
    return (both if name != kind and len(both) <= room else shorten(name, room)) + rest


def heading_of(individuals: Sequence[Individual]) -> str:
    """Return the run's name and seed with the generation and score, or with several generations.

    What does not fit is left out: the number of worlds, then the score.
    """
    numbers = ", ".join(str(individual.generation) for individual in individuals)
    one = individuals[0]
    score = f"{one.label}, {format_score(one)}"
    shorter = (score, score.removesuffix(one.over_worlds), one.label)
    room = _HEADING - len(f"{one.name}, seed {one.experiment.seed}, ")
    what = next((text for text in shorter if len(text) <= room), one.label)
    if len(individuals) > 1:
        what = f"generations {shorten(numbers, 24)}"
    return heading_of_run(one.name, one.experiment, f", {what}")


def add_heading(
    figure: "Figure", text: str, handles: Sequence[Any] = (), labels: Sequence[str] = ()
) -> None:
    """Finish a figure: use round ticks, and write a heading and a legend above the panels."""
    _round_ticks(figure)
    scale = figure.get_figwidth() / WIDTH
    text = shorten(text, int(_HEADING * scale))
    if not handles:
        figure.suptitle(text, x=0.01, ha="left")
        return
    # The heading is the title of the legend, as a title of the figure would overlap the legend.
    figure.legend(
        handles,
        labels,
        loc="outside upper left",
        title=text,
        title_fontsize=8,
        alignment="left",
        ncols=_columns(labels, _LEGEND * scale),
        handlelength=1.8,
        columnspacing=1.0,
        borderaxespad=0.1,
        borderpad=0.1,
        labelspacing=0.3,
    )


def _round_ticks(figure: "Figure") -> None:
    """Let axes step by 1, 2 or 5 × 10ⁿ; Matplotlib also chooses 2.5, whose labels are longer."""
    from matplotlib.ticker import AutoLocator, MaxNLocator

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if isinstance(axis.get_major_locator(), AutoLocator):
                axis.set_major_locator(MaxNLocator("auto", steps=STEPS))


def _columns(labels: Sequence[str], width: float) -> int:
    """Return the number of columns of a legend that fit; legends are filled column by column."""
    lengths = [len(label) + _MARK for label in labels]
    for columns in range(len(labels), 1, -1):
        parts = np.array_split(lengths, columns)
        if sum(int(part.max()) for part in parts) <= width:
            return columns
    return 1

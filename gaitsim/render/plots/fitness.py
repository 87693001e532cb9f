"""Plot the scores by generation."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.render.plots.components import finite_or_nan
from gaitsim.render.plots.labels import STEPS, add_heading, format_score, heading_of_run
from gaitsim.render.plots.style import LIGHT, WIDTH, Theme, styled
from gaitsim.storage.files.folder import champion_generations, unfinished_error
from gaitsim.storage.snapshot import RunSnapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

History = dict[str, NDArray[np.float64]]


def fitness_figure(
    run: RunSnapshot, theme: Theme = LIGHT, size: tuple[float, float] = (WIDTH, 2.4)
) -> "Figure":
    """Plot best, mean and quartiles of the scores, saved champions and the starts of stages.

    Args:
        run: run with at least one generation.
        theme: colours of the plot.
        size: width and height, inches.
    """
    from matplotlib.figure import Figure

    history = run.history
    if not history:
        raise unfinished_error(run.path)
    with styled(theme):
        figure = Figure(figsize=size)
        axes = figure.subplots()
        _draw_islands(axes, history, run.islands, theme)
        _draw(axes, history, theme)
        _mark_champions(axes, run, history, theme)
        starts = mark_stages(axes, history, theme)
        axes.set_xlabel("generation")
        axes.set_ylabel(_score_label([run.experiment_at(number) for number in (1, *starts)]))
        set_generations(axes, history)
        if not np.isfinite(history["best"]).all():
            axes.set_title("generations without a finite score are left out", fontsize=7)
        add_heading(
            figure,
            heading_of_run(run.path.resolve().name, run.experiment),
            *axes.get_legend_handles_labels(),
        )
    return figure


def _score_label(stages: Sequence[Experiment]) -> str:
    """Return the label of scores, with the fitness and the unit if all stages share them."""
    names = {stage.entries["fitness"].name for stage in stages}
    units = {stage.fitness.unit for stage in stages}
    words = [*(names if len(names) == 1 else ()), *(units - {""} if len(units) == 1 else ())]
    label = "score" if len(names) == 1 else "score of each stage"
    return f"{label} ({', '.join(words)})" if words else label


def _draw(axes: "Axes", history: History, theme: Theme) -> None:
    generations = history["generation"]
    mean, std = history["mean"], history["std"]
    band = "mean ± s.d."
    low, high = mean - std, mean + std
    if "lower quartile" in history:
        band = "quartiles"
        low, high = history["lower quartile"], history["upper quartile"]
    for part in stages(history):
        axes.fill_between(
            generations[part],
            low[part],
            high[part],
            color=theme.faint,
            alpha=0.6,
            linewidth=0,
            label=None if part.start else band,
        )
    draw_curve(axes, history, mean, color=theme.ink, linestyle="--", label="mean")
    draw_curve(axes, history, history["best"], color=theme.colours[0], linestyle="-", label="best")


def draw_curve(
    axes: "Axes", history: History, values: NDArray[np.float64], label: str | None, **style: Any
) -> None:
    """Draw values by generation, with gaps between stages."""
    for part in stages(history):
        axes.plot(
            history["generation"][part],
            finite_or_nan(values[part]),
            label=None if part.start else label,
            # A line through one point would be invisible.
            marker="." if part.stop - part.start == 1 else None,
            **style,
        )


def _draw_islands(
    axes: "Axes", history: History, islands: NDArray[np.float64], theme: Theme
) -> None:
    """Draw the best scores of each island, if the run has several."""
    if islands.shape[1] == 1:
        return
    for island, bests in enumerate(islands.T):
        label = None if island else f"best of each of {islands.shape[1]} islands"
        colour = theme.colours[0]
        draw_curve(axes, history, bests, label, color=colour, alpha=0.5, linewidth=0.5)


def _mark_champions(axes: "Axes", run: RunSnapshot, history: History, theme: Theme) -> None:
    """Mark the saved champions and the champion of the run."""
    kept = np.array(champion_generations(run.path, len(history["best"])), int)
    style: dict[str, Any] = {"linestyle": "", "color": theme.ink, "clip_on": False, "zorder": 3}
    if len(kept):
        axes.plot(
            kept,
            history["best"][kept - 1],
            marker="|",
            markersize=5,
            markeredgewidth=0.6,
            label="saved champion",
            **style,
        )
    if number := run.best_generation:
        # Without its genome, which cannot be read if the body's plugin is missing.
        champion = Individual(
            run.experiment_at(number), float(history["best"][number - 1]), {}, number
        )
        axes.plot(
            champion.generation,
            champion.score,
            marker="D",
            markersize=3.5,
            label=format_score(champion).replace("score", "champion:"),
            **style,
        )


def stages(history: History) -> list[slice]:
    """Return the rows of each stage of a run."""
    stage = history.get("stage", np.ones_like(history["generation"]))
    borders = [0, *(np.flatnonzero(np.diff(stage)) + 1).tolist(), len(stage)]
    return [slice(first, end) for first, end in pairwise(borders)]


def mark_stages(axes: "Axes", history: History, theme: Theme, *, named: bool = True) -> list[int]:
    """Draw a line before each later stage; return the first generations of these stages."""
    starts = [part.start + 1 for part in stages(history)[1:]]
    for index, start in enumerate(starts, 2):
        axes.axvline(start - 0.5, color=theme.ink, linewidth=0.6, linestyle=":")
        if named:
            axes.annotate(
                f"stage {index}",
                (start - 0.5, 0),  # below the rising curves
                xycoords=("data", "axes fraction"),
                xytext=(2, 2),
                textcoords="offset points",
                fontsize=6,
            )
    return starts


def set_generations(axes: "Axes", history: History, ticks: int = 6) -> None:
    """Limit the horizontal axis to the first and the last generation."""
    from matplotlib.ticker import MaxNLocator

    axes.set_xlim(1, max(2, int(history["generation"][-1])))
    axes.xaxis.set_major_locator(MaxNLocator(ticks, integer=True, steps=STEPS))

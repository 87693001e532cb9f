"""Plot footfalls: when each foot is on the ground (Hildebrand 1965), and the load on it."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import NothingToPlotError
from gaitsim.gait.feet import feet_of
from gaitsim.gait.report import frames_before_fall, vertical_loads, weight_of
from gaitsim.individual import Individual
from gaitsim.render.plots.data import window_slice
from gaitsim.render.plots.labels import add_heading, heading_of, shorten
from gaitsim.render.plots.panels import BAR, draw_bars
from gaitsim.render.plots.style import WIDTH, Theme, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FULL_ROW = 0.98  # quantile of the loads that fills a row, as impacts would dwarf all other loads
DEFAULT_SECONDS = 3.0  # seconds, a few strides of most bodies


def footfall_figure(
    individual: Individual, theme: Theme, window: tuple[float, float] | None = None
) -> "Figure":
    """Plot a row for each foot, with bars while it is on the ground, and its duty factor.

    The plot shows the last seconds, after the gait has settled and before a fall, or the whole
    motion if no foot touches down twice in these seconds. If the body has the channel `load`, a
    curve in each row shows the vertical force on the foot, whose highest peaks are clipped.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    touching, names = contacts_of(individual)
    rate = individual.skeleton.frame_rate
    upright = frames_before_fall(individual)
    frames = len(touching) if window else upright
    part = window_slice(frames, rate, window, DEFAULT_SECONDS)
    landings = np.count_nonzero(~touching[part][:-1] & touching[part][1:], axis=0)
    if window is None and max(landings) < 2:
        part = window_slice(frames, rate, None)
    shown = touching[part]
    steps, _ = feet_of(touching[:upright], names, rate)
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 0.8 + 0.17 * max(3, len(names))))
        axes = figure.subplots()
        rows = [(shorten(name, 12), shown[:, foot]) for foot, name in enumerate(names)]
        colours, load = theme.foot_colours(names), vertical_loads(individual)
        loads = load is not None and load[part].max(initial=0.0) > 0
        draw_bars(axes, rows, part.start / rate, rate, colours, alpha=0.35 if loads else 1.0)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("foot")
        duty = axes.secondary_yaxis("right")
        duty.set_yticks(range(len(names)), [f"{foot.duty_factor:.2f}" for foot in steps])
        duty.tick_params(length=0)
        duty.spines["right"].set_visible(False)
        duty.set_ylabel("duty factor")
        handles, labels = [], []
        if load is not None and loads:
            whole = _rounded_up(float(np.quantile(load[part][load[part] > 0], _FULL_ROW)))
            heights = np.clip(load[part] / whole, 0.0, 1.0)
            for row, (colour, height) in enumerate(zip(colours, heights.T, strict=True)):
                bottom, times = row + BAR / 2, (part.start + np.arange(len(height) + 1)) / rate
                top = bottom - BAR * np.append(height, height[-1])
                axes.fill_between(times, bottom, top, step="post", color=colour, linewidth=0)
            handles.append(Patch(facecolor=theme.ink))
            weight = weight_of(individual)
            weighs = "" if weight is None else f", body weight {weight:.3g} N"
            labels.append(f"vertical load: full row {whole:g} N{weighs}")
        add_heading(figure, heading_of([individual]), handles, labels)
    return figure


def _rounded_up(value: float) -> float:
    """Return the smallest round number that is at least `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if step * power >= value)


def contacts_of(individual: Individual) -> tuple[NDArray[np.bool_], tuple[str, ...]]:
    """Return whether each foot is on the ground, of shape (frames, feet), and the feet's names."""
    skeleton = individual.skeleton
    if skeleton.touching is None or not skeleton.touching.shape[1]:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} has no feet to plot",
            where=str(individual.source),
            allowed="a body whose skeleton has `contacts` and `touching`",
        )
    count = skeleton.touching.shape[1]
    names = skeleton.contact_names or tuple(f"foot {foot}" for foot in range(1, count + 1))
    return np.asarray(skeleton.touching, dtype=np.bool_), names

"""Plot footfalls (Hildebrand 1965), the best gaits of an archive, and the stability margin."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import NothingToPlotError
from gaitsim.plugin.gait import (
    RepertoireGait,
    commanded_frequency,
    feet_of,
    frames_before_fall,
    gaits_of,
    patterns,
    vertical_loads,
    weight_of,
)
from gaitsim.plugin.pictures import (
    BAR,
    WIDTH,
    Theme,
    add_heading,
    draw_bars,
    finite_or_nan,
    format_number,
    heading_of,
    heading_of_run,
    intervals,
    limit_time,
    require_archive,
    shade_spans,
    shorten,
    styled,
    window_slice,
)
from gaitsim.plugin.runs import Individual, Member, RunSnapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
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
    steps, _ = feet_of(
        touching[:upright],
        names,
        rate,
        dynamic=individual.experiment.organism.dynamic,
        commanded=commanded_frequency(individual),
    )
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
    stance = individual.stance
    if stance is None or not stance.shape[1]:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} has no feet to plot",
            where=str(individual.source),
            allowed="a body whose skeleton has `contacts` and `touching`",
        )
    unnamed = tuple(f"foot {foot}" for foot in range(1, stance.shape[1] + 1))
    return np.asarray(stance, dtype=np.bool_), individual.skeleton.contact_names or unnamed


_SECONDS = 2.0  # length of each footfall diagram
_NAMES = {"none": "no name"}
_FOOT = 0.055  # height of a foot's row, inches


def require_gaits(individual: Individual) -> None:
    """Check that an individual's run has an archive and its body has feet."""
    require_archive(individual)
    contacts_of(individual)


def gaits_figure(
    run: RunSnapshot,
    theme: Theme,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> "Figure":
    """Plot a row for each pattern of gait: footfalls and score of its best member, and its cells.

    Gaits without a name come last. The footfalls cover the last seconds before a fall, with
    left feet above right feet as in the plot of a single gait.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    best = run.individual(Member(1)) if run.experiment.search.keeps else run.individual()
    require_gaits(best)
    members = run.members
    assert members is not None, "a search with a first member has members"
    total = len(members.scores)
    begin(total)
    gaits: list[RepertoireGait] = []
    for part in gaits_of(best.experiment, members.genomes):
        gaits += part
        advance(len(part))
    found = patterns(gaits, members.scores)
    with styled(theme):
        feet = contacts_of(best)[0].shape[1]
        height = max(_FOOT * feet + 0.08, 0.34)
        figure = Figure(figsize=(1.5 * WIDTH, 0.75 + height * len(found)))
        strips, scores = figure.subplots(
            len(found), 2, width_ratios=[1.7, 1], squeeze=False
        ).T.tolist()
        low = min(0.0, *(one.score for one in found))
        high = max(0.0, *(one.score for one in found))
        for pattern, strip, bar in zip(found, strips, scores, strict=True):
            member = run.individual(Member(pattern.member))
            _draw_footfalls(strip, member, theme)
            share = f"{max(pattern.count / total, 0.001):.1%}"
            share = f"<{share}" if pattern.count < 0.001 * total else share
            name = shorten(_NAMES.get(pattern.name, pattern.name), 26)
            strip.set_ylabel(
                f"{name}\nmember {pattern.member}",
                rotation=0,
                ha="right",
                va="center",
            )
            _draw_score(bar, pattern.score, theme)
            bar.set_xlim(low - 0.02 * (high - low), high + 0.95 * (high - low))
            cells = f"{pattern.count:,} cell{'s' * (pattern.count > 1)}"
            bar.annotate(
                f"{format_number(pattern.score)}\n{cells}, {share}",
                (max(pattern.score, 0.0), 0),
                xytext=(3, 0),
                textcoords="offset points",
                va="center",
                fontsize=7,
            )
        ticks = [tick for tick in scores[-1].get_xticks() if low <= tick <= high]
        for bar in scores:  # no ticks below the annotations
            bar.set_xticks(ticks)
        for column in (strips, scores):
            for axes in column[:-1]:
                axes.tick_params(labelbottom=False, bottom=False)
                axes.spines["bottom"].set_visible(False)
        strips[-1].set_xlabel("time (s)")
        unit = best.experiment.fitness.unit
        scores[-1].set_xlabel(f"best score ({unit})" if unit else "best score")
        figure.align_ylabels()
        more = f", generation {run.generation}, {total:,} members"
        colours = theme.foot_colours(contacts_of(best)[1])
        sides = {"left feet, front to back": theme.left, "right feet": theme.right}
        shown = {name: Patch(facecolor=one) for name, one in sides.items() if one in colours}
        width = figure.get_figwidth()
        heading = heading_of_run(run.path.resolve().name, run.experiment, more, width)
        add_heading(figure, heading, [*shown.values()], [*shown])
    return figure


def _draw_footfalls(axes: "Axes", member: Individual, theme: Theme) -> None:
    touching, names = contacts_of(member)
    rate = member.skeleton.frame_rate
    part = window_slice(frames_before_fall(member), rate, None, _SECONDS)
    shown = touching[part]
    rows = [("", shown[:, foot]) for foot in range(len(names))]
    draw_bars(axes, rows, 0.0, rate, theme.foot_colours(names))
    axes.set_yticks([])
    axes.set_xlim(0, _SECONDS)


def _draw_score(axes: Any, score: float, theme: Theme) -> None:
    axes.barh([0], [score], height=0.5, color=theme.colours[0], linewidth=0)
    axes.axvline(0, color=theme.ink, linewidth=0.6)
    axes.set_ylim(-0.6, 0.6)
    axes.set_yticks([])
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)


_MILLIMETRES = 1000.0


def stability_figure(
    individual: Individual, theme: Theme, window: tuple[float, float] | None = None
) -> "Figure":
    """Plot the margin in millimetres, shaded below zero, and the number of feet on the ground.

    `gaitsim.gait.margin_of` computes the margin.
    """
    from matplotlib.figure import Figure

    from gaitsim.plugin.gait import gait

    touching, _ = contacts_of(individual)
    margin = gait.margin_of(individual)
    rate = individual.skeleton.frame_rate
    part = window_slice(min(len(margin), len(touching)), rate, window)
    times = np.arange(part.start, part.stop) / rate
    shown = margin[part]
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 2.3))
        axes, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        axes.plot(times, finite_or_nan(shown) * _MILLIMETRES, label="margin", **theme.line(0))
        if np.isfinite(shown).any():
            least = int(np.nanargmin(finite_or_nan(shown)))
            value = float(shown[least]) * _MILLIMETRES
            axes.plot(
                times[least],
                value,
                linestyle="",
                marker="v",
                markersize=4,
                color=theme.colours[1],
                label=f"least: {value:.1f} mm".replace("-", "−"),
                clip_on=False,
                zorder=3,
            )
        axes.axhline(0, color=theme.ink, linewidth=0.6, zorder=1)
        unsupported = intervals(~(shown >= 0), times[0], rate)
        if unsupported:
            share = float(np.mean(~(shown >= 0)))
            shade_spans(axes, unsupported, theme, label=f"unsupported: {share:.0%} of the time")
        axes.set_ylabel("stability\nmargin (mm)")
        below.step(times, touching[part].sum(axis=1), where="post", **theme.line(0))
        below.set_ylim(0, touching.shape[1] + 0.3)
        below.set_yticks([0, touching.shape[1] // 2, touching.shape[1]])
        below.set_ylabel("feet on\nground")
        below.set_xlabel("time (s)")
        limit_time(below, part, rate)
        figure.align_ylabels()
        add_heading(figure, heading_of([individual]), *axes.get_legend_handles_labels())
    return figure

"""Plot adaptations: the trials and their places on the map, and reports on the loss of legs."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.plugin import NothingToPlotError
from gaitsim.plugin.pictures import LIGHT, WIDTH, Theme, add_heading, shorten, styled
from gaitsim_adaptation.adaptation import Adaptation
from gaitsim_adaptation.prior import Floats, Prior
from gaitsim_adaptation.report import AdaptationReport

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_ROOM = 0.15  # margin above and below the points, as a share of their range


def adaptation_figure(adaptation: Adaptation, theme: Theme = LIGHT) -> "Figure":
    """Plot expected and measured performance by trial, and the trials on the map of the atlas.

    A map of more than two axes is projected onto its first two principal components.
    """
    from matplotlib.figure import Figure

    prior, trials = adaptation.prior, adaptation.trials
    if not trials:
        raise NothingToPlotError("the adaptation has no trial yet")
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 5.0))
        above, below = figure.subplots(2, 1, height_ratios=(1, 1.3))
        _draw_trials(above, adaptation, theme)
        _draw_map(below, adaptation, theme)
        damage = ", ".join(adaptation.damage) or adaptation.place
        heading = f"{prior.source.resolve().name}, {shorten(damage, 40)}"
        handles, labels = above.get_legend_handles_labels()
        add_heading(figure, heading, handles, labels)
    return figure


def _draw_trials(axes: "Axes", adaptation: Adaptation, theme: Theme) -> None:
    from matplotlib.ticker import MaxNLocator

    prior, trials = adaptation.prior, adaptation.trials
    numbers = np.array([trial.number for trial in trials])
    expected, deviation, measured = (
        np.array([getattr(trial, name) for trial in trials])
        for name in ("expected", "deviation", "measured")
    )
    axes.errorbar(
        numbers,
        expected,
        deviation,
        color=theme.colours[0],
        fmt="o",
        markersize=3,
        markerfacecolor=theme.background,
        elinewidth=0.8,
        capsize=2,
        label="expected, ± standard deviation",
    )
    axes.step(
        [*numbers, numbers[-1] + 0.4],
        np.maximum.accumulate([*measured, measured[-1]]),
        where="post",
        color=theme.colours[1],
        linewidth=0.8,
    )
    axes.plot(
        numbers, measured, "D", color=theme.colours[1], markersize=3.5, label="measured, and best"
    )
    axes.axhline(
        prior.best, color=theme.ink, linewidth=0.7, linestyle=":", label="best on the intact body"
    )
    points = np.concatenate([expected, measured, [prior.best, 0.0]])
    low, high = float(points.min()), float(points.max())
    axes.set_ylim(low - _ROOM * (high - low), high + _ROOM * (high - low))
    axes.set_xlim(0.4, max(len(trials), 4) + 0.6)
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True))
    axes.set_xlabel("trial")
    axes.set_ylabel(_label(prior))


def _draw_map(axes: "Axes", adaptation: Adaptation, theme: Theme) -> None:
    prior, trials = adaptation.prior, adaptation.trials
    places, names = _projected(prior)
    order = np.argsort(prior.performance, kind="stable")  # the best ones on top
    drawn = axes.scatter(
        places[order, 0],
        places[order, 1],
        c=prior.performance[order],
        s=float(np.clip(4000 / len(places), 1, 12)),
        cmap="viridis",
        linewidths=0,
        rasterized=True,
    )
    best = adaptation.best
    of_map = (trial for trial in trials if not trial.genome)
    for trial in sorted(of_map, key=lambda trial: trial == best):  # the best one on top
        fill, ink = theme.background, theme.ink
        if trial == best:
            fill, ink = theme.colours[1], theme.background
        x, y = places[trial.member - 1]
        axes.plot(x, y, "o", markersize=8, markerfacecolor=fill, markeredgecolor=theme.ink)
        axes.annotate(
            str(trial.number), (x, y), color=ink, fontsize=5.5, ha="center", va="center_baseline"
        )
    axes.set_xlabel(names[0])
    axes.set_ylabel(names[1])
    bar = axes.figure.colorbar(drawn, ax=axes, location="bottom", aspect=40, pad=0.02)
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=0)
    bar.set_label(f"{_label(prior)} on the intact body", fontsize=7)


def _projected(prior: Prior) -> tuple[Floats, tuple[str, str]]:
    """Return the positions (members, 2) of the members on the plot, and the labels of the axes."""
    behaviour = prior.behaviour
    if len(prior.axes) == 1:
        return np.stack([behaviour[:, 0], prior.performance], axis=1), (prior.axes[0], "intact")
    if len(prior.axes) == 2:
        first, second = (f"{shorten(name, 24)}, share of its range" for name in prior.axes)
        return behaviour, (first, second)
    centred = behaviour - behaviour.mean(axis=0)
    variances, vectors = np.linalg.eigh(centred.T @ centred)
    main = vectors[:, ::-1][:, :2]
    main = main * np.sign(main[np.abs(main).argmax(axis=0), [0, 1]])  # the sign is arbitrary
    shares = variances[::-1][:2] / variances.sum()
    first, second = (
        f"{which} principal component ({share:.0%})"
        for which, share in zip(("first", "second"), shares, strict=True)
    )
    return np.asarray(centred @ main), (first, second)


def _label(prior: Prior) -> str:
    return f"{prior.measure} ({prior.unit})" if prior.unit else prior.measure


def kept_figure(report: AdaptationReport, heading: str, theme: Theme = LIGHT) -> "Figure":
    """Plot the kept share of the performance by damage, with the champion and random gaits."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import PercentFormatter

    cases = report.cases
    after, champion, random = (
        np.array([report.kept(value) for value in values])
        for values in (
            [case.best.measured for case in cases],
            [case.champion for case in cases],
            [max(case.random) for case in cases],
        )
    )
    rows = np.arange(len(cases))
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 1.0 + 0.155 * len(cases)))
        axes = figure.subplots()
        low, high = np.minimum(champion, after), np.maximum(champion, after)
        axes.hlines(rows, low, high, color=theme.faint, linewidth=1.5, zorder=1)
        colours = theme.colours
        axes.plot(random, rows, "x", color=colours[2], markersize=3.5, label="random gaits")
        axes.plot(
            champion,
            rows,
            "o",
            color=colours[1],
            markerfacecolor=theme.background,
            markersize=5.5,
            label="champion",
        )
        axes.plot(after, rows, "o", color=colours[0], markersize=4, label="adapted")
        axes.axvline(1.0, color=theme.ink, linewidth=0.7, linestyle=":")
        axes.set_yticks(rows, [f"{case.name}  ({len(case.trials)})" for case in cases], fontsize=6)
        axes.invert_yaxis()
        axes.set_ylabel("lost legs (trials)")
        axes.set_xlabel(f"{report.measure}, share of the best on the intact body")
        axes.xaxis.set_major_formatter(PercentFormatter(1.0))
        axes.set_xlim(min(0.0, float(champion.min())) - 0.05, max(1.05, float(after.max()) + 0.05))
        handles, labels = axes.get_legend_handles_labels()
        add_heading(figure, heading, handles[::-1], labels[::-1])
    return figure


def pairs_figure(report: AdaptationReport, heading: str, theme: Theme = LIGHT) -> "Figure":
    """Plot the kept share after the loss of each pair of legs, with single legs on the diagonal."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import PercentFormatter

    legs = [case.name for case in report.cases if len(case.damage) == 1]
    place = {f"{leg} lost": index for index, leg in enumerate(legs)}
    maps = np.full((2, len(legs), len(legs)), np.nan)
    for case in report.cases:
        across, up = place[case.damage[0]], place[case.damage[-1]]
        for map, value in zip(maps, (case.champion, case.best.measured), strict=True):
            map[across, up] = map[up, across] = report.kept(value)
    with styled(theme):
        figure = Figure(figsize=(2.0 * WIDTH, 3.9))
        places = figure.subplots(1, 2)
        for axes, map, name in zip(places, maps, ("champion", "adapted"), strict=True):
            drawn = axes.imshow(map, vmin=0.0, vmax=1.0, cmap="viridis")
            axes.set_xticks(range(len(legs)), legs)
            axes.set_yticks(range(len(legs)), legs)
            axes.tick_params(length=0)
            axes.grid(visible=False)
            axes.set_title(name)
            for row, column in np.argwhere(np.isfinite(map)):
                value = map[row, column]
                axes.text(
                    column,
                    row,
                    f"{100 * value:.0f}",
                    ha="center",
                    va="center",
                    fontsize=6,
                    color="#FFFFFF" if value < 0.6 else "#1A1A1A",
                )
        bar = figure.colorbar(drawn, ax=places, location="bottom", aspect=40, shrink=0.5, pad=0.02)
        bar.outline.set_visible(False)
        bar.ax.tick_params(length=0)
        bar.ax.xaxis.set_major_formatter(PercentFormatter(1.0))
        bar.set_label(f"{report.measure}, share of the best on the intact body", fontsize=7)
        add_heading(figure, heading)
    return figure

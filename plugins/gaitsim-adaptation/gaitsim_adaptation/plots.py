"""Plot reports on the loss of legs."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.plugin.pictures import LIGHT, WIDTH, Theme, add_heading, styled
from gaitsim_adaptation.report import AdaptationReport

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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

"""Plot the importance of the options of a study: the share of the variance of each."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.render.plots.labels import add_heading, shorten
from gaitsim.render.plots.style import LIGHT, WIDTH, Theme, replace_figure, styled
from gaitsim_studies.importance import SEED, Importance
from gaitsim_studies.statistics import LEAST

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILE = "importance.png"
MOST = 16  # maximum number of bars; the others have the smallest shares


def plot_importance(folder: Path, importance: Sequence[Importance]) -> None:
    """Draw the importance of options into a folder; without shares, remove an old figure."""
    known = [one for one in importance if one.shares]
    replace_figure(folder / FILE, importance_figure(known) if known else None)


def importance_figure(importance: Sequence[Importance], theme: Theme = LIGHT) -> "Figure":
    """Draw a bar with an interval for each share, in a panel for each importance."""
    from matplotlib.figure import Figure

    shown = [[one for one in each.shares if one.options != SEED][:MOST] for each in importance]
    shown = [
        [*bars, *(one for one in each.shares if one.options == SEED)]
        for bars, each in zip(shown, importance, strict=True)
    ]
    count = sum(map(len, shown)) + 2 * len(shown)
    with styled(theme):
        figure = Figure(figsize=(1.5 * WIDTH, 0.6 + 0.19 * count))
        rows = {"height_ratios": [len(bars) + 1 for bars in shown]}
        panels = figure.subplots(len(shown), squeeze=False, gridspec_kw=rows, sharex=True).ravel()
        for axes, bars, one in zip(panels, shown, importance, strict=True):
            at = np.arange(len(bars))[::-1]
            shares = np.array([bar.share for bar in bars])
            reach = np.array([[bar.share - bar.low, bar.high - bar.share] for bar in bars]).T
            colours = [theme.faint if bar.options == SEED else theme.colours[0] for bar in bars]
            axes.barh(at, 100 * shares, height=0.65, color=colours)
            if np.isfinite(reach).all():
                axes.errorbar(
                    100 * shares,
                    at,
                    xerr=100 * np.maximum(reach, 0),
                    fmt="none",
                    ecolor=theme.ink,
                    elinewidth=0.8,
                    capsize=1.5,
                )
            axes.set_yticks(at, [shorten(bar.name, 48) for bar in bars])
            axes.grid(visible=False, axis="y")
            axes.set_xlim(0)
            if one.only:
                axes.set_title(shorten(one.only, 60))
        panels[-1].set_xlabel("share of the variance of the best scores (%)")
        repeats = importance[0].repeats
        text = f"importance of options, {repeats} repeat{'s' * (repeats > 1)} of each cell"
        add_heading(figure, f"{text}, 95 % intervals" if repeats >= LEAST else text)
    return figure

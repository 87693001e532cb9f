"""Plot the static stability margin over time."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.individual import Individual
from gaitsim.render.plots.components import finite_or_nan
from gaitsim.render.plots.data import window_slice
from gaitsim.render.plots.labels import add_heading, heading_of
from gaitsim.render.plots.panels import intervals, shade_spans
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim_plots.footfall import contacts_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MILLIMETRES = 1000.0


def stability_figure(
    individual: Individual, theme: Theme, window: tuple[float, float] | None = None
) -> "Figure":
    """Plot the margin in millimetres, shaded below zero, and the number of feet on the ground.

    `gaitsim.gait.margin_of` computes the margin.
    """
    from matplotlib.figure import Figure

    from gaitsim import gait

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
        below.set_xlim(times[0], times[-1])
        figure.align_ylabels()
        add_heading(figure, heading_of([individual]), *axes.get_legend_handles_labels())
    return figure

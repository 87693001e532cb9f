"""Plot the commands of a body that feels, the changes by its reflexes, and its yaw over time."""

from typing import TYPE_CHECKING

import numpy as np

from gaitsim.plugin import COMMAND, NothingToPlotError
from gaitsim.plugin.gait import frames_before_fall, read_values
from gaitsim.plugin.pictures import (
    WIDTH,
    Theme,
    add_heading,
    finite_or_nan,
    grid,
    heading_of,
    limit_time,
    styled,
    window_slice,
)
from gaitsim.plugin.runs import Individual

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FELT = ("command", "changed_command", "measured_orientation", "commanded_heading", "orientation")
"""Channels that the plot needs."""
UNITS = {"speed": "m/s", "turn": "°/s", "sideways": "m/s", "height": "m"}
COMMANDED, CHANGED, MEASURED, TRUE = "commanded", "with reflexes", "measured", "true"
_STYLES = {COMMANDED: 0, CHANGED: 1, MEASURED: 2, TRUE: 3}


def feedback_figure(
    individual: Individual, theme: Theme, window: tuple[float, float] | None = None
) -> "Figure":
    """Plot the command with and without the changes of reflexes, and the yaw, up to a fall.

    Walking sideways and the height have panels if they are ever commanded or changed.
    """
    require_feeling(individual)
    command, changed, measured, heading, true = (read_values(individual, name) for name in FELT)
    rate = individual.motion.frame_rate
    frames = len(heading) if window else frames_before_fall(individual)
    part = window_slice(frames, rate, window)
    panels = {
        f"{name} ({UNITS[name]})": {
            COMMANDED: command[part, column],
            CHANGED: changed[part, column],
        }
        for column, name in enumerate(COMMAND)
        if name in ("speed", "turn") or command[:, column].any() or changed[:, column].any()
    }
    panels["yaw (°)"] = {MEASURED: measured[part, 2], TRUE: true[part, 2], COMMANDED: heading[part]}
    times = np.arange(part.start, part.stop) / rate
    handles = {}
    with styled(theme):
        figure, places = grid(len(panels), WIDTH, height=0.95)
        for axes, (label, lines) in zip(places, panels.items(), strict=True):
            for name, values in lines.items():
                shown = np.degrees(values) if "°" in label else values
                [handles[name]] = axes.plot(
                    times, finite_or_nan(shown), **theme.line(_STYLES[name])
                )
            axes.set_ylabel(label)
            low, high = axes.get_ylim()
            if low < 0 < high:
                axes.axhline(0, color=theme.ink, linewidth=0.4, zorder=1)
        limit_time(places[-1], part, rate)
        places[-1].set_xlabel("time (s)")
        figure.align_ylabels()
        add_heading(figure, heading_of([individual]), [*handles.values()], [*handles])
    return figure


def require_feeling(individual: Individual) -> None:
    """Check that the body feels or is driven: it has the channels of commands and measurements."""
    channels = individual.experiment.organism.channels
    missing = [name for name in FELT if name not in channels]
    if missing:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} neither feels nor is driven: it has no "
            f"channel {missing[0]!r}",
            where=str(individual.source),
            allowed="a body with reflexes or a drive, such as the robot with the option 'reflexes'",
        )

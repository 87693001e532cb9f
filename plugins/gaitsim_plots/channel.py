"""Plot any channel of the motion over time, for one champion or for several generations."""

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.plugin import GaitsimError, NothingToPlotError
from gaitsim.plugin.pictures import (
    WIDTH,
    Line,
    Signal,
    Theme,
    add_heading,
    draw_bars,
    finite_or_nan,
    grid,
    heading_of,
    limit_constant,
    limit_time,
    lines_of,
    read_signal,
    shorten,
    shown_unit,
    styled,
    window_slice,
)
from gaitsim.plugin.runs import Individual

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Channels to draw by default, in order of preference; those in `KINDS_OF_CHANNELS` have their own
# kind of plot.
DEFAULT_CHANNELS = ("altitude", "pose", "height")
KINDS_OF_CHANNELS = {"margin": "stability", "joint_angles": "joints"}
_JOINT_SECONDS = 2.0  # default seconds of channels of joints; more would be illegible
_MAX_LINES = 8  # maximum number of distinguishable lines in a panel
_MAX_PANELS = 24  # maximum number of panels on a page


def channel_figure(
    individuals: Sequence[Individual],
    theme: Theme,
    channel: str | None = None,
    components: Sequence[str] = (),
    window: tuple[float, float] | None = None,
) -> "Figure":
    """Plot the components of a channel over time, with a line for each generation."""
    if len(individuals) > _MAX_LINES:
        raise GaitsimError(
            f"too many generations to plot: {len(individuals)}",
            allowed=f"at most {_MAX_LINES}",
        )
    name = channel or default_channel(individuals[0])
    signals = [read_signal(individual, name) for individual in individuals]
    lines = [lines_of(signal, components) for signal in signals]
    default = _JOINT_SECONDS if "joints" in signals[0].channel.axes else None
    parts = [window_slice(len(signal.values), signal.rate, window, default) for signal in signals]
    with styled(theme):
        if len(signals) == 1 and signals[0].values.dtype.kind == "b":
            figure = _draw_truth_values(signals[0], lines[0], parts[0], theme)
            add_heading(figure, heading_of(individuals))
            return figure
        return _draw_lines(individuals, theme, signals, lines, parts)


def default_channel(individual: Individual) -> str:
    """Return the channel that is drawn by default."""
    timed = [
        name
        for name, channel in individual.experiment.organism.channels.items()
        if channel.over_time
    ]
    if not timed:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} has no channel over time",
            where=str(individual.source),
            allowed="a channel with the axes (population, frames, …)",
        )
    return next(
        (
            name
            for name in (*DEFAULT_CHANNELS, *timed)
            if name in timed and name not in KINDS_OF_CHANNELS
        ),
        timed[0],
    )


def check_default_channel(individual: Individual) -> None:
    """Check that no other kind of plot draws the default channel."""
    name = default_channel(individual)
    if name in KINDS_OF_CHANNELS:
        raise NothingToPlotError(
            f"{KINDS_OF_CHANNELS[name]!r} draws the channel {name!r}; choose a different channel "
            "with --channel"
        )


def _draw_truth_values(
    signal: Signal, lines: Sequence[Line], part: slice, theme: Theme
) -> "Figure":
    """Draw a row for each component, with bars while it is true."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, 0.8 + 0.17 * max(3, len(lines))))
    axes = figure.subplots()
    rows = [(shorten(line.name, 16), line.values[part]) for line in lines]
    draw_bars(axes, rows, part.start / signal.rate, signal.rate, [theme.ink] * len(rows))
    axes.set_xlabel("time (s)")
    axes.set_ylabel(shorten(signal.name, 30))
    return figure


def _draw_lines(
    individuals: Sequence[Individual],
    theme: Theme,
    signals: Sequence[Signal],
    lines: Sequence[Sequence[Line]],
    parts: Sequence[slice],
) -> "Figure":
    """Draw lines in panels; with several generations, one panel per component."""
    signal, several = signals[0], len(signals) > 1
    panels = _panels(signal, lines[0], several)
    if len(panels) > _MAX_PANELS:
        raise GaitsimError(
            f"too many components of the channel {signal.name!r} to plot: {len(panels)}",
            allowed=f"at most {_MAX_PANELS}",
            remedy=f"choose some of them, such as --component '{signal.entries[0][0]}'",
        )
    columns = 1 if len(panels) <= 3 else 2 if len(panels) <= 8 else 3
    height = {1: 1.7, 2: 1.2, 3: 1.0}.get(len(panels), 0.75)
    figure, places = grid(len(panels), WIDTH, columns=columns, height=height)
    for axes, (title, indices) in zip(places, panels.items(), strict=True):
        drawn = [*product(range(len(signals)), indices)]
        values = [finite_or_nan(lines[which][i].values[parts[which]]) for which, i in drawn]
        everything = np.concatenate(values)
        factor, unit = shown_unit(lines[0][indices[0]].unit, everything if columns == 1 else None)
        limit_constant(axes, everything)
        for index, ((which, i), shown) in enumerate(zip(drawn, values, strict=True)):
            line, part = lines[which][i], parts[which]
            generation = individuals[which].label
            label = generation if several else _name_in_panel(line, title)
            times = np.arange(part.start, part.stop) / signals[which].rate
            axes.plot(times, factor * shown, label=label, **theme.line(index))
        if columns == 1:
            axes.set_ylabel(_label(signal.name, title, [unit], len(panels) > 1))
        elif title:
            axes.set_title(shorten(title, 24), fontsize=7, pad=2)
        low, high = axes.get_ylim()
        if low < 0 < high:
            axes.axhline(0, color=theme.ink, linewidth=0.4, zorder=1)
        first, last = min(part.start for part in parts), max(part.stop for part in parts)
        limit_time(axes, slice(first, last), signal.rate)
    figure.supxlabel("time (s)", fontsize=8)
    if columns > 1:
        figure.supylabel(
            _label(signal.name, "", [shown_unit(line.unit)[1] for line in lines[0]], False),
            fontsize=8,
        )
    handles, labels = places[0].get_legend_handles_labels()
    single = len(labels) == 1 and not several
    text = heading_of(individuals)
    add_heading(figure, text, *(() if single else (handles, labels)))
    return figure


def _panels(signal: Signal, lines: Sequence[Line], several: bool) -> dict[str, list[int]]:
    """Return the indices of the lines of each panel, by the panel's title.

    Components with different units or directions, such as x, y and z, have separate panels.
    """
    differ = isinstance(signal.channel.unit, tuple)
    directions = differ or (bool(signal.entries) and signal.entries[-1][0] == "x")
    if several or (len(lines) > _MAX_LINES and not directions):
        return {line.name: [index] for index, line in enumerate(lines)}
    if not directions:
        return {lines[0].name if len(lines) == 1 else "": [*range(len(lines))]}
    panels: dict[str, list[int]] = {}
    for index, line in enumerate(lines):
        panels.setdefault(line.names[-1], []).append(index)
    if max(map(len, panels.values())) > _MAX_LINES:
        return {line.name: [index] for index, line in enumerate(lines)}
    return panels


def _name_in_panel(line: Line, title: str) -> str:
    """Return the part of a line's name that is not in the title of its panel."""
    if line.name == title:
        return line.name
    return " ".join(line.names[:-1] if title and line.names[-1] == title else line.names)


def _label(channel: str, title: str, units: Sequence[str], several: bool) -> str:
    """Return the label of an axis, with units."""
    # 'x' is clear enough for a position, but not for a velocity.
    place = several and channel in ("pose", "position")
    name = title if place else f"{channel} {title}".strip()
    unit = ", ".join(filter(None, dict.fromkeys(units)))
    text = shorten(name.replace("_", " "), 24)
    return f"{text}{chr(10) if several and not place else ' '}({unit})" if unit else text

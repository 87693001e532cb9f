"""Plot joint angles, or another channel of the joints, over time, with a panel for each leg."""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.plugin import GaitsimError, NothingToPlotError
from gaitsim.plugin.gait import Floats, frames_before_fall, read_values
from gaitsim.plugin.pictures import (
    MIDDLE,
    WIDTH,
    Signal,
    Theme,
    add_heading,
    finite_or_nan,
    grid,
    heading_of,
    intervals,
    limit_time,
    read_signal,
    shade_spans,
    shorten,
    shown_unit,
    sides,
    styled,
    window_slice,
)
from gaitsim.plugin.runs import Individual

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEFAULT_SECONDS = 2.0  # seconds; more would be illegible in a column's width
_NEAR_STALL = (
    0.4  # share of the stall torque that torques must reach for a line at the stall torque
)
_MAX_UNGROUPED = 6  # maximum number of joints without legs in one panel
_WIDTHS = 1.8, 1.2, 0.7  # points; wide first lines remain visible below later lines


def joints_figure(
    individual: Individual,
    theme: Theme,
    window: tuple[float, float] | None = None,
    channel: str | None = None,
) -> "Figure":
    """Plot a channel of the joints, by default the angles, shaded while the foot is in stance.

    Angles are in degrees, and lengths of joints that slide in millimetres. If torques come near the
    stall torque, a line marks it.
    """
    require_joints(individual)
    signal = _signal_of(individual, channel or "joint_angles")
    frames = len(signal.values) if window else frames_before_fall(individual)
    part = window_slice(frames, signal.rate, window, DEFAULT_SECONDS)
    values = finite_or_nan(signal.values[part])
    factor, unit = shown_unit(signal.channel.units)
    slides = [
        name in individual.experiment.organism.sliding_joints() for name in signal.entries[-1]
    ]
    per_slide = unit.replace("°", "mm").replace("N m", "N")
    values *= np.where(slides, 1000 if "mm" in per_slide else 1, factor)
    times = np.arange(part.start, part.stop) / signal.rate
    names = signal.entries[-1]
    feet = dict(zip(individual.skeleton.contact_names, _touching(individual, part), strict=False))
    legs = legs_of(names, tuple(feet))
    with styled(theme):
        halves, turns = _side_order([*legs])
        figure, panels = grid(
            len(legs),
            WIDTH,
            columns=2 if halves or turns or len(legs) == 4 else min(3, len(legs)),
            height=0.72 if len(legs) > 2 else 1.6,
            downwards=halves,
            share_y=True,
        )
        for axes, (leg, joints) in zip(panels, legs.items(), strict=True):
            for index, (joint, column) in enumerate(joints.items()):
                width = _WIDTHS[min(index, len(_WIDTHS) - 1)]
                line = {**theme.line(index), "linewidth": width}
                label = f"{joint} ({per_slide})" if slides[column] else joint
                axes.plot(times, values[:, column], label=label, **line)
            if leg in feet:
                shade_spans(axes, intervals(feet[leg], times[0], signal.rate), theme)
            axes.set_title(shorten(leg, 24), fontsize=7, pad=2)
            limit_time(axes, part, signal.rate)
        if values.min() < 0 < values.max():
            for axes in panels:
                axes.axhline(0, color=theme.ink, linewidth=0.4, zorder=1)
        figure.supxlabel("time (s)", fontsize=8)
        name = "joint angle" if signal.name == "joint_angles" else signal.name.replace("_", " ")
        figure.supylabel(f"{shorten(name, 24)} ({unit})" if unit else name, fontsize=8)
        handles, labels = panels[0].get_legend_handles_labels()
        if feet.keys() & legs.keys():
            from matplotlib.patches import Patch

            handles.append(Patch(facecolor=theme.faint, alpha=0.5))
            labels.append("stance")
        stall = _stall_torque(individual, signal.name, values)
        if stall is not None:
            limits = [axes.axhline(stall, color=theme.ink, linewidth=0.8) for axes in panels]
            handles.append(limits[0])
            labels.append("stall")
        one = len(legs) == len(names) > 1 or labels == [""]
        add_heading(figure, heading_of([individual]), *(() if one else (handles, labels)))
    return figure


def _signal_of(individual: Individual, name: str) -> Signal:
    """Return a channel that has a value for each joint and frame."""
    signal = read_signal(individual, name)
    if signal.channel.axes != ("frames", "joints"):
        channels = individual.experiment.organism.channels
        raise GaitsimError(
            f"the channel {name!r} does not have the axes (frames, joints)",
            allowed=", ".join(
                other for other, channel in channels.items() if channel.axes == ("frames", "joints")
            ),
            remedy=f"--kind channel --channel {name}",
        )
    return signal


def _stall_torque(individual: Individual, name: str, values: Floats) -> float | None:
    """Return the stall torque; None unless all servos have the same one and torques are near it."""
    if name != "torque" or "stall_torque" not in individual.experiment.organism.channels:
        return None
    stall = np.asarray(read_values(individual, "stall_torque"), np.float64)
    least, most = float(stall.min()), float(stall.max())
    return most if least == most and 0 < most <= values.max() / _NEAR_STALL else None


def require_joints(individual: Individual) -> None:
    """Check that the body has joint angles."""
    if "joint_angles" not in individual.experiment.organism.channels:
        raise NothingToPlotError(
            f"{individual.experiment.entries['organism']} has no joint angles to plot",
            where=str(individual.source),
            allowed="a body with the channel 'joint_angles'",
            remedy="plot a different channel with --kind channel",
        )


def legs_of(names: Sequence[str], feet: Sequence[str] = ()) -> dict[str, dict[str, int]]:
    """Group joints by leg: 'L1 coxa', 'L1 femur' … as {'L1': {'coxa': 0, …}, …}.

    Other names, such as 'FL_hip_joint', are grouped if they are listed foot by foot and differ
    between the feet only in their words for the leg. Joints that cannot be grouped share a panel
    if they are few; otherwise each joint has its own panel.
    """
    split = [name.rpartition(" ")[::2] for name in names]
    legs: dict[str, dict[str, int]] = {}
    for column, (leg, joint) in enumerate(split):
        legs.setdefault(leg, {})[joint] = column
    whole = sum(map(len, legs.values())) == len(names)
    if len({tuple(joints) for joints in legs.values()}) == 1 and "" not in legs and whole:
        return legs
    by_foot = _group_by_foot(names, feet)
    if by_foot:
        return by_foot
    if len(names) <= _MAX_UNGROUPED:
        return {"": {name: column for column, name in enumerate(names)}}
    return {name: {"": column} for column, name in enumerate(names)}


def _group_by_foot(names: Sequence[str], feet: Sequence[str]) -> dict[str, dict[str, int]]:
    """Group joints into equal parts, one for each foot; {} if their names do not match."""
    if len(feet) < 2 or len(names) % len(feet):
        return {}
    words = [re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[^\W\d_A-Z]+|\d+", name) for name in names]
    each = len(names) // len(feet)
    chunks = [words[first : first + each] for first in range(0, len(words), each)]
    common = [set[str].intersection(*map(set, chunk)) for chunk in chunks]
    everywhere = set[str].intersection(*common)
    joints = [
        tuple(" ".join(word for word in name if word not in own - everywhere) for name in chunk)
        for own, chunk in zip(common, chunks, strict=True)
    ]
    apart = len({frozenset(own) for own in common}) == len(feet)
    # Names ordered by joint, hips of all feet before all knees, would also differ in one word.
    by_joint = bool((sides(joints[0]) != MIDDLE).any())
    if not apart or by_joint or len({*joints}) > 1 or len({*joints[0]}) < each:
        return {}
    return {
        foot: {joint: place * each + column for column, joint in enumerate(joints[0])}
        for place, foot in enumerate(feet)
    }


def _side_order(legs: Sequence[str]) -> tuple[bool, bool]:
    """Return whether all left legs precede all right legs, and whether left and right alternate."""
    first, half = [leg[:1] for leg in legs], len(legs) // 2
    return (
        half > 0 and first == ["L"] * half + ["R"] * half,
        half > 0 and first == ["L", "R"] * half,
    )


def _touching(individual: Individual, part: slice) -> Sequence[np.ndarray]:
    return () if individual.stance is None else [*np.asarray(individual.stance[part], bool).T]

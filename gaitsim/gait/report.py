"""Analyse a gait from a skeleton."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from gaitsim.contracts import Array, Motion, Organism, Skeleton
from gaitsim.effort import Effort, channel_of, effort_of, gait_warnings
from gaitsim.errors import GaitsimError
from gaitsim.gait import naming
from gaitsim.gait.channels import count_trials
from gaitsim.gait.feet import (
    Contacts,
    Floats,
    Foot,
    Stride,
    body_order,
    feet_of,
    in_body_frame,
    phases_of,
)
from gaitsim.gait.naming import Flag, Name, name_of
from gaitsim.gait.travel import (
    NONE,
    Slip,
    Travel,
    frames_in,
    heading,
    lying,
    size,
    slip_of,
    stability_margin,
    travel_of,
    trunk,
)
from gaitsim.individual import Individual, Measurement
from gaitsim.legged.stepping import STRIDE_FREQUENCY
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.repr_mixin import TableMixin


@dataclass(frozen=True, eq=False)
class Footfalls:
    """The footfalls of the feet, from left to right and front to back.

    Attributes:
        feet: steps of each foot.
        touching: whether each foot is on the ground until the next frame, (frames, feet), up to a
            fall.
        stride: common stride of the feet; None if the contacts are not periodic.
        phases: phase of each foot's touch-down relative to the first foot that steps, (feet,),
            cycles from 0 to 1; NaN for feet that do not step, and without a stride.
        consistency: consistency of the phases, (feet,), from 0 (random) to 1 (equal in all
            strides).
        margin: static stability margin, (frames,), metres, up to a fall.
        slip: slip of the feet that stand.
        lying: share of the time during which the trunk is on the ground.
    """

    feet: tuple[Foot, ...]
    touching: Contacts
    stride: Stride | None
    phases: Floats
    consistency: Floats
    margin: Floats
    slip: Slip
    lying: float


@dataclass(frozen=True, eq=False, repr=False)
class GaitAnalysis(TableMixin):
    """The analysis of a gait.

    Attributes:
        frame_rate: frames per second, Hz.
        travel: travel of the body; the mean over the trials, if there are several.
        footfalls: footfalls of the feet; None for a body without feet.
        name: name of the gait.
        distances: rms distance to each reference gait, cycles; {} if the gait was not compared.
        flags: signs of exploits.
        missing: results that are not available, with reasons.
        effort: torque of the servos; None if the body does not measure it.
        warnings: sentences about chatter, servos that overheat, and warnings of the body.
        trials: number of trials; everything except the travel is of the first.
    """

    frame_rate: float
    travel: Travel
    footfalls: Footfalls | None
    name: Name
    distances: Mapping[str, float]
    flags: tuple[Flag, ...]
    missing: tuple[str, ...]
    effort: Effort | None = None
    warnings: tuple[str, ...] = ()
    trials: int = 1

    def _repr_title(self) -> str:
        return f"Gait: {self.name.name}, {self.name.reason}"

    def _repr_rows(self) -> list[dict[str, object]]:
        return [
            {"quantity": name, "value": one.value, "unit": one.unit, "meaning": one.help}
            for name, one in quantities(self).items()
        ]


def analyse_gait(
    skeleton: Skeleton,
    joint_angles: Array | None = None,
    *,
    dynamic: bool = False,
    margin: Floats | None = None,
    measured: Mapping[str, float] = NONE,
    carried: Floats | None = None,
    stride_frequency: float = 0.0,
    effort: Effort | None = None,
) -> GaitAnalysis:
    """Analyse one individual's gait.

    Args:
        skeleton: geometry of the body over time.
        joint_angles: joint angles, (frames, joints), radians, for the joint travel; None omits it.
        dynamic: whether the body is simulated with forces, so that it can fall.
        margin: static stability margin from the body, (frames,), metres; None computes it from the
            skeleton.
        measured: quantities that the body measured, in SI units by name. `forward`, `lateral`,
            `climb`, `yaw` and `slip ratio` replace values computed from the skeleton. `cost of
            transport` and `lasted`, the time before a fall, are not available from a skeleton.
        carried: share of the weight that the feet carry, (frames,), for a body in physics.
        stride_frequency: stride frequency that the gait commands, Hz; 0 if unknown.
        effort: torque of the servos, if the body measures it.
    """
    path, turned = skeleton.path.astype(np.float64), heading(trunk(skeleton))
    travel = travel_of(skeleton, joint_angles, measured)
    length = size(skeleton)
    if skeleton.contacts is None or skeleton.touching is None or not skeleton.contacts.shape[1]:
        found = None
        # Flip-flop is only meaningful for joints that are commanded in every frame.
        if joint_angles is not None:
            ends = in_body_frame(skeleton.segments[:, :, 1].astype(np.float64), path, turned)
            found = naming.flip_flop(ends, skeleton.names, length, skeleton.frame_rate)
        return GaitAnalysis(
            skeleton.frame_rate,
            travel,
            None,
            Name("none", "the body has no feet"),
            {},
            (found,) if found else (),
            ("footfalls, phases, stability margin and slip: this body's skeleton has no contacts",),
        )
    relative = relative_feet(skeleton)
    order = body_order(relative)
    relative, contacts = relative[:, order], skeleton.contacts[:, order].astype(np.float64)
    upright = slice(None)
    if travel.lasted is not None:
        upright = slice(frames_in(travel.lasted, skeleton.frame_rate))
    touching = skeleton.touching[upright, order]
    unordered = skeleton.contact_names or tuple(f"foot {n + 1}" for n in range(len(order)))
    names = tuple(unordered[index] for index in order)
    feet, stride = feet_of(
        touching, names, skeleton.frame_rate, dynamic=dynamic, commanded=stride_frequency
    )
    phases = consistency = np.full(len(feet), np.nan)
    if stride is not None:
        phases, consistency = phases_of(feet, stride)
    lying_share = lying(skeleton)
    footfalls = Footfalls(
        feet,
        touching,
        stride,
        phases,
        consistency,
        (stability_margin(skeleton) if margin is None else margin)[upright],
        slip_of(
            contacts[upright],
            touching,
            path[upright],
            relative[upright],
            measured.get("slip ratio"),
        ),
        lying_share,
    )
    still = stands(skeleton, upright)
    name, distances = name_of(feet, stride, phases, consistency, relative, still)
    flags = (
        naming.flip_flop(relative, names, length, skeleton.frame_rate),
        naming.flickering(touching, names, skeleton.frame_rate),
        naming.sliding(footfalls.slip),
        None if dynamic else naming.unsupported(footfalls.margin, path, lying_share),
        naming.leap(touching, path[upright], length, skeleton.frame_rate) if dynamic else None,
        None if carried is None else naming.not_on_feet(carried[upright]),
    )
    missing = () if joint_angles is not None else ("joint travel: the body has no joint angles",)
    warnings = (naming.chatter(feet) if dynamic else "", effort.warning if effort else "")
    return GaitAnalysis(
        skeleton.frame_rate,
        travel,
        footfalls,
        name,
        distances,
        tuple(flag for flag in flags if flag),
        missing,
        effort,
        tuple(filter(None, warnings)),
    )


def relative_feet(skeleton: Skeleton) -> Floats:
    """Return the feet relative to the body's position and heading, (frames, feet, 3), metres."""
    if skeleton.contacts is None:
        raise ValueError("the skeleton has no contacts")
    feet, path = (points.astype(np.float64) for points in (skeleton.contacts, skeleton.path))
    return in_body_frame(feet, path, heading(trunk(skeleton)))


def stands(skeleton: Skeleton, upright: slice) -> bool:
    """Return whether the feet do not move relative to the body in the frames before a fall."""
    moved = np.abs(np.diff(relative_feet(skeleton)[upright], axis=0)).mean()
    return bool(moved < naming.STILL * size(skeleton))


_SI = {"": 1.0, "s": 1.0, "m": 1.0, "mm": 1e-3, "rad": 1.0, "°": math.radians(1)}


def analyse_individual(individual: Individual) -> GaitAnalysis:
    """Analyse the gait of an individual; the body's own measures take precedence."""
    organism, angles = individual.body, individual.joint_angles
    if angles is not None and (slides := organism.sliding_joints()):  # which do not turn
        angles = angles[:, [name not in slides for name in organism.joint_names()]]
    found = analyse_gait(
        replace(individual.skeleton, touching=individual.stance),
        angles,
        dynamic=organism.dynamic,
        margin=_own_margin(individual),
        measured=_measured(individual),
        carried=_carried(individual),
        stride_frequency=commanded_frequency(individual),
        effort=effort_of(individual),
    )
    return replace(
        found,
        travel=_mean_travel(individual, found.travel),
        warnings=(*found.warnings, *gait_warnings(individual)),
        trials=count_trials(individual),
    )


def _mean_travel(individual: Individual, first: Travel) -> Travel:
    """Return the mean of the travel over the trials, given the travel of the first."""
    travels = [
        travel_of(skeleton, None, _measured(individual)) for skeleton in trial_skeletons(individual)
    ]
    if len(travels) == 1:
        return first
    values = {
        field.name: [getattr(travel, field.name) for travel in travels] for field in fields(Travel)
    }
    means: dict[str, Any] = {
        name: None if None in each else float(np.mean(each)) for name, each in values.items()
    }
    return Travel(**means | {"joint_travel": first.joint_travel})


def trial_skeletons(individual: Individual) -> list[Skeleton]:
    """Return the skeleton of each trial of an individual."""
    organism, motion = individual.body, individual.motion
    axes = {
        name: 1 + channel.axes.index("trials")
        for name, channel in organism.channels.items()
        if "trials" in channel.axes
    }
    if count_trials(individual) == 1:
        return [individual.skeleton]
    skeletons = []
    with plugin_errors(individual.experiment.entries["organism"], "drawing the trials"):
        for trial in range(count_trials(individual)):
            channels = {
                name: np.take(motion[name], [trial], axes[name]) if name in axes else motion[name]
                for name in organism.channels
            }
            skeletons.append(organism.skeleton(Motion(motion.frame_rate, channels), 0))
    return skeletons


def vertical_loads(individual: Individual) -> Floats | None:
    """Return the vertical force of the ground on each foot, (frames, feet) N.

    Return None if the body has no channel `load` over frames and feet with a component z.
    """
    channel = individual.body.channels.get("load")
    if channel is None or channel.axes[:2] != ("frames", "feet") or "z" not in channel.axes[-1]:
        return None
    values = channel_of(individual, "load")
    return values[..., channel.axes[-1].index("z")]


def weight_of(individual: Individual) -> float | None:
    """Return the weight of the body, N; None if it has no channel `weight` with a single value."""
    channel = individual.body.channels.get("weight")
    return float(channel_of(individual, "weight")) if channel and channel.axes == () else None


def commanded_frequency(individual: Individual) -> float:
    """Return the stride frequency that the gait commands, Hz; 0 if unknown."""
    known = commands_frequency(individual.body)
    return float(channel_of(individual, STRIDE_FREQUENCY)) if known else 0.0


def commands_frequency(organism: Organism) -> bool:
    """Return whether the motion of a body has the stride frequency that its gait commands."""
    channel = organism.channels.get(STRIDE_FREQUENCY)
    return channel is not None and channel.axes == () and channel.unit == "Hz"


def frames_before_fall(individual: Individual) -> int:
    """Return the number of frames before a fall, from the channel `lasted`, or all frames."""
    frames = len(individual.skeleton.segments)
    channel = individual.body.channels.get("lasted")
    if channel is None or channel.axes or channel.unit != "s":
        return frames
    lasted = float(channel_of(individual, "lasted"))
    return min(frames, frames_in(lasted, individual.skeleton.frame_rate))


def _carried(individual: Individual) -> Floats | None:
    """Return the share of the weight that the feet carry, (frames,)."""
    loads, weight = vertical_loads(individual), weight_of(individual)
    return loads.sum(axis=1) / weight if loads is not None and weight else None


def margin_of(individual: Individual) -> Floats:
    """Return the static stability margin, (frames,), metres; −inf without a foot on the ground.

    The channel `margin` of the body, if it has one, takes precedence over its skeleton.
    """
    own = _own_margin(individual)
    return stability_margin(individual.skeleton) if own is None else own


def _own_margin(individual: Individual) -> Floats | None:
    channel = individual.body.channels.get("margin")
    if channel is None or channel.axes != ("frames",):
        return None
    margin = channel_of(individual, "margin")
    expected = (len(individual.skeleton.segments),)
    if margin.shape != expected:
        entry = individual.experiment.entries["organism"]
        raise contract_error(
            entry,
            f"returned the channel 'margin' with the shape (1, {len(margin)})",
            f"(1, {expected[0]})",
        )
    return margin


def _measured(individual: Individual) -> dict[str, float]:
    """Return the finite measures of the body in SI units, by name; {} if measuring fails."""
    try:
        found = individual.measurements
    except GaitsimError:
        return {}
    return {
        name: one.value * _SI[one.unit]
        for name, one in found.items()
        if one.unit in _SI and math.isfinite(one.value)
    }


SCALES = {"°": math.degrees(1), "mm": 1000.0, "%": 100.0}  # from SI units


def quantities(gait: GaitAnalysis) -> dict[str, Measurement]:
    """Return the quantities that `gaitsim analyse` prints, by name; NaN if not defined."""
    travel, feet = gait.travel, gait.footfalls
    rows: list[tuple[str, float | None, str, str]] = [
        ("speed", travel.speed, "m/s", f"displacement over {travel.seconds:.2f} s"),
        ("forward", travel.forward, "m", "displacement along x"),
        ("lateral", travel.lateral, "m", "displacement to the left"),
    ]
    if feet is None:
        rows.append(("climb", travel.climb, "m", "displacement upwards"))
    rows += [
        ("deviation", travel.deviation, "m", "greatest distance from the starting line"),
        ("straightness", travel.straightness, "", "displacement over length of path"),
        ("yaw", travel.yaw, "°", "turn to the left at the end"),
        ("yaw range", travel.yaw_range, "°", "angle between the extreme headings"),
    ]
    if feet is not None:
        rows += [
            ("Froude number", travel.froude, "", "speed² / (g · height of the centre)"),
            ("slip ratio", feet.slip.ratio, "", "slide of standing feet over length of path"),
            ("least margin", feet.margin.min(), "mm", "static stability, minimum over time"),
            (
                "median margin",
                float(np.median(feet.margin)),
                "mm",
                "static stability, median over time",
            ),
            ("unsupported", float(np.mean(feet.margin < 0)), "%", _unsupported(feet)),
        ]
    if travel.joint_travel is not None:
        rows.append(
            ("joint travel", travel.joint_travel, "rad/m", "sum of all joints; not an energy")
        )
    if travel.cost_of_transport is not None:
        cost = travel.cost_of_transport
        rows.append(("cost of transport", cost, "", "work over weight times displacement"))
    if travel.lasted is not None:
        rows.append(("lasted", travel.lasted, "s", "time before a fall, or the whole motion"))
    if gait.effort is not None:
        effort = gait.effort
        rows += [
            ("peak torque", effort.peak.max(), "", effort.peak_in_words),
            ("RMS torque", effort.rms.max(), "", effort.rms_in_words),
        ]
    return {
        name: Measurement(
            math.nan if value is None else float(value) * SCALES.get(unit, 1.0), unit, meaning
        )
        for name, value, unit, meaning in rows
    }


def _unsupported(found: Footfalls) -> str:
    if found.lying > 0:
        return f"by the feet; the trunk lies on the ground {100 * found.lying:.0f} % of the time"
    return "share of the time with the centre outside the support"

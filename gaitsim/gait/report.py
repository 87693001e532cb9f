"""Analyse a gait from a skeleton."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gaitsim.contracts import Array, Skeleton
from gaitsim.gait import exploits
from gaitsim.gait.contact import Contacts, Foot, Stride, feet_of
from gaitsim.gait.exploits import Flag
from gaitsim.gait.intervals import Floats
from gaitsim.gait.layout import body_order, in_body_frame
from gaitsim.gait.naming import Name, name_of
from gaitsim.gait.phases import phases_of
from gaitsim.gait.support import stability_margin
from gaitsim.gait.travel import NONE, Slip, Travel, frames_in, lying, slip_of, travel_of
from gaitsim.gait.trunk import heading, size, trunk


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


@dataclass(frozen=True, eq=False)
class GaitAnalysis:
    """The analysis of a gait.

    Attributes:
        frame_rate: frames per second, Hz.
        travel: travel of the body.
        footfalls: footfalls of the feet; None for a body without feet.
        name: name of the gait.
        distances: rms distance to each reference gait, cycles; {} if the gait was not compared.
        flags: signs of exploits.
        missing: results that are not available, with reasons.
    """

    frame_rate: float
    travel: Travel
    footfalls: Footfalls | None
    name: Name
    distances: Mapping[str, float]
    flags: tuple[Flag, ...]
    missing: tuple[str, ...]


def analyse_gait(
    skeleton: Skeleton,
    joint_angles: Array | None = None,
    *,
    dynamic: bool = False,
    margin: Floats | None = None,
    measured: Mapping[str, float] = NONE,
    carried: Floats | None = None,
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
    """
    path, turned = skeleton.path.astype(np.float64), heading(trunk(skeleton))
    travel = travel_of(skeleton, joint_angles, measured)
    length = size(skeleton)
    if skeleton.contacts is None or skeleton.touching is None or not skeleton.contacts.shape[1]:
        found = None
        # Flip-flop is only meaningful for joints that are commanded in every frame.
        if joint_angles is not None:
            ends = in_body_frame(skeleton.segments[:, :, 1].astype(np.float64), path, turned)
            found = exploits.flip_flop(ends, skeleton.names, length, skeleton.frame_rate)
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
    feet, stride = feet_of(touching, names, skeleton.frame_rate)
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
        exploits.flip_flop(relative, names, length, skeleton.frame_rate),
        exploits.flickering(touching, names, skeleton.frame_rate),
        exploits.sliding(footfalls.slip),
        None if dynamic else exploits.unsupported(footfalls.margin, path, lying_share),
        exploits.leap(touching, path[upright], length, skeleton.frame_rate) if dynamic else None,
        None if carried is None else exploits.not_on_feet(carried[upright]),
    )
    missing = () if joint_angles is not None else ("joint travel: the body has no joint angles",)
    return GaitAnalysis(
        skeleton.frame_rate,
        travel,
        footfalls,
        name,
        distances,
        tuple(flag for flag in flags if flag),
        missing,
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
    return bool(moved < exploits.STILL * size(skeleton))

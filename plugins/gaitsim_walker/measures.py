"""Measures that describe a walk, and the walker as segments to draw."""

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from gaitsim.plugin import Array, Measure, Motion, Skeleton
from gaitsim.plugin.toolkit import BODY_HEIGHT, STRIDE_FREQUENCY, stepping_measures
from gaitsim_walker import body
from gaitsim_walker.body import Floats, WalkerPlan
from gaitsim_walker.surroundings import Surroundings


def measures(motion: Motion, plan: WalkerPlan) -> Mapping[str, Measure]:
    """Return distance, duration, steadiness, effort, slip and steps.

    Means over time end at the fall.
    """
    forward = motion["torso"][:, -1, 0] - motion["torso"][:, 0, 0]
    lasted, energy = motion["lasted"], motion["energy"][:, -1]
    path = np.abs(np.diff(motion["torso"][..., 0], axis=1)).sum(axis=1)
    pitch = np.degrees(motion["pitch"])
    upright = np.round(lasted * motion.frame_rate).astype(np.intp) + 1
    return {
        "forward": Measure(forward, "m", "displacement of the torso"),
        "body lengths": Measure(
            forward / motion["length"], "", "forward displacement in lengths of the torso"
        ),
        "lasted": Measure(lasted, "s", "time until the fall, or the length of the rollout"),
        "cost of transport": Measure(
            _ratio(energy, motion["weight"] * np.abs(forward)),
            "",
            "work divided by weight times displacement",
        ),
        "pitch range": Measure(np.ptp(pitch, axis=1), "°", "range of the torso's pitch"),
        BODY_HEIGHT: Measure(
            partial(_height, motion["height"], upright),
            "m",
            "mean height of the torso's middle above the ground",
        ),
        "slip ratio": Measure(
            _ratio(motion["slip"].sum(axis=1), path),
            "",
            "slide of the stance feet divided by the torso's path",
        ),
        **stepping_measures(
            motion["stance"],
            [leg.name for leg in plan.legs],
            motion.frame_rate,
            sides=plan.sides,
            upright=upright,
            commanded=motion[STRIDE_FREQUENCY],
        ),
    }


def _height(height: Array, upright: Array) -> Array:
    counted = np.arange(height.shape[1]) < upright[:, None]
    mean: Array = np.where(counted, height, 0.0).sum(axis=1) / upright
    return mean


def _ratio(part: Array, whole: Array) -> Array:
    """Return part / whole; infinite for a whole of 0."""
    ratio: Array = np.divide(part, whole, out=np.full(len(part), math.inf), where=whole > 0)
    return ratio


def skeleton(surroundings: Surroundings, motion: Motion, individual: int) -> Skeleton:
    """Return the outline of the torso, and thigh and shank of each leg, in the plane y = 0.

    Args:
        surroundings: body, damage and ground; the slope rotates the result, so that gravity points
            down.
        motion: motion of the population.
        individual: index of the individual to draw.
    """
    plan, ground, slope = surroundings.plan, surroundings.ground, surroundings.slope
    level = not slope and not any(ground.z)
    profile = body.to_3d(np.column_stack([ground.x, ground.z]))
    position, pitch = motion["torso"][individual], motion["pitch"][individual]
    corners = body.outline(plan)[..., [0, 2]]
    cos, sin = np.cos(pitch)[:, None, None], np.sin(pitch)[:, None, None]
    edges = np.stack(
        [
            cos * corners[..., 0] - sin * corners[..., 1],
            sin * corners[..., 0] + cos * corners[..., 1],
        ],
        axis=-1,
    )
    edges += position[:, None, None, [0, 2]]
    where = body.leg_points(plan, position[:, [0, 2]], pitch, motion["joint_positions"][individual])
    limbs = np.stack([where[:, :, :-1], where[:, :, 1:]], axis=3)
    segments = np.concatenate([edges, limbs.reshape(len(pitch), -1, 2, 2)], axis=1)
    names = [f"{leg.name} {part}" for leg in plan.legs for part in ("thigh", "shank")]
    drawn = np.repeat([True, *~surroundings.damage.lost], [4, *[2] * len(plan.legs)])
    return Skeleton(
        _rotated(body.to_3d(segments[:, drawn]), slope),
        tuple(np.array([*body.OUTLINE_NAMES, *names])[drawn].tolist()),
        motion.frame_rate,
        contacts=_rotated(motion["foot_positions"][individual], slope),
        touching=motion["stance"][individual],
        contact_names=tuple(leg.name for leg in plan.legs),
        centre=_rotated(position, slope),
        ground=None if level else _rotated(profile, slope)[:, [0, 2]],
        damaged=surroundings.damage.parts,
    )


def _rotated(points: Floats, slope: float) -> Floats:
    """Rotate points, (…, 3) m, uphill about the start by a slope in rad."""
    cos, sin = math.cos(slope), math.sin(slope)
    turned = points.copy()
    turned[..., 0] = cos * points[..., 0] - sin * points[..., 2]
    turned[..., 2] = sin * points[..., 0] + cos * points[..., 2]
    return turned

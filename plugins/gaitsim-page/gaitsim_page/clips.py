"""The motion of an individual as data for a page."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Skeleton, Solid, Terrain
from gaitsim.plugin.gait import gait_of
from gaitsim.plugin.pictures import (
    LEFT,
    MIDDLE,
    RIGHT,
    Clip,
    clip_of,
    format_score,
    is_damaged,
    mesh_of,
    sides,
)
from gaitsim.plugin.runs import Individual
from gaitsim_page.packing import MAX_STEPS, pack

STEP = 1e-5  # rounding of positions, m, and of the components of quaternions
MIN_STEPS_PER_SPAN = (
    20_000  # minimum steps in the span of a body, so that small bodies move smoothly
)
ANGLE_STEP = 1e-6  # rounding of joint angles, rad
_MERGE_DISTANCE = 0.05  # maximum distance of segment ends that are one point, in steps
_SIDES = {MIDDLE: "", LEFT: "left", RIGHT: "right"}

Json = dict[str, Any]


def clip_data(individual: Individual) -> Json:
    """Return the data of an individual for a page: its body over time, score and measures.

    Lengths are in metres and angles in radians; z is up. The data of bodies with solids omit the
    ends of segments, which are not drawn.
    """
    details = f"{individual.label}, {format_score(individual)}"
    clip = clip_of(individual, individual.name, details, individual.label)
    return {
        **body_data(clip),
        "score": finite_or_none(individual.score),
        "unit": individual.experiment.fitness.unit,
        "angles": _angles(individual),
        "terms": [
            {
                "name": name,
                "value": finite_or_none(value),
                "unit": individual.experiment.fitness.unit,
            }
            for name, value in individual.scored_terms.items()
        ],
        "measures": [
            {"name": name, "value": finite_or_none(one.value), "unit": one.unit, "help": one.help}
            for name, one in individual.measurements.items()
        ],
    }


def body_data(clip: Clip) -> Json:
    """Return the data of a body in motion, with captions, in the units of `clip_data`."""
    skeleton = clip.skeleton
    step = _step(clip)
    return {
        "title": clip.title,
        "details": clip.details,
        "tag": clip.tag,
        "frameRate": float(skeleton.frame_rate),
        "frames": len(skeleton.segments),
        "flies": clip.flies,
        "floor": clip.floor,
        "span": clip.anatomy.span,
        "mark": clip.mark,
        "said": [
            [frame, text]
            for frame, text in enumerate(clip.said)
            if not frame or text != clip.said[frame - 1]
        ],
        **(
            _segments(clip, step)
            if skeleton.poses is None
            else _solids(skeleton, skeleton.poses, step)
        ),
        "feet": _feet(skeleton, step),
        "centre": pack(skeleton.path, step),
        "ground": _ground(skeleton, step),
    }


def finite_or_none(value: float) -> float | None:
    """Return a number for JSON; None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def _step(clip: Clip) -> float:
    """Return the rounding of a clip's positions, m, which is coarser for distant positions."""
    skeleton = clip.skeleton
    found = (skeleton.segments, skeleton.path, skeleton.contacts, skeleton.poses)
    farthest = max(float(np.abs(one).max(initial=0.0)) for one in found if one is not None)
    return max(min(STEP, clip.anatomy.span / MIN_STEPS_PER_SPAN), farthest / MAX_STEPS)


def _segments(clip: Clip, step: float) -> Json:
    """Return a body of limbs, plates and hulls, with points as their corners."""
    anatomy = clip.anatomy
    places = clip.skeleton.segments.reshape(len(clip.skeleton.segments), -1, 3)
    ends, first = _merge_ends(places, _MERGE_DISTANCE * step)
    roles = np.where(anatomy.damaged, "damaged", np.where(anatomy.trunks, "trunk", "limb"))
    limbs = zip(anatomy.limbs.tolist(), anatomy.radii.tolist(), roles.tolist(), strict=True)
    plates = zip(anatomy.plates, anatomy.plate_radii, strict=True)
    return {
        "ends": ends,
        "points": pack(places[:, first], step),
        "limbs": [
            [ends[2 * segment], ends[2 * segment + 1], *radii, role]
            for segment, radii, role in limbs
        ],
        "plates": [
            {"corners": [ends[corner] for corner in plate], "half": half} for plate, half in plates
        ],
        "hulls": [
            [[ends[corner] for corner in face] for face in solid] for solid in anatomy.solids
        ],
        "solids": [],
        "poses": None,
    }


def _merge_ends(places: NDArray[Any], tolerance: float) -> tuple[list[int], list[int]]:
    """Number the ends (frames, ends, 3) of segments; ends that move together share a number.

    Returns:
        The number of each end, and the first end of each number.
    """
    numbers: list[int] = []
    first: list[int] = []
    for end in range(places.shape[1]):
        apart = np.abs(places[0, first] - places[0, end]).max(axis=1, initial=0.0)
        near = [int(one) for one in np.flatnonzero(apart <= tolerance)]
        same = (
            one for one in near if np.abs(places[:, first[one]] - places[:, end]).max() <= tolerance
        )
        found = next(same, len(first))
        numbers.append(found)
        if found == len(first):
            first.append(end)
    return numbers, first


def _solids(skeleton: Skeleton, poses: NDArray[Any], step: float) -> Json:
    """Return a body of rigid solids and their poses: position, then quaternion w, x, y, z."""
    names = tuple(solid.name for solid in skeleton.solids)
    side = [_SIDES[one] for one in sides(names).tolist()]
    damaged = is_damaged(names, skeleton.damaged).tolist()
    return {
        "ends": [],
        "points": pack(np.empty((len(skeleton.segments), 0, 3)), step),
        "limbs": [],
        "plates": [],
        "hulls": [],
        "solids": [
            {
                "name": solid.name,
                "shape": solid.shape,
                "size": list(solid.size),
                "side": own,
                "damaged": hurt,
                **_mesh(solid, step),
            }
            for solid, own, hurt in zip(skeleton.solids, side, damaged, strict=True)
        ],
        "poses": pack(poses, step),
    }


def _mesh(solid: Solid, step: float) -> Json:
    """Return the corners and triangles of a mesh's hull; empty lists for other shapes."""
    if solid.vertices is None:
        return {"vertices": [], "faces": []}
    mesh = mesh_of(solid)
    rounded = np.rint(mesh.points / step) * step
    digits = max(0, math.ceil(-math.log10(step)) + 1)
    return {
        "vertices": [[round(x, digits) for x in point] for point in rounded.tolist()],
        "faces": mesh.triangles.tolist(),
    }


def _angles(individual: Individual) -> Json | None:
    """Return the angles of joints that turn, rounded to `ANGLE_STEP`; None without joints."""
    if individual.joint_angles is None:
        return None
    gait = gait_of(individual)
    turning = [at for at, name in enumerate(gait.joint_names) if name not in gait.slides]
    names = [gait.joint_names[at] for at in turning]
    return {"names": names, "values": pack(gait.angles[:, turning], ANGLE_STEP)}


def _feet(skeleton: Skeleton, step: float) -> Json | None:
    """Return the contacts and when they touch the ground; None for a body without feet."""
    if skeleton.contacts is None or skeleton.touching is None:
        return None
    names = skeleton.contact_names or ("",) * skeleton.contacts.shape[1]
    return {
        "names": list(names),
        "sides": [_SIDES[one] for one in sides(names).tolist()],
        "points": pack(skeleton.contacts, step),
        "touching": pack(skeleton.touching, 1.0),
        "lost": is_damaged(names, skeleton.damaged).tolist(),
    }


def _ground(skeleton: Skeleton, step: float) -> Json | None:
    """Return uneven ground: a profile along x or a terrain; None for level ground at zero."""
    ground = skeleton.ground
    if ground is None:
        return None
    if isinstance(ground, Terrain):
        return {
            "corner": list(map(float, ground.corner)),
            "spacing": float(ground.spacing),
            "heights": pack(ground.heights, step),
        }
    x, z = ground.astype(np.float64).T.tolist()
    return {"x": x, "z": z}

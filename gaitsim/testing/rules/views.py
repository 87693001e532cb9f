"""Rules for the skeleton, the rig and the measures of a body, and for playing joint angles."""

from collections.abc import Iterator

import numpy as np

from gaitsim.contracts import Measure, Motion, Organism, Rig, Skeleton
from gaitsim.contracts.rig import SkeletonError
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.common import same

_LENGTHS = 1e-3  # tolerance for the lengths of a rig's segments, relative to the longest one


def check_skeleton(body: Organism, motion: Motion) -> Iterator[Finding]:
    """Check the skeletons of the first and the last individual."""
    for individual in (0, motion.population - 1):
        try:
            skeleton: object = body.skeleton(motion, individual)
        except SkeletonError as problem:
            yield error(
                "skeleton",
                "consistent shapes",
                str(problem),
                "see the docstring of gaitsim.contracts.Skeleton",
            )
            return
        if not isinstance(skeleton, Skeleton):
            yield error(
                "skeleton",
                "skeleton() returns a gaitsim.contracts.Skeleton",
                f"a {type(skeleton).__name__}",
                "",
            )
            return
        points = [skeleton.segments, skeleton.path]
        points += [more for more in (skeleton.contacts, skeleton.poses) if more is not None]
        finite = individual in motion.failures or all(np.isfinite(p).all() for p in points)
        if not (len(skeleton.segments) and skeleton.names and finite and skeleton.frame_rate > 0):
            yield error(
                "skeleton",
                "at least one frame and one segment, finite points, a frame rate above 0",
                f"{len(skeleton.segments)} frames, {len(skeleton.names)} segments, "
                f"{skeleton.frame_rate} Hz{'' if finite else ', non-finite points'}",
                "return both ends of each segment in metres, as an array (frames, segments, 2, 3)",
            )
            return
        if skeleton.poses is not None and individual not in motion.failures:
            lengths = np.linalg.norm(skeleton.poses[..., 3:], axis=-1).ravel()
            length = lengths[np.abs(lengths - 1).argmax()]
            if abs(length - 1) > 1e-3:
                yield error(
                    "skeleton",
                    "poses with unit quaternions (w, x, y, z)",
                    f"a quaternion of length {length:.3g}",
                    "return the position first, then the quaternion",
                )
                return


def check_rig(body: Organism, motion: Motion) -> Iterator[Finding]:
    """Check that the rig, if any, lists the body's joints and the skeleton's parts in order."""
    try:
        rig: object = body.rig()
    except SkeletonError as problem:
        yield error(
            "rig",
            "a tree of links with consistent parts",
            str(problem),
            "see the docstring of gaitsim.contracts.Rig",
        )
        return
    if rig is None:
        return
    if not isinstance(rig, Rig):
        wanted = "rig() returns a gaitsim.contracts.Rig, or None"
        yield error("rig", wanted, f"a {type(rig).__name__}", "")
        return
    skeleton = body.skeleton(motion, 0)
    for what, names, expected in (
        ("joints of joint_names()", rig.joints, body.joint_names()),
        ("segments of the skeleton", rig.names, skeleton.names),
        ("contact_names of the skeleton", rig.foot_names, skeleton.contact_names),
        (
            "solids of the skeleton",
            tuple(one.name for one in rig.solids),
            tuple(one.name for one in skeleton.solids),
        ),
    ):
        if tuple(names) != tuple(expected):
            yield error(
                "rig",
                f"the {what}, in this order: {', '.join(expected) or 'none'}",
                ", ".join(names) or "none",
                "use the same names in the rig and in the skeleton",
            )
            return
    if 0 in motion.failures:
        return
    ends = np.diff(rig.segments, axis=1), np.diff(np.asarray(skeleton.segments[0], float), axis=1)
    lengths, shown = (np.linalg.norm(one[:, 0], axis=-1) for one in ends)
    worst = int(np.abs(lengths - shown).argmax())
    if abs(lengths[worst] - shown[worst]) > _LENGTHS * shown.max():
        yield error(
            "rig",
            f"segments as long as the skeleton's, {rig.names[worst]!r} {shown[worst]:.4g} m long",
            f"{lengths[worst]:.4g} m",
            "return both ends of a segment in the frame of its link",
        )


def check_measures(body: Organism, motion: Motion) -> Iterator[Finding]:
    """Check that each measure has one number per individual."""
    for name, measure in body.measures(motion).items():
        shape = np.shape(measure.values) if isinstance(measure, Measure) else None
        if shape != (motion.population,):
            yield error(
                "measures",
                f"{name}: a Measure with values (population,) = ({motion.population},)",
                f"a {type(measure).__name__}" if shape is None else f"shape {shape}",
                "return one number per individual",
            )


def check_play(body: Organism, motion: Motion) -> Iterator[Finding]:
    """Check that the body can play the joint angles of its own motion."""
    if not body.can_play or "joint_angles" not in motion:
        return
    angles = motion["joint_angles"].copy()
    lent = angles.copy()
    played: object = body.play(lent)
    if not same(lent, angles):
        yield error(
            "play",
            "unchanged joint angles",
            "play() changes them",
            "work on a copy made with copy()",
        )
    if not isinstance(played, Motion):
        expected = "play() returns a gaitsim.contracts.Motion"
        yield error(
            "play", expected, f"a {type(played).__name__}", "return a Motion, as move() does"
        )
        return
    shape = np.shape(played["joint_angles"]) if "joint_angles" in played else ()
    if shape != angles.shape:
        yield error(
            "play",
            f"the channel joint_angles with the shape of the argument, {angles.shape}",
            f"shape {shape}",
            "add the channel to the Motion",
        )

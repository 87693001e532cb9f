"""Find the legs of a robot: turn it upright and along x, and choose the limbs that reach lowest."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitsim.plugin import GaitsimError, unknown
from gaitsim_robot.anatomy import Anatomy, Facing, Floats, Leg, Side, name_legs
from gaitsim_robot.chain import pose_data, sliding
from gaitsim_robot.errors import check_count, shorten
from gaitsim_robot.facing import (
    ALIKE,
    HEADINGS,
    count_mirrored,
    facing_of_shape,
    facings_of_names,
    misnamed,
    names_of,
    side_of,
    toes,
)
from gaitsim_robot.limbs import Limb, Tree, leg_order
from gaitsim_robot.linkage import motors
from gaitsim_robot.names import is_leg
from gaitsim_robot.shapes import surfaces
from gaitsim_robot.standing import Stand

LOW = 0.6  # minimum depth that a leg can reach, as a share of the deepest limb's depth
UPRIGHT = 0.4  # share of the largest depth; if LOW × the depth at zero is more, a robot is upright
LEGS = 50  # a standing pose of 50 legs takes seconds to find
NEARLY = 0.45  # share of the deepest limb's depth beyond which a limb may be a leg nevertheless
LIFT = 0.1  # minimum range of a foot's height, as a share of the largest depth
STIFF = math.radians(6.3)  # rad; one turn in radians, read as degrees, as MJCF does by default
OVERSIZED = 20  # ratio of a link's size to the distance of all joints that shows different units
SHORT = 0.5  # share of the distance between front and rear hips; a shorter one is only a part
BESIDE = 0.3  # share of a leg's length, largest distance of the centre of mass beyond all hips
NAME_FEET = "name the links at the ends of the legs in 'organism.feet'"
_HALF = 0.5**0.5
TURNS = {
    "": (1.0, 0.0, 0.0, 0.0),
    "y points up in the file; the robot is turned upright": (_HALF, _HALF, 0.0, 0.0),
}


def find_anatomy(
    model: Any,
    feet: Sequence[str] = (),
    stance: Mapping[str, float] | None = None,
    facing: Facing = "auto",
) -> Anatomy:
    """Find the legs, feet and standing pose of a robot.

    The legs are the limbs that reach lowest. The standing pose is the keyframe `stand`, or the
    pose at zero if the robot stands in it on bent legs. Otherwise it is a pose with bent knees and
    the feet below the hips or, for sprawling legs, out to the sides; if there is none, it is the
    pose at zero.

    Args:
        model: `mujoco.MjModel` of the robot's text.
        feet: names of the links at the ends of the legs; () finds them.
        stance: angles of joints in the standing pose by name, rad, or m for slides. Other joints
            have the angles of the keyframe, or zero. None searches for a pose.
        facing: direction of the nose in the upright robot. 'auto' follows the names of the legs if
            they fit only one direction, and otherwise the shape of the robot.
    """
    if model.nbody < 2 or model.njnt < 2:
        raise GaitsimError(
            "the robot has no joints", allowed="a trunk with at least two legs of hinges or slides"
        )
    _check_names(model, feet, stance or {})
    return Finder(model, feet, stance, facing).find()


def _check_names(model: Any, feet: Sequence[str], stance: Mapping[str, float]) -> None:
    bodies = [model.body(index).name for index in range(2, model.nbody)]
    for name in feet:
        if name not in bodies:
            raise unknown("link", name, bodies, key="feet")
    if len(set(feet)) < len(feet):
        raise GaitsimError(
            f"duplicate foot: {', '.join(feet)}", key="feet", allowed="each link at most once"
        )
    joints = [model.joint(index).name for index in range(1, model.njnt)]
    for name, angle in stance.items():
        if name not in joints:
            raise unknown("joint", name, joints, key="stance")
        joint = model.joint(name)
        lower, upper = model.jnt_range[joint.id]
        if model.jnt_limited[joint.id] and not lower <= angle <= upper:
            scale, unit = (1.0, " m") if sliding(model)[joint.id] else (math.degrees(1), "°")
            raise GaitsimError(
                f"the stance angle {scale * angle:.4g}{unit} of joint {name!r} is outside the "
                "joint's limits",
                key="stance",
                allowed=f"{scale * lower:.4g}{unit} to {scale * upper:.4g}{unit}",
            )


class Finder:
    """The search for the legs of one robot, with the arguments of `find_anatomy`."""

    def __init__(
        self,
        model: Any,
        feet: Sequence[str],
        stance: Mapping[str, float] | None,
        facing: Facing,
    ) -> None:
        self.model, self.feet, self.stance, self.facing = model, feet, stance, facing
        self.rest, self.given = self._rest()
        self.by_names = True  # whether names such as 'wing' exclude limbs
        self.ignored = False  # whether such limbs were ignored
        self.doubt, self.guessed_facing, self.searched = "", "", False  # as in `Anatomy`
        self._check_geometry()

    def find(self) -> Anatomy:
        """Return the anatomy."""
        first: GaitsimError | None = None
        for self.by_names in (True, False):
            for note, turn in TURNS.items():
                try:
                    return self._find(_rotate_trunk(self.rest, turn), (note,) if note else ())
                except GaitsimError as error:
                    first = first or error
                if self.given:
                    break
            if not self.ignored:
                break
        assert first is not None
        raise first

    def _check_geometry(self) -> None:
        """Check that the geometry and the joints of the robot have the same unit of length."""
        data = pose_data(self.model, self.rest)
        surface = surfaces(self.model)
        points = surface.place(data)
        apart = float(np.ptp(data.xanchor[1:], axis=0).max())
        for body in np.unique(surface.bodies).tolist():
            size = float(np.ptp(points[surface.bodies == body], axis=0).max())
            if size > OVERSIZED * apart > 0:
                raise GaitsimError(
                    f"the link {self.model.body(body).name!r} is {size:.3g} m long, although all "
                    f"joints are within {apart:.3g} m",
                    remedy="convert its geometry to metres; for a mesh in millimetres, write "
                    'scale="0.001 0.001 0.001" in the element <mesh>',
                )

    def _rest(self) -> tuple[Floats, bool]:
        """Return the keyframe's pose, or else the pose at zero, clipped to the joint limits.

        Also return whether the user or the file gives a standing pose.
        """
        import mujoco

        model = self.model
        rest = model.qpos0.copy()
        key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "stand")
        given = key >= 0
        if given:
            rest = model.key_qpos[key].copy()
        else:  # without load, springs of passive joints are relaxed
            passive = {*range(1, model.njnt)} - motors(model)
            springs = [joint for joint in passive if model.jnt_stiffness[joint]]
            address = model.jnt_qposadr[springs]
            rest[address] = model.qpos_spring[address]
        rest[:3] = 0.0
        limited = np.flatnonzero(model.jnt_limited)
        address = model.jnt_qposadr[limited]
        rest[address] = np.clip(rest[address], *model.jnt_range[limited].T)
        return rest, given or bool(self.stance)

    def _find(self, rest: Floats, notes: tuple[str, ...]) -> Anatomy:
        limbs, ignored = self._legs(self._tree(rest))
        shape = facing_of_shape(limbs, default=-1 if notes else 1)
        fitting = facings_of_names(self.model, limbs)
        facing = self.facing
        if facing == "auto":
            likely = fitting or facings_of_names(self.model, limbs, numbers=False)
            facing = likely[0] if len(likely) == 1 else shape
            self.guessed_facing = "" if len(likely) == 1 else shape
        if facing != "+x":
            x, y = HEADINGS[facing]
            angle = -math.atan2(y, x) / 2
            rest = _rotate_trunk(rest, (np.cos(angle), 0.0, 0.0, np.sin(angle)))
            limbs, ignored = self._legs(self._tree(rest))
            named = self.facing == "auto" and facing != shape
            reason = ", as the names of its legs say" if named else ""
            notes = (*notes, f"the robot faces {facing}{reason}; it is turned to face +x")
        sides = [side_of(limb, limbs) for limb in limbs]
        order = leg_order(limbs, sides)
        limbs, sides = [limbs[index] for index in order], [sides[index] for index in order]
        stand = Stand(self.model, limbs, _partners(limbs, sides))
        for joint, angle in (self.stance or {}).items():
            rest[self.model.joint(joint).qposadr[0]] = angle
        standing, note = self._stand(stand, rest)
        notes += ignored + note
        warnings = misnamed(self.model, limbs, sides, fitting)
        if self.facing == "auto" and facing != shape and len(limbs) == 2 and toes(limbs, 0) < 0:
            warnings += (
                f"the feet point to {shape}, although the names of the legs say that the robot "
                f"faces {facing}; if it does not, set 'organism.facing' to {shape}",
            )
        return self._anatomy(stand, sides, standing, notes, warnings)

    def _tree(self, rest: Floats) -> Tree:
        return Tree(self.model, pose_data(self.model, rest))

    def _legs(self, tree: Tree) -> tuple[list[Limb], tuple[str, ...]]:
        """Return the legs, and a note about limbs that their names exclude."""
        if self.feet:
            named = tree.limbs_to([self.model.body(name).id for name in self.feet])
            if not named:
                raise GaitsimError(
                    f"no joint with a motor moves {', '.join(self.feet)}",
                    key="feet",
                    allowed="links that driven joints move, at the ends of legs",
                )
            return named, ()
        limbs = tree.limbs()
        legs = self._reaching(tree, limbs)
        notes: tuple[str, ...] = ()
        plain = [limb for limb in limbs if is_leg(names_of(self.model, limb))]
        if self.by_names and len(plain) < len(limbs):
            others = self._reaching(tree, plain)
            ignored = [self.model.body(one.foot).name for one in legs if one not in plain]
            if ignored and _carry(others, tree.data.subtree_com[1]):
                self.ignored = True
                legs = others
                self.doubt = _doubt(ignored, "as their names say")
                notes = (
                    f"not taken for legs because of their names: {shorten(ignored, 8)}; if they "
                    "are legs, name the links at the ends of all legs in 'organism.feet'",
                )
        centre = tree.data.subtree_com[1]
        if len(legs) < 2 or _are_arms(legs, centre[2]):
            names = shorten([self.model.body(limb.foot).name for limb in limbs], 8)
            raise GaitsimError(
                "the robot has no legs" + (f", only limbs that end at {names}" if names else ""),
                allowed="at least two limbs of driven joints that reach the ground below the trunk",
                remedy=self._remedy(),
            )
        check_count(len(legs), LEGS, "legs", remedy=NAME_FEET)
        return legs, notes

    def _reaching(self, tree: Tree, limbs: list[Limb]) -> list[Limb]:
        """Return the limbs that reach lowest."""
        limbs_in_pairs = _with_counterparts(limbs)
        if not self.given and _lies_on_its_side(limbs_in_pairs):
            raise GaitsimError("the robot lies on its side", remedy="make z point up in the file")
        centre = tree.data.subtree_com[1]
        depth = [centre[2] - limb.tips[:, 2].min() for limb in limbs_in_pairs]
        deepest = max(depth, default=0.0)
        hangs = [
            centre[2] - min(other.tips[0, 2] for other in limbs_in_pairs if _are_alike(limb, other))
            for limb in limbs_in_pairs
        ]
        # Arms of an upright robot could reach the ground, but do not do so in the pose at zero.
        hanging = LOW * max(hangs, default=0.0)
        legs = [
            limb
            for limb, deep, hang in zip(limbs_in_pairs, depth, hangs, strict=True)
            if deep >= LOW * deepest > 0
            and np.ptp(limb.tips[:, 2]) > LIFT * deepest
            and (hanging < UPRIGHT * deepest or hang > hanging)
        ]
        legs = _with_counterparts(legs)
        nearly = [
            self.model.body(limb.foot).name
            for limb, deep in zip(limbs_in_pairs, depth, strict=True)
            if deep >= NEARLY * deepest and limb not in legs and is_leg(names_of(self.model, limb))
        ]
        self.doubt = _doubt(nearly, "as they hardly reach the ground") if nearly else ""
        return legs

    def _remedy(self) -> str:
        """Return what to do if no legs are found."""
        hinges = np.flatnonzero(~sliding(self.model))[1:]
        widest = float(np.abs(self.model.jnt_range[hinges]).max(initial=0.0))
        if 0 < widest <= STIFF:
            return (
                f"all joints are within ±{math.degrees(widest):.3g}°; if these limits are radians, "
                'write <compiler angle="radian"/> in the MJCF file'
            )
        return NAME_FEET

    def _stand(self, stand: Stand, rest: Floats) -> tuple[Floats, tuple[str, ...]]:
        """Return the standing pose, and a note if it is not the keyframe of the file."""
        problem = stand.problem(rest, bent=not self.given)
        if not problem:
            return stand.on_ground(rest), ()
        if self.stance:
            raise GaitsimError(
                f"the robot cannot stand in the given pose: {problem}",
                key="stance",
                remedy="change the pose, or omit it so that gaitsim finds one",
            )
        straight = not self.given and not stand.problem(rest, bent=False)
        found, why = stand.search(rest) if stand.can_bend() or not straight else (None, "")
        if found is None and straight:
            note = "no standing pose with bent legs was found: the legs are as in the pose at zero"
            return stand.on_ground(rest), (note,)
        if found is None and stand.images:
            free = Stand(self.model, stand.unpaired, stand.partners, mirrored=False)
            found, _ = free.search(rest)
        self.searched = found is not None
        if found is None:
            raise GaitsimError(
                f"the robot has no standing pose: {why}",
                remedy="set the joint angles of a standing pose in 'organism.stance', or name the "
                "feet in 'organism.feet'",
            )
        instead = f"the keyframe is not the standing pose, because {problem}"
        return found, (instead,) if self.given else ()

    def _anatomy(
        self,
        stand: Stand,
        sides: list[Side],
        standing: Floats,
        notes: tuple[str, ...],
        warnings: tuple[str, ...],
    ) -> Anatomy:
        model = self.model
        contacts = stand.contacts(standing)
        points = stand.pose(standing)
        legs = []
        for name, side, limb, touching in zip(
            name_legs(sides), sides, stand.limbs, contacts, strict=True
        ):
            middle = (touching.min(axis=0) + touching.max(axis=0)) / 2
            rotation = stand.data.xmat[limb.foot].reshape(3, 3)
            local = rotation.T @ (middle - stand.data.xpos[limb.foot])
            legs.append(
                Leg(
                    name,
                    side,
                    tuple(model.joint(joint).name for joint in limb.joints),
                    model.body(limb.foot).name,
                    (float(local[0]), float(local[1]), float(local[2])),
                    limb.length,
                    (float(limb.sole[0]), float(limb.sole[1])),
                )
            )
        of_legs = {joint for leg in legs for joint in leg.joints}
        driven = motors(model)
        joints = {index: model.joint(index).name for index in range(1, model.njnt)}
        if len(legs) == 2 and not all(min(leg.sole) > 0 for leg in legs):
            notes = (*notes, "two feet without soles: the robot stands only while it balances")
        trunk = _trunk_length(stand, points)
        length = max(trunk, stand.reach) if len(legs) == 2 else trunk
        return Anatomy(
            tuple(legs),
            tuple(joints[one] for one in sorted(driven) if joints[one] not in of_legs),
            standing,
            float(model.body_subtreemass[1]),
            length,
            trunk,
            notes,
            warnings,
            tuple(name for index, name in joints.items() if index not in driven),
            wheels=tuple(joints[one] for limb in stand.limbs for one in limb.wheels),
            doubt=self.doubt,
            guessed_facing=self.guessed_facing,
            searched=self.searched,
        )


def _doubt(names: Sequence[str], why: str) -> str:
    """Return the question whether limbs that end at given links are not legs."""
    return f"Are the limbs that end at {shorten(names, 8)} not legs, {why}?"


def _trunk_length(stand: Stand, points: Floats) -> float:
    """Return the extent of the trunk's surface along x, m.

    Args:
        stand: the robot.
        points: the surface of the robot in its standing pose, (points, 3) m.

    Returns:
        The extent, or the distance between the front and rear hips if the trunk has no surface or
        only a small one, such as that of a sensor.
    """
    group = np.flatnonzero(stand.model.body_weldid == 1)
    surface = stand.surfaces.points_on(group)
    balls = stand.surfaces.radius[surface]
    ends = [points[surface, 0] - balls, points[surface, 0] + balls]
    extent = float(np.ptp(ends)) if len(surface) else 0.0
    hips = float(np.ptp([limb.hip[0] for limb in stand.limbs]))
    return (extent if extent > SHORT * hips else hips) or stand.reach


def _with_counterparts(legs: list[Limb]) -> list[Limb]:
    """Return the limbs that resemble another one, unlike an arm on the back of a quadruped."""
    return [
        limb for limb in legs if any(_are_alike(limb, other) for other in legs if other is not limb)
    ]


def _carry(limbs: Sequence[Limb], centre: Floats) -> bool:
    """Return whether two or more limbs are around the centre of mass, unlike a dog's hind legs."""
    if len(limbs) < 2:
        return False
    hips = np.array([limb.hip[:2] for limb in limbs])
    beyond = np.maximum(hips.min(axis=0) - centre[:2], centre[:2] - hips.max(axis=0))
    return bool(beyond.max() < BESIDE * np.mean([limb.length for limb in limbs]))


def _are_arms(limbs: Sequence[Limb], height: float) -> bool:
    """Return whether the limbs are two arms.

    Arms have at least seven joints, no soles, and shoulders above `height`, m.
    """
    return len(limbs) == 2 and all(
        len(one.joints) > 6 and not one.sole.any() and one.chain.anchors[0, 2] > height
        for one in limbs
    )


def _lies_on_its_side(limbs: Sequence[Limb]) -> bool:
    """Return whether the hips of similar limbs are side by side along z instead of y."""
    for limb in limbs:
        hips = [other.hip for other in limbs if _are_alike(limb, other)]
        spread = np.ptp(hips, axis=0) / limb.length
        if spread[2] > 0.3 and spread[1] < 0.1:
            return True
    return count_mirrored(limbs, 2) > count_mirrored(limbs, 1)


def _are_alike(limb: Limb, other: Limb) -> bool:
    same = len(other.joints) == len(limb.joints)
    return same and abs(other.length - limb.length) < ALIKE * limb.length


def _partners(limbs: Sequence[Limb], sides: Sequence[Side]) -> list[int]:
    """Return the index of the leg that mirrors each leg on the other side, or -1."""
    partners = []
    middle = float(np.mean([limb.hip[1] for limb in limbs]))
    for index, limb in enumerate(limbs):
        image = limb.hip * [1, -1, 1] + [0, 2 * middle, 0]
        near = [
            float(np.linalg.norm(other.hip - image))
            if sides[index] != sides[at] and len(other.joints) == len(limb.joints)
            else np.inf
            for at, other in enumerate(limbs)
        ]
        best = int(np.argmin(near))
        partners.append(best if near[best] < ALIKE * limb.length else -1)
    return partners


def _rotate_trunk(rest: Floats, turn: Sequence[float]) -> Floats:
    """Return a pose with the trunk rotated by a quaternion in the world's frame."""
    import mujoco

    turned = rest.copy()
    mujoco.mju_mulQuat(turned[3:7], np.array(turn), rest[3:7])
    return turned

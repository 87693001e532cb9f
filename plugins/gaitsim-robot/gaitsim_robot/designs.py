"""Designs: a robot with other dimensions, as a robot's text with its own standing pose.

A dimension is a factor of a length, of positions, or of the servos. The links of a segment stretch
along the line from joint to joint; what is beyond the next joint moves with it. The mass of a link
has two parts: a share `growth` grows in proportion to the length, and the rest, such as servos,
bearings and feet, keeps its mass. Both have the shape of the whole link; the growing part is
stretched, and both have their centre where the stretched link has it. The mass of a servo is
proportional to its torque. What larger servos add is a point on the joint's axis, fixed to the link
that carries the joint; what smaller ones save makes this link lighter in proportion.
"""

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Lock
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from gaitsim.plugin import Dimension, conjugate, rotated
from gaitsim.plugin.toolkit import SERVOS, norm
from gaitsim_robot.anatomy import Anatomy, Floats, Leg
from gaitsim_robot.chain import pose_data, stacked
from gaitsim_robot.linkage import Linkage, standing_chains
from gaitsim_robot.markup import parse
from gaitsim_robot.shapes import surfaces
from gaitsim_robot.simulation import NEAR, near_links, touching_links
from gaitsim_robot.standing import UNEVEN
from gaitsim_robot.text import WHERE, compile_model

SHORTEST = 0.05  # share of a leg's length; shorter segments are joints in one place
PARALLEL = 0.99  # smallest cosine of the angle between axes that count as parallel
ALIGNED = 0.7  # smallest cosine of the angle between the axis of a shape and a stretch along it
ROUND = 0.2  # share of its radius, largest distance of the contact from the surface of a ball
VERTICAL = 0.7  # smallest vertical component of the first axis of an insect's leg
LIGHTEST = 0.5  # share of its mass that a link keeps with smaller servos
ITERATIONS = (20, 6, 6)  # of the inverse kinematics, after each move below the centre of mass
MASS_PER_TORQUE = float(np.median([one.mass / one.stall_torque for one in SERVOS.values()]))
"""Mass of a servo that is not in the table per stall torque, kg/(N m): the table's median."""

REMEMBERED = 512  # designs, of up to 0.7 MB

Factors = tuple[tuple[str, float], ...]
"""Factors by dimension; others are 1."""

NAMES = {1: ("leg",), 2: ("thigh", "shank"), 3: ("hip", "thigh", "shank")}
INSECT = {1: ("leg",), 2: ("femur", "tibia"), 3: ("coxa", "femur", "tibia")}


@dataclass(frozen=True, eq=False)
class DesignedRobot:
    """A robot with other dimensions.

    Attributes:
        text: the robot's text, with the standing pose as its keyframe.
        anatomy: its anatomy, with the legs of the original.
        problem: why it cannot stand, or ''.
    """

    text: str
    anatomy: Anatomy
    problem: str = ""


@dataclass(frozen=True, eq=False)
class Stretch:
    """A part of a link that grows along a direction.

    Attributes:
        body: name of the link.
        start: point that stays, (3,) m, in the frame of the link.
        along: unit direction, (3,).
        length: length that grows, m; infinite for both directions.
    """

    body: str
    start: Floats
    along: Floats
    length: float

    def move(self, points: Floats, factor: float) -> Floats:
        """Return where points, (…, 3) m, are after a stretch by a factor."""
        far = ((points - self.start) * self.along).sum(axis=-1)
        low = 0.0 if math.isfinite(self.length) else -math.inf
        share = (factor - 1) * np.clip(far, low, self.length)
        moved: Floats = points + share[..., None] * self.along
        return moved


@dataclass(frozen=True, eq=False)
class Segment:
    """A segment of a leg: the name of the leg, dimensions by name, and what stretches."""

    leg: str
    names: tuple[str, ...]
    stretch: Stretch


class DesignSpace:
    """The dimensions of a robot, and its designs.

    Args:
        text: text of the robot.
        anatomy: its anatomy, without damage.
        torque: mean stall torque of the servos, N m; 0 if they cannot grow.
        servo_mass: mass of a servo, kg.
        growth: share of the mass of links that grows with their lengths.

    Attributes:
        dimensions: the dimensions by name.
        coincident: joints that have no segment between them, as they are in one place.
    """

    def __init__(
        self, text: str, anatomy: Anatomy, torque: float, servo_mass: float, growth: float
    ) -> None:
        self.anatomy, self._growth, self._servo_mass = anatomy, growth, servo_mass
        self._model = compile_model(text)
        self._data = pose_data(self._model, anatomy.stance)
        self._root = parse(text.encode(), WHERE, encoding="utf-8")
        self._prepare()
        chains = standing_chains(self._model, anatomy)
        self._closed = any(isinstance(chain, Linkage) for chain in chains)
        self._chains = () if self._closed else chains
        self.coincident: list[str] = []
        self._segments = [] if self._closed else self._find_segments()
        trunk = self._model.body(1)
        self._forward, self._left = (
            rotated(conjugate(anatomy.stance[3:7]), np.eye(3)[axis]) for axis in (0, 1)
        )
        self._hips = {
            leg.name: self._anchor(self._path(leg)[0])
            for leg in anatomy.legs
            if self._model.body_parentid[self._path(leg)[0]] == 1
        }
        hips = np.array([*self._hips.values()]).reshape(-1, 3)
        self._middle = (hips.max(axis=0) + hips.min(axis=0)) / 2 if len(hips) else np.zeros(3)
        self._trunk = Stretch(trunk.name, self._middle, self._forward, math.inf)
        self.dimensions = {} if self._closed else dict(self._find_dimensions(hips, torque))
        self._known: dict[Factors, DesignedRobot] = {}
        self._lock = Lock()  # parts of a population are evaluated in threads

    def designs(self, factors: Sequence[Factors]) -> list[DesignedRobot]:
        """Return the designs with given factors; the last ones are remembered."""
        with self._lock:
            known = {one: self._known[one] for one in factors if one in self._known}
        new = [one for one in dict.fromkeys(factors) if one not in known]
        if new:
            found = dict(zip(new, self._new(list(map(dict, new))), strict=True))
            known |= found
            with self._lock:
                self._known |= found
                while len(self._known) > REMEMBERED:
                    self._known.pop(next(iter(self._known)))
        return [known[one] for one in factors]

    def missing(self, name: str) -> str:
        """Return why the robot has no such dimension although it might have one, or ''."""
        if self._closed:
            return "the robot's legs have closed linkages or coupled joints, and no dimensions"
        if self.coincident and name.rpartition(".")[2] in (*NAMES[3], *INSECT[3]):
            joints = "; ".join(self.coincident[:4])
            return f"no dimension {name!r}: these joints are in one place: {joints}"
        return ""

    def _new(self, factors: Sequence[Mapping[str, float]]) -> list[DesignedRobot]:
        """Return the designs with given factors by dimension; others are 1."""
        roots = [self._edited(one) for one in factors]
        for root in roots:
            contact = root.find("contact")
            contact = SubElement(root, "contact") if contact is None else contact
            for first, second in self._excluded:
                SubElement(contact, "exclude", body1=first, body2=second)
        return self._stand(roots, factors)

    @cached_property
    def _excluded(self) -> list[tuple[str, str]]:
        """Pairs of links of one leg, or of the trunk and a leg, that meet in any design.

        They overlap or almost touch in the standing poses at the ends of the usual ranges.
        """
        import mujoco

        whole = [name for name in self.dimensions if "." not in name or name.startswith("hips")]
        ends = [{name: end} for name in whole for end in self._ends(name)]
        ends += [{name: self._ends(name)[end] for name in whole} for end in (0, 1)]
        roots = [self._edited(one) for one in ends]
        given = {frozenset(one.attrib.values()) for one in self._root.iter("exclude")}
        found = set()
        for design, root in zip(self._stand(roots, ends), roots, strict=True):
            spec = mujoco.MjSpec.from_string(tostring(root, "unicode"))
            for pair in near_links(spec, design.anatomy.stance, NEAR * self.anatomy.length):
                one, other = (self._leg_of(body) for body in pair)
                if one == other or "" in (one, other):
                    found.add(frozenset(self._model.body(body).name for body in pair))
        pairs = [(min(pair), max(pair)) for pair in found - given if len(pair) == 2]
        return sorted(pairs)

    def _ends(self, name: str) -> tuple[float, float]:
        return self.dimensions[name].low, self.dimensions[name].high

    # Finding the dimensions of the original

    def _prepare(self) -> None:
        """Index the elements, and give each geom with a mesh a mesh of its own."""
        root = self._root
        for keyframe in root.findall("keyframe"):
            root.remove(keyframe)
        asset = root.find("asset")
        meshes = {mesh.get("name", ""): mesh for mesh in root.iter("mesh")}
        used = set()
        for number, geom in enumerate(root.iter("geom")):
            mesh = geom.get("mesh", "")
            if mesh and mesh in used and asset is not None:
                name = f"{mesh} of geom {number}"
                own = SubElement(asset, "mesh", meshes[mesh].attrib | {"name": name})
                meshes[name] = own
                geom.set("mesh", name)
            used.add(mesh)

    def _path(self, leg: Leg) -> list[int]:
        """Return the links of a leg from the hip to the foot."""
        first = int(self._model.joint(leg.joints[0]).bodyid[0])
        path = [self._model.body(leg.foot).id]
        while path[-1] != first:
            path.append(int(self._model.body_parentid[path[-1]]))
        return path[::-1]

    @cached_property
    def _legs_of(self) -> dict[int, str]:
        """The leg of each of its links."""
        found: dict[int, str] = {}
        for leg in self.anatomy.legs:
            found |= dict.fromkeys(self._path(leg), leg.name)
        for body in range(1, self._model.nbody):  # parents before children
            if (parent := int(self._model.body_parentid[body])) in found:
                found.setdefault(body, found[parent])
        return found

    def _leg_of(self, body: int) -> str:
        return self._legs_of.get(body, "")

    def _anchor(self, body: int) -> Floats:
        """Return the place of a link's first joint in the frame of its parent, (3,) m."""
        place: Floats = self._anchors[body]
        return place

    @cached_property
    def _anchors(self) -> Floats:
        model = self._model
        at = model.jnt_pos[model.body_jntadr]
        return np.asarray(model.body_pos + rotated(model.body_quat, at))

    def _find_segments(self) -> list[Segment]:
        model, found = self._model, []
        for leg in self.anatomy.legs:
            path, stretches = self._path(leg), []
            for body, child in zip(path, [*path[1:], 0], strict=True):
                last = int(model.body_jntadr[body] + model.body_jntnum[body] - 1)
                start, axis = model.jnt_pos[last].copy(), model.jnt_axis[last]
                end = self._anchor(child) if child else self._ball(body, np.array(leg.point))
                span = end - start
                if not child and any(leg.sole):
                    upward = self._data.xmat[body].reshape(3, 3)[2]
                    span = (span @ upward) * upward
                elif not child or self._parallel(last, int(model.body_jntadr[child])):
                    span = span - (span @ axis) * axis
                length = float(norm(span))
                if length > SHORTEST * leg.length:
                    name = model.body(body).name
                    stretches.append(Stretch(name, start, span / length, length))
                elif child:
                    joints = last, int(model.body_jntadr[child])
                    self.coincident.append(" and ".join(model.joint(one).name for one in joints))
            number = f"row{leg.name[1:]}"
            for kind, stretch in zip(self._names(leg, len(stretches)), stretches, strict=True):
                names = (kind, f"{number}.{kind}", f"{leg.name}.{kind}")
                found.append(Segment(leg.name, names, stretch))
        return found

    def _names(self, leg: Leg, count: int) -> tuple[str, ...]:
        """Return the names of a leg's segments, from the hip to the foot."""
        sole = any(leg.sole) and count > 1
        upright = abs(self._data.xaxis[self._model.joint(leg.joints[0]).id][2]) < VERTICAL
        numbered = tuple(f"segment{1 + index}" for index in range(count - sole))
        names = (NAMES if upright else INSECT).get(count - sole, numbered)
        return (*names, "foot") if sole else names

    def _parallel(self, joint: int, other: int) -> bool:
        axes = self._data.xaxis[[joint, other]]
        return bool(abs((axes[0] * axes[1]).sum()) > PARALLEL)

    def _ball(self, body: int, point: Floats) -> Floats:
        """Return the centre of the ball at the end of a foot, or the contact point itself."""
        import mujoco

        model, balls = self._model, list[tuple[Floats, float]]()
        for geom in np.flatnonzero(model.geom_bodyid == body).tolist():
            size, place = model.geom_size[geom], model.geom_pos[geom]
            along = rotated(model.geom_quat[geom], np.array([0.0, 0.0, size[1]]))
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE:
                balls.append((place.copy(), size[0]))
            elif model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
                balls += [(place + along, size[0]), (place - along, size[0])]
        for centre, radius in balls:
            if abs(float(norm(centre - point)) - radius) < ROUND * radius:
                return centre
        return point

    def _find_dimensions(self, hips: Floats, torque: float) -> Any:
        """Yield the dimensions by name."""
        lengths: dict[str, list[float]] = {}
        for segment in self._segments:
            for name in segment.names:
                lengths.setdefault(name, []).append(segment.stretch.length)
        common = [name for name in lengths if "." not in name]
        for name in sorted(lengths, key=lambda name: (name not in common, "row" not in name)):
            of = "" if "." not in name else f" of {name.partition('.')[0].replace('row', 'row ')}"
            yield name, Dimension("m", float(np.mean(lengths[name])), _length_help(name) + of)
        spans = [
            np.ptp(hips @ along) if len(hips) else 0.0 for along in (self._forward, self._left)
        ]
        size = self.anatomy.length
        if spans[0] > SHORTEST * size:
            yield (
                "hips.length",
                Dimension("m", spans[0], "distance of the front from the rear hips"),
            )
        if spans[1] > SHORTEST * size:
            yield "hips.width", Dimension("m", spans[1], "distance of the left from the right hips")
        if len(self._hips) == len(self.anatomy.legs):
            yield "trunk", Dimension("m", self.anatomy.trunk, "length of the trunk, with its hips")
        if torque:
            yield "servos", Dimension("N m", torque, "stall torque of the servos, and their mass")

    # Building designs

    def _edited(self, factors: Mapping[str, float]) -> Element:
        """Return the document of a design, without a standing pose."""
        root = copy.deepcopy(self._root)
        bodies = {body.get("name", ""): body for body in root.iter("body")}
        meshes = {mesh.get("name", ""): mesh for mesh in root.iter("mesh")}
        trunk = factors.get("trunk", 1.0)
        if trunk != 1:
            self._stretch(bodies, meshes, self._trunk, trunk)
        along = trunk * factors.get("hips.length", 1.0) - trunk
        aside = factors.get("hips.width", 1.0) - 1
        for leg in self.anatomy.legs:
            if leg.name in self._hips and (along or aside):
                far = self._hips[leg.name] - self._middle
                shift = along * (far @ self._forward) * self._forward
                shift = shift + aside * (far @ self._left) * self._left
                hip = bodies[self._model.body(self._path(leg)[0]).name]
                _set(hip, "pos", _numbers(hip, "pos", 3) + shift)
        for segment in self._segments:
            factor = self._factor(segment, factors)
            if factor != 1:
                self._stretch(bodies, meshes, segment.stretch, factor)
        if (servos := factors.get("servos", 1.0)) != 1:
            self._add_servos(bodies, servos)
        return root

    def _factor(self, segment: Segment, factors: Mapping[str, float]) -> float:
        return math.prod(factors.get(name, 1.0) for name in segment.names)

    def _stretch(
        self,
        bodies: Mapping[str, Element],
        meshes: Mapping[str, Element],
        stretch: Stretch,
        factor: float,
    ) -> None:
        """Stretch the shapes and the mass of a link, and move what is attached to it."""
        body = bodies[stretch.body]
        for child in body.findall("body"):
            anchor = self._anchor(self._model.body(child.get("name", "")).id)
            shift = stretch.move(anchor, factor) - anchor
            if shift.any():
                _set(child, "pos", _numbers(child, "pos", 3) + shift)
        for site in body.findall("site"):
            _set(site, "pos", stretch.move(_numbers(site, "pos", 3), factor))
        for geom in body.findall("geom"):
            _stretch_geom(geom, meshes, stretch, factor)
        inertial = body.find("inertial")
        assert inertial is not None
        mass, centre, inertia = _inertia(inertial)
        spread = np.trace(inertia) / 2 * np.eye(3) - inertia  # second moments
        shape = np.eye(3) + (factor - 1) * np.outer(stretch.along, stretch.along)
        grown = factor * self._growth
        spread = (1 - self._growth) * spread + grown * shape @ spread @ shape
        inertia = np.trace(spread) * np.eye(3) - spread
        centre = stretch.move(centre, factor)
        _set_inertia(inertial, mass * (1 - self._growth + grown), centre, inertia)

    def _add_servos(self, bodies: Mapping[str, Element], factor: float) -> None:
        """Add to the links that carry the joints of the legs what the servos gain in mass."""
        added = (factor - 1) * self._servo_mass
        for leg in self.anatomy.legs:
            for joint in leg.joints:
                body = int(self._model.joint(joint).bodyid[0])
                carrier = bodies[self._model.body(self._model.body_parentid[body]).name]
                child = bodies[self._model.body(body).name]
                inertial = carrier.find("inertial")
                assert inertial is not None
                mass, centre, inertia = _inertia(inertial)
                place = _numbers(child, "pos", 3)
                place = place + self._anchor(body) - self._model.body_pos[body]
                if added < 0:  # a point could leave a negative inertia
                    share = max(1 + added / mass, LIGHTEST)
                    _set_inertia(inertial, share * mass, centre, share * inertia)
                    continue
                total = mass + added
                middle = (mass * centre + added * place) / total
                inertia = (
                    inertia + _steiner(mass, centre - middle) + _steiner(added, place - middle)
                )
                _set_inertia(inertial, total, middle, inertia)

    def _stand(
        self, roots: Sequence[Element], factors: Sequence[Mapping[str, float]]
    ) -> list[DesignedRobot]:
        """Return designs with their standing poses."""
        import mujoco

        texts = [tostring(root, "unicode") for root in roots]
        models = [mujoco.MjModel.from_xml_string(text) for text in texts]
        anatomies = [
            self._measured(one, float(model.body_subtreemass[1]))
            for one, model in zip(factors, models, strict=True)
        ]
        datas = [mujoco.MjData(model) for model in models]
        poses, away = self._poses(models, datas, anatomies)
        found = []
        for number, (text, model, data) in enumerate(zip(texts, models, datas, strict=True)):
            pose, lost = poses[number], int(np.argmax(away[number]))
            pose[:3] = 0.0  # as `finding` computes the height, to the same bits
            data.qpos[:] = pose
            mujoco.mj_kinematics(model, data)
            pose[2] -= _lowest(model, data)
            mujoco.mj_comPos(model, data)
            problem = self._collision(model, data)
            if away[number, lost] > UNEVEN:
                leg = self.anatomy.legs[lost].name
                problem = f"its leg {leg} cannot reach its place on the ground"
            numbers = " ".join(map(repr, pose.tolist()))
            key = f'<keyframe><key name="stand" qpos="{numbers}"/></keyframe></mujoco>'
            text = text.removesuffix("</mujoco>") + key  # noqa: PLW2901
            found.append(DesignedRobot(text, replace(anatomies[number], stance=pose), problem))
        return found

    def _measured(self, factors: Mapping[str, float], mass: float) -> Anatomy:
        """Return the anatomy of a design, with the standing pose of the original."""
        legs = []
        for leg in self.anatomy.legs:
            point, length = np.array(leg.point), leg.length
            for segment in self._segments:
                if segment.leg == leg.name:
                    stretch = segment.stretch
                    longer = (self._factor(segment, factors) - 1) * stretch.length
                    length += longer
                    if stretch.body == leg.foot:
                        point = point + longer * stretch.along
            x, y, z = point.tolist()
            legs.append(replace(leg, point=(x, y, z), length=length))
        trunk = self.anatomy.trunk * factors.get("trunk", 1.0)
        reach = float(np.mean([leg.length for leg in legs]))
        length = max(trunk, reach) if len(legs) == 2 else trunk
        return replace(self.anatomy, legs=tuple(legs), mass=mass, length=length, trunk=trunk)

    def _poses(
        self, models: Sequence[Any], datas: Sequence[Any], anatomies: Sequence[Anatomy]
    ) -> tuple[Floats, Floats]:
        """Return standing poses, and how far each foot is from its place.

        The feet keep their places relative to the hips, in lengths of the leg, on level ground; all
        of them move so that they keep their mean place relative to the centre of mass.

        Returns:
            The poses, (designs, nq), and distances, (designs, legs) leg lengths.
        """
        import mujoco

        single = [standing_chains(model, one) for model, one in zip(models, anatomies, strict=True)]
        chains = [stacked(one) for one in zip(*single, strict=True)]
        tips = np.array([own.tip for own in self._chains])
        targets = np.empty((len(models), *tips.shape))
        for index, (chain, own) in enumerate(zip(chains, self._chains, strict=True)):
            ratio = (chain.length / own.length)[:, None]
            targets[:, index] = chain.anchors[:, 0] + ratio * (own.tip - own.anchors[0])
        targets[..., 2] = tips[:, 2] + (targets[..., 2] - tips[:, 2]).mean(axis=1, keepdims=True)
        offset = self._data.subtree_com[1][:2] - tips[:, :2].mean(axis=0)
        poses = np.tile(self.anatomy.stance, (len(models), 1))
        away = np.empty(targets.shape[:2])
        for iterations in ITERATIONS:
            centres = np.empty((len(models), 2))
            for number, (model, data) in enumerate(zip(models, datas, strict=True)):
                data.qpos[:] = poses[number]
                mujoco.mj_kinematics(model, data)
                mujoco.mj_comPos(model, data)
                centres[number] = data.subtree_com[1][:2]
            targets[..., :2] += (centres - targets[..., :2].mean(axis=1) - offset)[:, None]
            for index, (chain, leg) in enumerate(zip(chains, self.anatomy.legs, strict=True)):
                address = [self._model.joint(joint).qposadr[0] for joint in leg.joints]
                weights = chain.weights(any(leg.sole))
                start, places = poses[:, address], targets[:, index]
                angles = chain.solve(places, start, chain.zero, weights, iterations)
                away[:, index] = norm(chain.place(angles) - places) / chain.length
                poses[:, address] = angles
        return poses, away

    @cached_property
    def _meeting(self) -> set[tuple[int, int]]:
        """The pairs of links that touch in the original's standing pose."""
        return touching_links(self._model, self._data)

    def _collision(self, model: Any, data: Any) -> str:
        """Return which legs meet in the pose of `data`, unless the original's do, or ''."""
        for first, second in sorted(touching_links(model, data) - self._meeting):
            one, other = sorted((self._leg_of(first), self._leg_of(second)))
            if one and one != other:
                return f"its legs {one} and {other} collide in the standing pose"
        return ""


def _lowest(model: Any, data: Any) -> float:
    """Return the height of a robot's lowest point in the pose of `data`, m."""
    surface = surfaces(model)
    return float((surface.place(data)[:, 2] - surface.radius).min())


def _stretch_geom(
    geom: Element, meshes: Mapping[str, Element], stretch: Stretch, factor: float
) -> None:
    """Stretch a shape: a mesh and the ends of a capsule exactly, other shapes along one axis."""
    if "fromto" in geom.attrib:
        ends = _numbers(geom, "fromto", 6).reshape(2, 3)
        _set(geom, "fromto", stretch.move(ends, factor).ravel())
        return
    place, turn = _numbers(geom, "pos", 3), _numbers(geom, "quat", 4, "1 0 0 0")
    turn = turn / norm(turn)
    if "mesh" in geom.attrib:
        mesh = meshes[geom.attrib["mesh"]]
        points = np.array(mesh.get("vertex", "").split(), np.float64).reshape(-1, 3)
        moved = stretch.move(place + rotated(turn, points), factor)
        _set(mesh, "vertex", rotated(conjugate(turn), moved - place).ravel())
        return
    size = np.array(geom.get("size", "").split(), np.float64)
    axes = rotated(turn, np.eye(3))  # each row is an axis
    cosines = np.abs(axes @ stretch.along)
    cosines[: 0 if len(size) == 3 else 2] = 0.0  # capsules and cylinders have z alone
    axis = int(np.argmax(cosines))
    index = axis if len(size) == 3 else 1
    if len(size) > 1 and cosines[axis] > ALIGNED:
        ends = stretch.move(place + np.array([[1.0], [-1.0]]) * size[index] * axes[axis], factor)
        size[index] = float(norm(ends[0] - ends[1])) / 2
        _set(geom, "size", size)
        _set(geom, "pos", ends.mean(axis=0))
    else:
        _set(geom, "pos", stretch.move(place, factor))


def _inertia(inertial: Element) -> tuple[float, Floats, Floats]:
    """Return mass, centre, (3,) m, and inertia about the centre, (3, 3) kg m², in the link."""
    if "fullinertia" in inertial.attrib:
        xx, yy, zz, xy, xz, yz = _numbers(inertial, "fullinertia", 6)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        turn = _numbers(inertial, "quat", 4, "1 0 0 0")
        axes = rotated(turn / norm(turn), np.eye(3))
        inertia = axes.T @ (_numbers(inertial, "diaginertia", 3)[:, None] * axes)
    return float(inertial.get("mass", "0")), _numbers(inertial, "pos", 3), inertia


def _set_inertia(inertial: Element, mass: float, centre: Floats, inertia: Floats) -> None:
    for name in ("quat", "diaginertia"):
        inertial.attrib.pop(name, None)
    inertial.set("mass", repr(mass))
    _set(inertial, "pos", centre)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    _set(inertial, "fullinertia", np.array([xx, yy, zz, xy, xz, yz]))


def _steiner(mass: float, shift: Floats) -> Floats:
    """Return the inertia of a point mass about a point at a distance, (3, 3) kg m²."""
    return np.asarray(mass * ((shift * shift).sum() * np.eye(3) - np.outer(shift, shift)))


def _numbers(element: Element, key: str, count: int, default: str = "") -> Floats:
    words = element.get(key, default).split()
    return np.array(words, np.float64) if words else np.zeros(count)


def _set(element: Element, key: str, values: Floats) -> None:
    element.set(key, " ".join(map(repr, values.tolist())))


def _length_help(name: str) -> str:
    kind = name.rpartition(".")[2]
    if kind == "foot":
        return "height of the feet below the ankles"
    return (
        f"length of the {kind}s" if kind in (*NAMES[3], *INSECT[3], "leg") else f"length of {kind}"
    )

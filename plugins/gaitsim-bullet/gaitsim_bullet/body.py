"""A robot in PyBullet, at rest in its standing pose on the ground."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from gaitsim.plugin import conjugate, product, rotated
from gaitsim_bullet.client import Client
from gaitsim_bullet.ground import BASE, FlatGround, GroundContact
from gaitsim_bullet.multibody import RATIO, TRUNK, create_links
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.shapes import geom_surface
from gaitsim_robot.simulation import Simulation
from gaitsim_robot.terrain import GROUND

STRONG = 1e9  # N m, largest torque of gears
FAST = 1e9  # rad/s, largest speed of rotors


class BulletBody:
    """A robot and its ground.

    Args:
        client: an empty world.
        simulation: simulation of the robot.

    Attributes:
        links: all links except the trunk.
        moving: indices of the links with joints, (joints,).
        joints: numbers of these joints in MuJoCo, (joints,).
        number: number of the robot in the client.
        ground: the ground.
    """

    def __init__(self, client: Client, simulation: Simulation) -> None:
        self.client, self.simulation = client, simulation
        model = self.model = simulation.model
        self.links = create_links(simulation)
        self.moving = [index for index, link in enumerate(self.links) if link.joint >= 0]
        self.joints = np.array([self.links[index].joint for index in self.moving], np.intp)
        self._angles, self._speeds = model.jnt_qposadr[self.joints], model.jnt_dofadr[self.joints]
        client.setGravity(*model.opt.gravity.tolist())
        with TemporaryDirectory() as folder:  # a body of several shapes needs its meshes as files
            self.number = self._create(folder)
        self._set_dynamics()
        self._connect_gears()
        self.ground = self._create_ground()
        self._enable_self_contacts()
        self._set_pose()

    def state(self) -> tuple[Floats, Floats]:
        """Return the coordinates and speeds in MuJoCo's order, (nq,) and (nv,)."""
        client, model = self.client, self.model
        qpos, qvel = self.simulation.start[1 : 1 + model.nq].copy(), np.zeros(model.nv)
        place, turn = client.getBasePositionAndOrientation(self.number)
        speed, spin = map(np.array, client.getBaseVelocity(self.number))
        qpos[3:7] = product(_wxyz(turn), conjugate(model.body_iquat[TRUNK]))
        # Bullet's base is the centre of mass, whose velocity differs from the origin's.
        centre = rotated(qpos[3:7], model.body_ipos[TRUNK])
        qpos[:3] = place - centre
        qvel[:3] = speed - np.cross(spin, centre)
        qvel[3:6] = rotated(conjugate(qpos[3:7]), spin)
        qpos[self._angles], qvel[self._speeds] = self.angles()
        return qpos, qvel

    def angles(self) -> tuple[Floats, Floats]:
        """Return the angles of the joints relative to the file's zero, and speeds, (joints,)."""
        found = self.client.getJointStates(self.number, self.moving) or ()  # None without joints
        angles = np.array([state[0] for state in found])
        speeds = np.array([state[1] for state in found])
        return angles + self.model.qpos0[self._angles], speeds

    def step(self, torques: Floats) -> dict[int, GroundContact]:
        """Simulate a step with torques, (joints,) N m; return its `FlatGround.contacts`."""
        client = self.client
        client.setJointMotorControlArray(
            self.number, self.moving, client.TORQUE_CONTROL, forces=torques.tolist()
        )
        client.stepSimulation()
        return self.ground.contacts()

    def push(self, change: Floats) -> None:
        """Change the velocity of the trunk, (3,) m/s."""
        speed, spin = self.client.getBaseVelocity(self.number)
        self.client.resetBaseVelocity(self.number, (change + speed).tolist(), spin)

    def _create(self, folder: str) -> int:
        client, model, links = self.client, self.model, self.links
        kinds = {
            "fixed": client.JOINT_FIXED,
            "hinge": client.JOINT_REVOLUTE,
            "slide": client.JOINT_PRISMATIC,
        }
        number: int = client.createMultiBody(
            baseMass=float(model.body_mass[TRUNK]),
            baseCollisionShapeIndex=self._shape(TRUNK, np.zeros(3), folder),
            baseInertialFramePosition=model.body_ipos[TRUNK].tolist(),
            baseInertialFrameOrientation=_xyzw(model.body_iquat[TRUNK]),
            linkMasses=[link.inertia.mass for link in links],
            linkCollisionShapeIndices=[
                self._shape(link.body, link.origin, folder) for link in links
            ],
            linkVisualShapeIndices=[-1] * len(links),
            linkPositions=[link.place.tolist() for link in links],
            linkOrientations=[_xyzw(link.turn) for link in links],
            linkInertialFramePositions=[link.inertia.centre.tolist() for link in links],
            linkInertialFrameOrientations=[_xyzw(link.inertia.turn) for link in links],
            linkParentIndices=[link.parent + 1 for link in links],
            linkJointTypes=[kinds[link.kind] for link in links],
            linkJointAxis=[link.axis.tolist() for link in links],
            flags=client.URDF_USE_SELF_COLLISION,
        )
        return number

    def _shape(self, body: int, origin: Floats, folder: str) -> int:
        """Create shapes for a body's colliding geoms; write meshes to files in `folder`."""
        import mujoco
        from scipy.spatial import ConvexHull

        client, model, kinds = self.client, self.model, mujoco.mjtGeom
        shapes: dict[str, list[Any]] = {}
        for geom in self._geoms(body):
            kind, size = kinds(int(model.geom_type[geom])), model.geom_size[geom].tolist()
            shape: dict[str, Any] = {"radii": 0.0, "lengths": 0.0, "halfExtents": [0.0, 0.0, 0.0]}
            shape |= {"fileNames": "", "meshScales": [1.0, 1.0, 1.0]}
            if kind == kinds.mjGEOM_SPHERE:
                shape |= {"shapeTypes": client.GEOM_SPHERE, "radii": size[0]}
            elif kind == kinds.mjGEOM_BOX:
                shape |= {"shapeTypes": client.GEOM_BOX, "halfExtents": size}
            elif kind in (kinds.mjGEOM_CAPSULE, kinds.mjGEOM_CYLINDER):
                round_ = kind == kinds.mjGEOM_CAPSULE
                shape |= {
                    "shapeTypes": client.GEOM_CAPSULE if round_ else client.GEOM_CYLINDER,
                    "radii": size[0],
                    "lengths": 2 * size[1],
                }
            else:  # a mesh or an ellipsoid, which collides with its convex hull
                points = geom_surface(model, geom)[0]
                path = Path(folder) / f"{geom}.obj"
                path.write_text(_mesh(points[ConvexHull(points).vertices]), encoding="ascii")
                shape |= {"shapeTypes": client.GEOM_MESH, "fileNames": str(path)}
            shape["collisionFramePositions"] = (model.geom_pos[geom] + origin).tolist()
            shape["collisionFrameOrientations"] = _xyzw(model.geom_quat[geom])
            for name, value in shape.items():
                shapes.setdefault(name, []).append(value)
        if not shapes:
            return -1
        found: int = client.createCollisionShapeArray(**shapes)
        return found

    def _geoms(self, body: int) -> list[int]:
        """Return the colliding geoms of a body; none for -1."""
        model = self.model
        collide = (model.geom_contype | model.geom_conaffinity) != 0
        return list(map(int, np.flatnonzero((model.geom_bodyid == body) & collide)))

    def _set_dynamics(self) -> None:
        client, model = self.client, self.model
        # These values apply to the whole robot; all others in the same call only to the trunk.
        client.changeDynamics(
            self.number, BASE, linearDamping=0.0, angularDamping=0.0, maxJointVelocity=FAST
        )
        for index, link in enumerate((None, *self.links), BASE):
            friction = self._friction(link.body if link else TRUNK)
            client.changeDynamics(self.number, index, lateralFriction=friction)
            moments = link.inertia.moments if link else model.body_inertia[TRUNK]
            client.changeDynamics(self.number, index, localInertiaDiagonal=moments.tolist())

    def _connect_gears(self) -> None:
        """Connect rotors to joints by gears, and set the friction and limits of joints."""
        client, model = self.client, self.model
        for index, link in enumerate(self.links):
            if link.kind == "fixed":
                continue
            friction = 0.0
            if link.joint >= 0:
                friction = float(model.dof_frictionloss[model.jnt_dofadr[link.joint]])
                if model.jnt_limited[link.joint]:
                    zero = model.qpos0[model.jnt_qposadr[link.joint]]
                    lower, upper = (model.jnt_range[link.joint] - zero).tolist()
                    client.changeDynamics(
                        self.number, index, jointLowerLimit=lower, jointUpperLimit=upper
                    )
            client.setJointMotorControl2(
                self.number, index, client.VELOCITY_CONTROL, force=friction
            )
            if link.geared >= 0:
                ends, middle = (self.number, link.geared, self.number, index), [0.0, 0.0, 0.0]
                gears = client.createConstraint(
                    *ends, client.JOINT_GEAR, link.axis.tolist(), middle, middle
                )
                client.changeConstraint(gears, gearRatio=1 / RATIO, maxForce=STRONG, erp=0.0)

    def _friction(self, body: int) -> float:
        """Return the friction of a body on the ground."""
        model = self.model
        ground = model.geom(GROUND).friction[0]
        return float(max([ground, *model.geom_friction[self._geoms(body), 0]]))

    def _bodies(self) -> list[tuple[int, int]]:
        """Return the links with a body: their indices, and MuJoCo's numbers of the bodies."""
        linked = [(index, link.body) for index, link in enumerate(self.links) if link.body >= 0]
        return [(BASE, TRUNK), *linked]

    def _create_ground(self) -> FlatGround:
        """Create the ground for the bodies that collide with it in MuJoCo."""
        client, anatomy = self.client, self.simulation.anatomy
        ground = [int(self.model.geom(GROUND).id)]
        meeting = {
            index: self._friction(body)
            for index, body in self._bodies()
            if self._may_collide(self._geoms(body), ground)
        }
        dt = client.getPhysicsEngineParameters()["fixedTimeStep"]
        resistance = anatomy.mass / max(1, len(anatomy.legs)) / dt
        return FlatGround(client, self.number, meeting, len(self.links), resistance)

    def _enable_self_contacts(self) -> None:
        """Enable collisions for the same pairs of the robot's bodies as in MuJoCo."""
        client, model, bodies = self.client, self.model, self._bodies()
        excluded = {(one >> 16, one & 0xFFFF) for one in model.exclude_signature.tolist()}
        excluded |= {(other, one) for one, other in excluded}
        for position, (index, body) in enumerate(bodies):
            for second, other in bodies[:position]:
                meets = self._may_collide(self._geoms(body), self._geoms(other))
                meets &= (body, other) not in excluded and not self._related(body, other)
                client.setCollisionFilterPair(self.number, self.number, index, second, int(meets))

    def _may_collide(self, geoms: list[int], others: list[int]) -> bool:
        kinds, affine = self.model.geom_contype, self.model.geom_conaffinity
        meets = (kinds[geoms, None] & affine[others]) | (affine[geoms, None] & kinds[others])
        return bool(meets.any())

    def _related(self, body: int, other: int) -> bool:
        """Return whether two bodies are fixed together, or one directly carries the other."""
        welded, parents = self.model.body_weldid, self.model.body_parentid
        one, two = welded[body], welded[other]
        return bool(one == two or welded[parents[one]] == two or welded[parents[two]] == one)

    def _set_pose(self) -> None:
        client, model = self.client, self.model
        qpos = self.simulation.start[1 : 1 + model.nq]
        zero = model.qpos0[self._angles]
        for link, angle in zip(self.moving, qpos[self._angles] - zero, strict=True):
            client.resetJointState(self.number, link, float(angle))
        place = qpos[:3] + rotated(qpos[3:7], model.body_ipos[TRUNK])
        turn = product(qpos[3:7], model.body_iquat[TRUNK])
        client.resetBasePositionAndOrientation(self.number, place.tolist(), _xyzw(turn))


def _mesh(points: Floats) -> str:
    """Return the convex hull of its corners as an OBJ file."""
    from scipy.spatial import ConvexHull

    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    faces = (ConvexHull(points).simplices + 1).tolist()
    return "\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in faces), ""])


def _xyzw(turn: Floats) -> list[float]:
    """Return a quaternion in Bullet's order."""
    return [*turn[1:].tolist(), float(turn[0])]


def _wxyz(turn: tuple[float, ...]) -> Floats:
    """Return Bullet's quaternion in MuJoCo's order."""
    return np.array([turn[3], *turn[:3]])

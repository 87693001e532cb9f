"""One walker's rollout in pymunk: servos, physics, what is recorded, and the fall.

Every individual gets a space of its own, built anew: nothing that the solver remembers, such as
the impulses that it starts from, passes from one to the next.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gaitsim_walker import body
from gaitsim_walker.body import Floats, Plan
from gaitsim_walker.encodings import FRAME_RATE
from gaitsim_walker.ground import Ground

if TYPE_CHECKING:
    import pymunk

STEPS = 4  # of the physics a frame
STEP = 1 / (STEPS * FRAME_RATE)  # s: 240 Hz
ITERATIONS = 20  # of the solver a step
GAIN = 15.0  # 1/s: speed that a servo asks for a radian that it is off
FASTEST = 30.0  # m/s; a body that is faster has left what the step can follow
TIPPED = math.radians(60)  # pitch from which a walker has fallen


@dataclass(frozen=True)
class World:
    """What a walker walks in and on.

    Attributes:
        plan: of the body.
        ground: that it walks on.
        gravity: m/s².
        friction: of feet on the ground.
        torque_limit: of each servo, N m.
        speed_limit: of each servo, rad/s.
    """

    plan: Plan
    ground: Ground
    gravity: float
    friction: float
    torque_limit: float
    speed_limit: float


@dataclass(frozen=True, eq=False)
class Rollout:
    """What one walker did, by frame; held still from the frame in which it fell.

    Attributes:
        position: x and z of the torso's middle, (frames, 2) m.
        velocity: of it, (frames, 2) m/s.
        pitch: of the torso, (frames,) rad.
        joints: where the joints really were, (frames, joints) rad.
        torque: size of the mean torque of each servo since the frame before, (frames, joints) N m.
        work: done on or by the servos since the start, both counted as spent, (frames,) J.
        load: x and z of the force of the ground on each foot, (frames, legs, 2) N.
        lasted: frames before the fall; all of them where there was none.
        failure: why the simulation could not be gone on with; empty where it could.
    """

    position: Floats
    velocity: Floats
    pitch: Floats
    joints: Floats
    torque: Floats
    work: Floats
    load: Floats
    lasted: int
    failure: str


class Machine:
    """A walker in a space of its own, in the pose that it is first told.

    Args:
        world: to walk in.
        pose: joint angles at the start, (joints,) rad.
    """

    def __init__(self, world: World, pose: Floats) -> None:
        import pymunk

        self.plan, self.world = world.plan, world
        self.space = pymunk.Space()
        self.space.gravity = (0.0, -world.gravity)
        self.space.iterations = ITERATIONS
        self.space.collision_slop = 1e-4  # m; pymunk's own 0.1 is meant for pixels
        self._lay(world.ground)
        turned = body.limb_angles(self.plan, pose)
        where = body.points(self.plan, np.zeros(2), np.zeros(()), pose)
        feet = where[:, 2]
        height = max(world.ground.height(float(x)) - float(z) + body.FOOT_RADIUS for x, z in feet)
        where[..., 1] += height
        width, depth = 2 * self.plan.half[0], 2 * self.plan.half[1]
        self.torso = pymunk.Body(
            body.TORSO_MASS, pymunk.moment_for_box(body.TORSO_MASS, (width, depth))
        )
        self.torso.position = (0.0, height)
        self.space.add(self.torso)
        self.limbs: list[pymunk.Body] = []
        self.motors: list[pymunk.SimpleMotor] = []
        self.rest: list[float] = []  # of each joint: the turn at angle 0, and which way it counts
        self.way: list[int] = []
        self.parents: list[pymunk.Body] = []
        for number, leg in enumerate(self.plan.legs):
            thigh = self._limb(body.THIGH_MASS, where[number, 0], turned[2 * number])
            shank = self._limb(body.SHANK_MASS, where[number, 1], turned[2 * number + 1])
            end = (0.0, -body.LIMB / 2)
            foot = pymunk.Circle(shank, body.FOOT_RADIUS, end)
            foot.friction = world.friction
            foot.filter = pymunk.ShapeFilter(group=1)  # legs pass each other
            self.space.add(foot)
            self._joint(self.torso, thigh, leg.hip, 1, leg.knee * body.BEND, body.HIP_LIMIT)
            self._joint(thigh, shank, end, -leg.knee, -leg.knee * 2 * body.BEND, body.KNEE_LIMIT)

    def _lay(self, ground: Ground) -> None:
        import pymunk

        corners = list(zip(ground.x, ground.z, strict=True))
        for number in range(len(corners) - 1):
            piece = pymunk.Segment(
                self.space.static_body, corners[number], corners[number + 1], 0.0
            )
            piece.friction = 1.0  # pymunk multiplies the two: a foot's own is what counts
            piece.set_neighbors(
                corners[max(number - 1, 0)], corners[min(number + 2, len(corners) - 1)]
            )
            self.space.add(piece)

    def _limb(self, mass: float, top: Floats, angle: float) -> "pymunk.Body":
        import pymunk

        half = body.LIMB / 2
        limb = pymunk.Body(mass, pymunk.moment_for_segment(mass, (0, -half), (0, half), 0))
        x, z = top.tolist()
        limb.position = (x + half * math.sin(angle), z - half * math.cos(angle))
        limb.angle = float(angle)
        self.space.add(limb)
        self.limbs.append(limb)
        return limb

    def _joint(
        self,
        above: "pymunk.Body",
        below: "pymunk.Body",
        at: tuple[float, float],
        way: int,
        rest: float,
        limit: float,
    ) -> None:
        import pymunk

        reach = limit + body.STOP
        pivot = pymunk.PivotJoint(above, below, at, (0.0, body.LIMB / 2))
        stop = pymunk.RotaryLimitJoint(above, below, rest - reach, rest + reach)
        motor = pymunk.SimpleMotor(above, below, 0.0)
        motor.max_force = self.world.torque_limit
        self.space.add(pivot, stop, motor)
        self.motors.append(motor)
        self.rest.append(rest)
        self.way.append(way)
        self.parents.append(above)

    def fallen(self) -> bool:
        """Whether the torso or a knee is on the ground, or the torso has tipped over."""
        pitch, (x, z) = self.torso.angle, self.torso.position
        if abs(pitch) > TIPPED:
            return True
        height = self.world.ground.height
        cos, sin = math.cos(pitch), math.sin(pitch)
        half_x, half_z = self.plan.half
        for side in (half_x, -half_x):
            corner = x + side * cos + half_z * sin
            if z + side * sin - half_z * cos < height(corner):
                return True
        for thigh in self.limbs[0::2]:
            x, z = thigh.position
            angle = thigh.angle
            knee = z - body.LIMB / 2 * math.cos(angle) - body.KNEE_RADIUS
            if knee < height(x + body.LIMB / 2 * math.sin(angle)):
                return True
        return False

    def loads(self) -> list[tuple[float, float]]:
        """Force of the ground on each foot in the last step, x and z in N."""
        import pymunk

        found: list[tuple[float, float]] = []

        def add(arbiter: pymunk.Arbiter) -> None:
            x, z = arbiter.total_impulse
            way = math.copysign(1.0, z) / STEP  # which of the two it pushes is pymunk's affair
            forces.append((x * way, z * way))

        for shank in self.limbs[1::2]:
            forces: list[tuple[float, float]] = []
            shank.each_arbiter(add)
            found.append((sum(x for x, _ in forces), sum(z for _, z in forces)))
        return found


def roll_out(world: World, commands: Floats) -> Rollout:
    """Walk by what the servos are told.

    A servo turns towards its command at GAIN times what it is off, at most at its speed limit,
    with as much torque as that takes, at most its torque limit.

    Args:
        world: to walk in.
        commands: (frames, joints) rad, within the limits; the first is the pose at the start.
    """
    frames, joints = commands.shape
    machine = Machine(world, commands[0])
    torso = machine.torso
    bodies = [torso, *machine.limbs]
    place = {id(part): number for number, part in enumerate(bodies)}
    # Each body's angle is read once a step, not once a joint: pymunk's properties cost most.
    parts = [
        (motor, place[id(above)], below, rest, way)
        for below, (motor, above, rest, way) in enumerate(
            zip(machine.motors, machine.parents, machine.rest, machine.way, strict=True), start=1
        )
    ]
    step, fastest = machine.space.step, world.speed_limit
    state, torque = np.zeros((frames, 5)), np.zeros((frames, joints))
    turned, work = np.zeros((frames, joints)), np.zeros(frames)
    load = np.zeros((frames, joints // 2, 2))
    lasted, failure, spent = frames, "", 0.0
    told = commands.tolist()
    for frame in range(frames):
        if frame:
            targets = [
                rest + way * told[frame][joint] for joint, (_, _, _, rest, way) in enumerate(parts)
            ]
            sums = [0.0] * joints
            for _ in range(STEPS):
                angles = [part.angle for part in bodies]
                for (motor, above, below, _, _), target in zip(parts, targets, strict=True):
                    off = GAIN * (angles[above] + target - angles[below])
                    motor.rate = -min(max(off, -fastest), fastest)
                step(STEP)
                speeds = [part.angular_velocity for part in bodies]
                for joint, (motor, above, below, _, _) in enumerate(parts):
                    pushed = motor.impulse
                    sums[joint] += pushed
                    spent += pushed * abs(speeds[below] - speeds[above])
            torque[frame] = sums
        position, velocity = torso.position, torso.velocity
        state[frame] = (*position, *velocity, torso.angle)
        turned[frame] = [
            way * (bodies[below].angle - bodies[above].angle - rest)
            for _, above, below, rest, way in parts
        ]
        work[frame] = spent
        load[frame] = machine.loads()
        if not (abs(velocity.x) < FASTEST and abs(velocity.y) < FASTEST):  # nor may it be NaN
            failure = f"the simulation broke down after {frame / FRAME_RATE:.3g} s"
        if failure or machine.fallen():
            lasted = frame
            break
    torque *= FRAME_RATE
    if lasted < frames:
        kept = max(lasted - 1, 0) if failure else lasted
        for record in (state, turned, work, load):
            record[lasted:] = record[kept]
        state[lasted:, 2:4] = 0.0
        load[lasted:], torque[lasted:] = 0.0, 0.0
    return Rollout(
        state[:, :2], state[:, 2:4], state[:, 4], turned, torque, work, load, lasted, failure
    )

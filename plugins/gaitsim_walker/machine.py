"""The walker in pymunk: its bodies, joints, servos and feet, and the motion of its rollouts.

Every individual gets a new space, so that no state of the solver, such as its initial impulses,
passes from one individual to the next.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pymunk

from gaitsim.plugin import Array, Motion
from gaitsim.plugin.toolkit import STRIDE_FREQUENCY
from gaitsim_walker import body
from gaitsim_walker.body import FRAME_RATE, Floats, WalkerPlan
from gaitsim_walker.surroundings import Ground, Surroundings

ITERATIONS = 20  # iterations of the solver in each step
TIPPED = math.radians(60)  # pitch from which a walker has fallen


@dataclass(frozen=True)
class WalkerJoint:
    """A hinge with its servo.

    Attributes:
        motor: pymunk's motor, which turns at a set rate with limited torque.
        above: index of the body on which the joint is mounted.
        below: index of the body that the joint turns.
        rest: angle between both bodies at the joint's angle 0, rad.
        sign: sign of the joint's angle relative to pymunk's, 1 or −1.
    """

    motor: pymunk.SimpleMotor
    above: int
    below: int
    rest: float
    sign: int


class Machine:
    """A walker in its own pymunk space, in the pose of the first command.

    Args:
        surroundings: body, ground and servos.
        pose: joint angles at the start, (joints,) rad.

    Attributes:
        space: the space.
        bodies: the torso, then thigh and shank of each leg; those of lost legs are not in the
            space.
        joints: hip and knee of each leg.
    """

    def __init__(self, surroundings: Surroundings, pose: Floats) -> None:
        self.plan, self.surroundings = surroundings.plan, surroundings
        self.space = pymunk.Space()
        slope, gravity = surroundings.slope, surroundings.gravity
        self.space.gravity = (-gravity * math.sin(slope), -gravity * math.cos(slope))
        self.space.iterations = ITERATIONS
        self.space.collision_slop = 1e-4  # m; pymunk's default of 0.1 is meant for pixels
        self._add_ground(surroundings.ground)
        turned = body.limb_angles(self.plan, pose)
        where = body.leg_points(self.plan, np.zeros(2), np.zeros(()), pose)
        feet = where[:, 2]
        lost = surroundings.damage.lost.tolist()
        height = max(
            surroundings.ground.height(float(x)) - float(z) + body.FOOT_RADIUS
            for x, z in feet[~surroundings.damage.lost]
        )
        where[..., 1] += height
        width, depth = 2 * self.plan.half[0], 2 * self.plan.half[1]
        mass = surroundings.mass * self.plan.torso_mass
        torso = pymunk.Body(mass, pymunk.moment_for_box(mass, (width, depth)))
        torso.position = (0.0, height)
        self.space.add(torso)
        self.bodies = [torso]
        self.joints: list[WalkerJoint] = []
        for number, leg in enumerate(self.plan.legs):
            thigh, shank = (
                self._add_limb(part, where[number, part], turned[2 * number + part])
                for part in (0, 1)
            )
            top, end = (0.0, self.plan.limbs[1] / 2), (0.0, -self.plan.limbs[1] / 2)
            foot = pymunk.Circle(self.bodies[shank], body.FOOT_RADIUS, end)
            foot.friction = surroundings.friction
            foot.filter = pymunk.ShapeFilter(group=1)  # the legs do not collide with each other
            rest, bent = leg.knee * self.plan.bends[0], -leg.knee * 2 * body.BEND
            half = self.plan.limbs[0] / 2
            hip = self._add_joint(0, leg.hip, thigh, (0.0, half), rest, 1, body.HIP_LIMIT)
            knee = self._add_joint(
                thigh, (0.0, -half), shank, top, bent, -leg.knee, body.KNEE_LIMIT
            )
            if not lost[number]:
                self.space.add(self.bodies[thigh], self.bodies[shank], foot, *hip, *knee)

    def _add_ground(self, ground: Ground) -> None:
        corners = list(zip(ground.x, ground.z, strict=True))
        for number in range(len(corners) - 1):
            piece = pymunk.Segment(
                self.space.static_body, corners[number], corners[number + 1], 0.0
            )
            piece.friction = 1.0  # pymunk multiplies it by the foot's friction
            piece.set_neighbors(
                corners[max(number - 1, 0)], corners[min(number + 2, len(corners) - 1)]
            )
            self.space.add(piece)

    def _add_limb(self, part: int, top: Floats, angle: float) -> int:
        """Add a thigh, 0, or a shank, 1, that hangs from `top`, and return its index."""
        half, mass = self.plan.limbs[part] / 2, self.surroundings.mass * self.plan.limb_masses[part]
        limb = pymunk.Body(mass, pymunk.moment_for_segment(mass, (0, -half), (0, half), 0))
        x, z = top.tolist()
        limb.position = (x + half * math.sin(angle), z - half * math.cos(angle))
        limb.angle = float(angle)
        self.bodies.append(limb)
        return len(self.bodies) - 1

    def _add_joint(
        self,
        above: int,
        at: tuple[float, float],
        below: int,
        top: tuple[float, float],
        rest: float,
        sign: int,
        limit: float,
    ) -> tuple[pymunk.Constraint, ...]:
        one, other, reach = self.bodies[above], self.bodies[below], limit + body.STOP
        damage, number = self.surroundings.damage, len(self.joints)
        low, high = rest - reach, rest + reach
        if number in damage.held:
            low = high = rest + sign * damage.held[number]
        motor = pymunk.SimpleMotor(one, other, 0.0)
        motor.max_force = self.surroundings.torque_limit * float(damage.torque[number])
        self.joints.append(WalkerJoint(motor, above, below, rest, sign))
        pivot = pymunk.PivotJoint(one, other, at, top)
        return pivot, pymunk.RotaryLimitJoint(one, other, low, high), motor

    def joint_angles(self) -> list[float]:
        """Return the current joint angles, rad."""
        angles = [part.angle for part in self.bodies]
        return [
            joint.sign * (angles[joint.below] - angles[joint.above] - joint.rest)
            for joint in self.joints
        ]

    def fallen(self) -> bool:
        """Return whether the torso or a knee touches the ground, or the torso has tipped over."""
        torso = self.bodies[0]
        pitch, (x, z) = torso.angle, torso.position
        if abs(pitch) > TIPPED:
            return True
        height = self.surroundings.ground.height
        cos, sin = math.cos(pitch), math.sin(pitch)
        half_x, half_z = self.plan.half
        for side in (half_x, -half_x):
            corner = x + side * cos + half_z * sin
            if z + side * sin - half_z * cos < height(corner):
                return True
        half = self.plan.limbs[0] / 2
        for thigh, lost in zip(self.bodies[1::2], self.surroundings.damage.lost, strict=True):
            if lost:
                continue
            x, z = thigh.position
            angle = thigh.angle
            knee = z - half * math.cos(angle) - body.KNEE_RADIUS
            if knee < height(x + half * math.sin(angle)):
                return True
        return False

    def loads(self) -> list[tuple[float, float]]:
        """Return the force of the ground on each foot in the last step, x and z in N."""
        found: list[tuple[float, float]] = []

        def add(arbiter: pymunk.Arbiter) -> None:
            x, z = arbiter.total_impulse
            # The sign depends on which body comes first, which pymunk does not guarantee.
            scale = math.copysign(1.0, z) / self.surroundings.step
            forces.append((x * scale, z * scale))

        for shank in self.bodies[2::2]:
            forces: list[tuple[float, float]] = []
            shank.each_arbiter(add)
            found.append((sum(x for x, _ in forces), sum(z for _, z in forces)))
        return found


GAIN = 15.0  # 1/s, speed of a servo per radian of error
FASTEST = 30.0  # m/s, speed of the torso above which the simulation is unstable


@dataclass(frozen=True, eq=False)
class Rollout:
    """The recorded frames of one walker.

    After a fall, positions, angles and work stay constant, and all other quantities are 0.

    Attributes:
        position: x and z of the torso's middle, (frames, 2) m.
        velocity: velocity of the torso's middle, (frames, 2) m/s.
        pitch: pitch of the torso, (frames,) rad.
        joints: actual joint angles, (frames, joints) rad.
        torque: magnitude of each servo's mean torque since the previous frame, (frames, joints)
            N m.
        work: work of the servos since the start, (frames,) J; braking counts as positive.
        load: x and z of the force of the ground on each foot, (frames, legs, 2) N.
        lasted: number of frames before the fall, or of all frames.
        failure: message about an unstable simulation, or ''.
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


def roll_out(surroundings: Surroundings, commands: Floats) -> Rollout:
    """Simulate one walker with the given servo commands.

    A servo turns towards its command at a speed of GAIN times its error, up to its speed limit,
    with the torque that this requires, up to its torque limit.

    Args:
        surroundings: body, ground and servos.
        commands: (frames, joints) rad, within the limits. The first is the initial pose, to which
            the errors of the joints are added.
    """
    frames, joints = commands.shape
    machine = Machine(surroundings, surroundings.pose(commands[0]))
    bodies, torso, hinges = machine.bodies, machine.bodies[0], machine.joints
    # Read the bodies once per step, not per joint: pymunk's properties take most of the time.
    fastest = (surroundings.speed_limit * surroundings.damage.speed).tolist()
    parts = [
        (hinge.motor, hinge.above, hinge.below, speed)
        for hinge, speed in zip(hinges, fastest, strict=True)
    ]
    step, dt = machine.space.step, surroundings.step
    state, torque = np.zeros((frames, 5)), np.zeros((frames, joints))
    turned, work = np.zeros((frames, joints)), np.zeros(frames)
    load = np.zeros((frames, joints // 2, 2))
    lasted, failure, spent = frames, "", 0.0
    rest, sign = (np.array([getattr(one, name) for one in hinges]) for name in ("rest", "sign"))
    targets_by_step = (rest + sign * surroundings.targets(commands)).tolist()
    pushed_in, push = surroundings.push
    for frame in range(frames):
        if frame:
            last = frame * surroundings.steps
            sums = [0.0] * joints
            for targets in targets_by_step[last - surroundings.steps : last]:
                angles = [part.angle for part in bodies]
                for (motor, above, below, speed), target in zip(parts, targets, strict=True):
                    off = GAIN * (angles[above] + target - angles[below])
                    motor.rate = -min(max(off, -speed), speed)
                step(dt)
                speeds = [part.angular_velocity for part in bodies]
                for joint, (motor, above, below, _) in enumerate(parts):
                    pushed = motor.impulse
                    sums[joint] += pushed
                    spent += pushed * abs(speeds[below] - speeds[above])
            torque[frame] = sums
        position, velocity = torso.position, torso.velocity
        state[frame] = (*position, *velocity, torso.angle)
        turned[frame] = machine.joint_angles()
        work[frame] = spent
        load[frame] = machine.loads()
        if not (abs(velocity.x) < FASTEST and abs(velocity.y) < FASTEST):  # true for NaN, too
            failure = f"the simulation became unstable after {frame / FRAME_RATE:.3g} s"
        if failure or machine.fallen():
            lasted = frame
            break
        if push and frame == pushed_in:
            for part in bodies:
                part.velocity += (push, 0.0)
    torque *= FRAME_RATE
    turned[:, np.repeat(surroundings.damage.lost, 2)] = 0.0
    if lasted < frames:
        kept = max(lasted - 1, 0) if failure else lasted
        for record in (state, turned, work, load):
            record[lasted:] = record[kept]
        state[lasted:, 2:4] = 0.0
        load[lasted:], torque[lasted:] = 0.0, 0.0
    return Rollout(
        state[:, :2], state[:, 2:4], state[:, 4], turned, torque, work, load, lasted, failure
    )


def walk(
    surroundings: Surroundings, plans: Sequence[WalkerPlan], commands: Floats, frequency: Floats
) -> Motion:
    """Simulate walkers one after the other, and return their motion.

    Args:
        surroundings: ground, servos and damage; each walker is simulated separately.
        plans: build of each walker.
        commands: servo commands of each walker, (population, frames, joints) rad.
        frequency: stride frequency of the commands, (population,) Hz; 0 if unknown.
    """
    each = [replace(surroundings, plan=plan) for plan in plans]
    commanded, rolled = [], []
    for own, wanted in zip(each, commands, strict=True):
        rollout = roll_out(own, wanted)
        held = wanted.copy()
        held[rollout.lasted :] = wanted[min(rollout.lasted, len(wanted) - 1)]
        commanded.append(held)
        rolled.append(rollout)
    measured = [_measured(own, rollout) for own, rollout in zip(each, rolled, strict=True)]

    def all_of(name: str) -> Array:
        return np.stack([getattr(rollout, name) for rollout in rolled])

    position, velocity = (body.to_3d(all_of("position")), body.to_3d(all_of("velocity")))
    load, pitch = all_of("load"), all_of("pitch")
    lasted = np.array([max(rollout.lasted, 1) - 1 for rollout in rolled]) / FRAME_RATE
    return Motion(
        FRAME_RATE,
        {
            "joint_angles": np.stack(commanded),
            "joint_positions": all_of("joints"),
            "torque": all_of("torque"),
            "stall_torque": np.tile(
                surroundings.torque_limit * surroundings.damage.torque, (len(rolled), 1)
            ),
            "torso": position,
            "torso_velocity": velocity,
            "pitch": pitch,
            "orientation": np.stack([np.zeros_like(pitch), -pitch, np.zeros_like(pitch)], axis=-1),
            "height": np.stack([height for height, _, _ in measured]),
            "foot_positions": np.stack([feet for _, feet, _ in measured]),
            "stance": load[..., 1] > 0,
            "load": load,
            "slip": np.stack([slip for _, _, slip in measured]),
            "energy": all_of("work"),
            STRIDE_FREQUENCY: np.asarray(frequency, np.float64),
            "lasted": lasted,
            "weight": np.array([own.weight for own in each]),
            "length": np.array([plan.length for plan in plans]),
        },
        failures={i: rollout.failure for i, rollout in enumerate(rolled) if rollout.failure},
    )


def _measured(surroundings: Surroundings, rollout: Rollout) -> tuple[Floats, Floats, Floats]:
    """Return height (frames,), feet (frames, legs, 3) and slip (frames,) of one walker, m.

    They are computed for one walker at a time, so that array shapes, and hence rounding, do not
    depend on the population.
    """
    plan = surroundings.plan
    points = body.leg_points(plan, rollout.position, rollout.pitch, rollout.joints)
    feet = np.where(surroundings.damage.lost[:, None], points[:, :, 0], points[:, :, 2])
    turned = body.limb_angles(plan, rollout.joints)[:, 1::2] + rollout.pitch[:, None]
    # A round foot that rolls without sliding moves back as its shank turns forward.
    slid = np.abs(np.diff(feet[..., 0], axis=0) + body.FOOT_RADIUS * np.diff(turned, axis=0))
    stance = rollout.load[..., 1] > 0
    standing = stance[1:] & stance[:-1]
    slip = np.zeros(len(feet))
    slip[1:] = (slid * standing).sum(axis=1) / np.maximum(standing.sum(axis=1), 1)
    below = [surroundings.ground.height(x) for x in rollout.position[:, 0].tolist()]
    return rollout.position[:, 1] - np.array(below), body.to_3d(feet), slip

"""The walker in pymunk: its bodies, joints, servos and feet, and the ground under them.

Every individual gets a new space, so that no state of the solver, such as its initial impulses,
passes from one individual to the next.
"""

import math
from dataclasses import dataclass

import numpy as np
import pymunk

from gaitsim_walker import body
from gaitsim_walker.body import Floats
from gaitsim_walker.ground import Ground
from gaitsim_walker.surroundings import Surroundings

ITERATIONS = 20  # iterations of the solver in each step
TIPPED = math.radians(60)  # pitch from which a walker has fallen


@dataclass(frozen=True)
class Joint:
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
        bodies: the torso, then thigh and shank of each leg.
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
        height = max(
            surroundings.ground.height(float(x)) - float(z) + body.FOOT_RADIUS for x, z in feet
        )
        where[..., 1] += height
        width, depth = 2 * self.plan.half[0], 2 * self.plan.half[1]
        mass = surroundings.mass * body.TORSO_MASS
        torso = pymunk.Body(mass, pymunk.moment_for_box(mass, (width, depth)))
        torso.position = (0.0, height)
        self.space.add(torso)
        self.bodies = [torso]
        self.joints: list[Joint] = []
        for number, leg in enumerate(self.plan.legs):
            top, end = (0.0, body.LIMB / 2), (0.0, -body.LIMB / 2)
            thigh = self._add_limb(body.THIGH_MASS, where[number, 0], turned[2 * number])
            shank = self._add_limb(body.SHANK_MASS, where[number, 1], turned[2 * number + 1])
            foot = pymunk.Circle(self.bodies[shank], body.FOOT_RADIUS, end)
            foot.friction = surroundings.friction
            foot.filter = pymunk.ShapeFilter(group=1)  # the legs do not collide with each other
            self.space.add(foot)
            self._add_joint(0, leg.hip, thigh, top, leg.knee * body.BEND, 1, body.HIP_LIMIT)
            self._add_joint(
                thigh,
                end,
                shank,
                top,
                -leg.knee * 2 * body.BEND,
                -leg.knee,
                body.KNEE_LIMIT,
            )

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

    def _add_limb(self, nominal_mass: float, top: Floats, angle: float) -> int:
        """Add a limb that hangs from `top` and return its index."""
        half, mass = body.LIMB / 2, self.surroundings.mass * nominal_mass
        limb = pymunk.Body(mass, pymunk.moment_for_segment(mass, (0, -half), (0, half), 0))
        x, z = top.tolist()
        limb.position = (x + half * math.sin(angle), z - half * math.cos(angle))
        limb.angle = float(angle)
        self.space.add(limb)
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
    ) -> None:
        one, other, reach = self.bodies[above], self.bodies[below], limit + body.STOP
        motor = pymunk.SimpleMotor(one, other, 0.0)
        motor.max_force = self.surroundings.torque_limit
        self.space.add(
            pymunk.PivotJoint(one, other, at, top),
            pymunk.RotaryLimitJoint(one, other, rest - reach, rest + reach),
            motor,
        )
        self.joints.append(Joint(motor, above, below, rest, sign))

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
        for thigh in self.bodies[1::2]:
            x, z = thigh.position
            angle = thigh.angle
            knee = z - body.LIMB / 2 * math.cos(angle) - body.KNEE_RADIUS
            if knee < height(x + body.LIMB / 2 * math.sin(angle)):
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

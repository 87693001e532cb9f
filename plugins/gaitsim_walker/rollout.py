"""The rollout of one walker: simulate the servos and record the motion."""

from dataclasses import dataclass

import numpy as np

from gaitsim_walker.body import FRAME_RATE, Floats
from gaitsim_walker.machine import Machine
from gaitsim_walker.surroundings import Surroundings

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
    parts = [(hinge.motor, hinge.above, hinge.below) for hinge in hinges]
    step, dt, fastest = machine.space.step, surroundings.step, surroundings.speed_limit
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
                for (motor, above, below), target in zip(parts, targets, strict=True):
                    off = GAIN * (angles[above] + target - angles[below])
                    motor.rate = -min(max(off, -fastest), fastest)
                step(dt)
                speeds = [part.angular_velocity for part in bodies]
                for joint, (motor, above, below) in enumerate(parts):
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
    if lasted < frames:
        kept = max(lasted - 1, 0) if failure else lasted
        for record in (state, turned, work, load):
            record[lasted:] = record[kept]
        state[lasted:, 2:4] = 0.0
        load[lasted:], torque[lasted:] = 0.0, 0.0
    return Rollout(
        state[:, :2],
        state[:, 2:4],
        state[:, 4],
        turned,
        torque,
        work,
        load,
        lasted,
        failure,
    )

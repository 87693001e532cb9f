"""Models for tests of physics: a stick on a servo, and a quadruped of any size."""

from importlib.resources import files

import mujoco
import numpy as np

from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.servos import add_servos, joint_servos
from gaitsim_robot.simulation import build


def servoed_stick(servo, *, dt, inertia):
    """Return a body, driven by a servo, that turns about the vertical, and its data."""
    spec = mujoco.MjSpec()
    spec.option.timestep = dt
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    body = spec.worldbody.add_body(mass=1, inertia=[inertia] * 3, explicitinertial=True)
    body.add_joint(name="joint", axis=[0, 0, 1], range=[-1e4, 1e4])
    add_servos(spec, {"joint": servo})
    model = spec.compile()
    return model, mujoco.MjData(model)


def quadruped_spec(size=1.0, *, limits=True, torque=None, speed=None, gains=()):
    """Return the bundled quadruped, scaled; its mass is proportional to the cube of its size."""
    text = (files("gaitsim_robot") / "models" / "quadruped.xml").read_text(encoding="utf-8")
    spec = mujoco.MjSpec.from_string(text)
    for body in spec.bodies[1:]:
        body.pos = size * body.pos
        body.ipos = size * body.ipos
        body.mass *= size**3
        body.inertia = size**5 * body.inertia
        body.fullinertia = size**5 * body.fullinertia
    for geom in spec.geoms:
        geom.pos = size * geom.pos
        geom.size = size * geom.size
        geom.fromto = size * geom.fromto
    for joint in spec.joints:
        joint.armature *= size**5
        if torque is not None:
            joint.actfrcrange = [-torque, torque]
        if speed is not None:
            joint.userdata = [speed, *gains]
        if not limits:
            joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
            joint.userdata = []
            joint.armature = 0.0
    stand = np.array(spec.keys[0].qpos)
    spec.keys[0].qpos = [*(size * stand[:3]), *stand[3:]]
    return spec


def standing_quadruped(
    servo,
    *,
    size=1.0,
    limits=True,
    torque=None,
    speed=None,
    gains=(),
    dt=0.004,
    friction=0.8,
    **options,
):
    """Return the simulation of the quadruped on its ground, and its servos."""
    spec = quadruped_spec(size, limits=limits, torque=torque, speed=speed, gains=gains)
    return simulation_of(spec, servo, dt=dt, friction=friction, **options)


def simulation_of(spec, servo, *, dt=0.004, friction=0.8, **options):
    """Return the simulation of a robot on its ground, and its servos."""
    model = spec.copy().compile()
    anatomy = find_anatomy(model)
    servos = joint_servos(model, anatomy, servo, **options)
    return build(spec, anatomy, servos, dt=dt, friction=friction, gravity=9.81), servos


def trot(simulation, frames):
    """Return commands for a trot of 1.5 strides per second, (1, frames, joints) rad."""
    commands = np.repeat(simulation.rest[simulation.ctrl][None, None], frames, axis=1)
    time = np.arange(frames) / 50
    ramp = np.minimum(time / 0.5, 1.0)
    for leg, offset in enumerate((0.0, np.pi, np.pi, 0.0)):
        phase = 3 * np.pi * time + offset
        commands[0, :, 3 * leg + 1] += 0.3 * ramp * np.cos(phase)
        commands[0, :, 3 * leg + 2] -= 0.3 * ramp * np.maximum(0, np.sin(phase))
    return commands

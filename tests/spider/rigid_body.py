"""An independent simulation of spider gaits: the same body as rigid links in MuJoCo, on a floor.

It shares no code or constants with the package. Load, slip, tipping and servos that yield result
from the physics engine.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

LEGS = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
HIP_X = (0.075, 0.025, -0.025, -0.075)
HIP_Y = 0.07
AZIMUTH = (45.0, 15.0, -15.0, -45.0)  # degrees, from sideways to the front
COXA, FEMUR, TIBIA = 0.03, 0.08, 0.12  # m
FEMUR_PITCH, TIBIA_PITCH = math.radians(30.0), math.radians(-80.0)
FOOT_RADIUS = 0.008
GRAVITY = 9.81
WEIGHT = (0.8 + 8 * 0.05) * GRAVITY

# Standard-size hobby servos with full torque (8 kg·cm) at errors of 2.3° or more. ARMATURE is the
# inertia of rotor and gears at the shaft. Damping opposes the joint's speed, like back-EMF, so a
# joint follows its command DAMPING / KP = 10 ms late even without any other lag.
KP = 20.0  # N·m/rad
DAMPING = 0.2  # N·m·s/rad
ARMATURE = 5e-4  # kg·m²
TORQUE_LIMIT = 0.8  # N·m
TIMESTEP = 0.002  # s
FRAME_RATE = 30.0  # Hz
SETTLE = 0.5  # s

# Arguments of `replay` that represent other plausible floors and servos.
VARIANTS: dict[str, dict[str, Any]] = {
    "nominal": {},
    "low friction": {"friction": 0.5},
    "high friction": {"friction": 1.0},
    "soft servo": {"kp": KP / 3, "torque_limit": 0.5},
    "30 ms delay": {"lag": 0.03},
    "30 ms first-order lag": {"lag": 0.03, "lag_kind": "first-order"},
}


@dataclass(frozen=True)
class Replay:
    """The motion of the body, relative to its pose at the start of the gait."""

    forward: float  # m, along the heading at the start
    lateral: float  # m, positive to the left
    yaw: float  # degrees, positive to the left, including whole turns
    max_roll: float  # degrees, to either side
    max_pitch: float  # degrees, forward or backward
    min_height: float  # m, lowest centre of the body
    fell: bool  # whether it tilted beyond 45°, or the belly carried half the weight in a frame
    belly: float  # share of the time that the belly touched the floor
    path: Array  # (frames, 3), m: forward, left, height
    duty: Array  # (8,), share of the time that each foot carried load
    load: Array  # (frames − 1, 9), N: load on feet and belly, mean over each frame interval


@cache
def _model(friction: float = 0.8, kp: float = KP, torque_limit: float = TORQUE_LIMIT) -> Any:
    """Return the spider on a flat floor; all joints are at 0 in the neutral pose."""
    knee = np.array([FEMUR * math.cos(FEMUR_PITCH), 0.0, FEMUR * math.sin(FEMUR_PITCH)])
    foot = np.array([TIBIA * math.cos(TIBIA_PITCH), 0.0, TIBIA * math.sin(TIBIA_PITCH)])

    def text(*numbers: float) -> str:
        return " ".join(f"{number:.9g}" for number in numbers)

    legs, actuators, sensors = [], [], []
    for index, leg in enumerate(LEGS):
        side = 1.0 if leg[0] == "L" else -1.0
        # Rotation of the leg's x axis, which points outward.
        turn = side * math.radians(90.0 - AZIMUTH[index % 4])
        legs.append(f"""
        <body pos="{text(HIP_X[index % 4], side * HIP_Y, 0)}" euler="0 0 {turn:.9g}">
          <joint name="{leg} coxa" axis="0 0 {-side}"/>
          <geom class="link" fromto="{text(0, 0, 0, COXA, 0, 0)}" mass="0.01"/>
          <body pos="{text(COXA, 0, 0)}">
            <joint name="{leg} femur" axis="0 -1 0"/>
            <geom class="link" fromto="{text(0, 0, 0, *knee)}" mass="0.02"/>
            <body pos="{text(*knee)}">
              <joint name="{leg} tibia" axis="0 -1 0"/>
              <geom class="link" fromto="{text(0, 0, 0, *foot)}" mass="0.02"/>
              <geom name="{leg}" class="sole" size="{FOOT_RADIUS}" pos="{text(*foot)}"/>
              <site name="{leg}" size="{2 * FOOT_RADIUS}" pos="{text(*foot)}"/>
            </body>
          </body>
        </body>""")
        actuators += [
            f'<position joint="{leg} {joint}" kp="{kp}" kv="{DAMPING}"'
            f' forcerange="-{torque_limit} {torque_limit}"/>'
            for joint in ("coxa", "femur", "tibia")
        ]
        sensors.append(f'<touch site="{leg}"/>')
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <compiler angle="radian"/>
      <option timestep="{TIMESTEP}" gravity="0 0 {-GRAVITY}" integrator="implicitfast"
              cone="elliptic" impratio="10"/>
      <default>
        <geom contype="0" conaffinity="0" condim="3" friction="{friction} 0 0" solref="0.01 1"/>
        <joint type="hinge" armature="{ARMATURE}"/>
        <default class="link"><geom type="capsule" size="0.006"/></default>
        <default class="sole"><geom type="sphere" mass="0" contype="1"/></default>
      </default>
      <worldbody>
        <geom type="plane" size="0 0 1" conaffinity="1"/>
        <body name="body">
          <freejoint/>
          <geom type="box" size="0.1 0.07 0.03" mass="0.8" contype="1"/>
          <site name="belly" type="box" size="0.11 0.08 0.04"/>{"".join(legs)}
        </body>
      </worldbody>
      <actuator>{"".join(actuators)}</actuator>
      <sensor>{"".join(sensors)}<touch site="belly"/></sensor>
    </mujoco>""")


def _data_in_poses(joint_angles: ArrayLike) -> Iterator[Any]:
    """Yield the engine's data in each pose, (frames, 24) rad, with the body at the origin."""
    model = _model()
    data = mujoco.MjData(model)
    data.qpos[:3] = 0.0
    for pose in np.atleast_2d(joint_angles):
        data.qpos[7:] = pose
        mujoco.mj_kinematics(model, data)
        yield data


def feet(joint_angles: ArrayLike) -> Array:
    """Return the centres of the feet in the body's frame, (frames, 8, 3) m, from the engine."""
    return np.array(
        [[data.geom(leg).xpos.copy() for leg in LEGS] for data in _data_in_poses(joint_angles)]
    )


def links(joint_angles: ArrayLike, without: tuple[str, ...] = ()) -> tuple[Array, Array]:
    """Return masses (links,) kg and centres of mass (frames, links, 3) m; 0 kg for missing legs."""
    places = [data.xipos[1:].copy() for data in _data_in_poses(joint_angles)]
    masses: Array = _model().body_mass[1:].copy()
    for leg in without:
        first = 3 * LEGS.index(leg) + 1  # the trunk, then three links for each leg
        masses[first : first + 3] = 0
    return masses, np.array(places)


def commands(angles: Array, delay: float) -> Array:
    """Return the commands to the servos in each step, (steps, 24), from first to last frame."""
    last = len(angles) - 1
    time = np.arange(round(last / FRAME_RATE / TIMESTEP)) * TIMESTEP
    when = np.clip((time - delay) * FRAME_RATE + 1e-9, 0, last)
    frame = np.minimum(when.astype(int), last - 1)
    share = (when - frame)[:, None]
    commanded: Array = angles[frame] + share * (angles[frame + 1] - angles[frame])
    return commanded


def first_order(commanded: Array, lag: float) -> Array:
    """Return commands after a low-pass filter with the time constant `lag`."""
    late = commanded.copy()
    for step in range(1, len(late)):
        behind = commanded[step] - late[step - 1]
        late[step] = late[step - 1] - math.expm1(-TIMESTEP / lag) * behind
    return late


def replay(
    joint_angles: ArrayLike,
    *,
    lag: float = 0.0,
    lag_kind: Literal["delay", "first-order"] = "delay",
    **floor_and_servos: float,
) -> Replay:
    """Play a gait, (frames, 24) radians from the neutral pose, on servos and a floor.

    The spider is put down in the first frame's pose, holds it for half a second, and then plays
    from the first frame to the last. `lag` (s) is a delay or a time constant. Other arguments are
    those of the model.
    """
    angles = np.asarray(joint_angles, dtype=np.float64)
    delay = lag if lag_kind == "delay" else 0.0
    commanded = commands(angles, delay)
    if lag > delay:
        commanded = first_order(commanded, lag)
    model = _model(**floor_and_servos)
    data = mujoco.MjData(model)
    data.qpos[2] = FOOT_RADIUS - feet(angles[0])[0, :, 2].min()
    data.qpos[7:] = data.ctrl[:] = angles[0]
    mujoco.mj_step(model, data, nstep=round(SETTLE / TIMESTEP))

    pose, load = np.empty((len(commanded) + 1, 7)), np.empty((len(commanded), 9))
    pose[0] = data.qpos[:7]
    for step, target in enumerate(commanded):
        data.ctrl[:] = target
        mujoco.mj_step(model, data)
        pose[step + 1], load[step] = data.qpos[:7], data.sensordata
    # The engine resets its time after a divergence.
    if data.time < SETTLE + (len(commanded) - 1) * TIMESTEP:
        raise FloatingPointError("the simulation became unstable: use a shorter timestep")
    return _summary(pose, load, len(angles))


def _summary(pose: Array, load: Array, frames: int) -> Replay:
    w, x, y, z = pose[:, 3:].T
    yaw = np.unwrap(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)))
    pitch = np.arcsin(np.clip(2 * (w * y - x * z), -1, 1))
    upright = 1 - 2 * (x * x + y * y)
    roll = np.arctan2(2 * (y * z + w * x), upright)
    dx, dy = (pose[:, :2] - pose[0, :2]).T
    cos, sin = math.cos(yaw[0]), math.sin(yaw[0])
    track = np.column_stack([dx * cos + dy * sin, dy * cos - dx * sin, pose[:, 2]])
    at_frame = np.rint(np.linspace(0, len(load), frames)).astype(int)
    frame_load = np.add.reduceat(load, at_frame[:-1]) / np.diff(at_frame)[:, None]
    return Replay(
        forward=float(track[-1, 0]),
        lateral=float(track[-1, 1]),
        yaw=math.degrees(yaw[-1] - yaw[0]),
        max_roll=math.degrees(np.abs(roll).max()),
        max_pitch=math.degrees(np.abs(pitch).max()),
        min_height=float(track[:, 2].min()),
        fell=bool(upright.min() < math.cos(math.pi / 4) or frame_load[:, 8].max() > WEIGHT / 2),
        belly=float((load[:, 8] > 0).mean()),
        path=track[at_frame],
        duty=(load[:, :8] > 0).mean(axis=0),
        load=frame_load,
    )


def tetrapod(
    frames: int = 300, frequency: float = 1.2, coxa: float = 20, lift: float = 14
) -> Array:
    """A hand-made alternating tetrapod, (frames, 24) radians: L1 R2 L3 R4 against the others."""
    phase = 2 * np.pi * frequency * np.arange(frames)[:, None] / 30.0
    phase = phase + np.pi * np.array([0, 1, 0, 1, 1, 0, 1, 0])
    angles = np.zeros((frames, 8, 3))
    angles[:, :, 0] = -coxa * np.cos(phase)  # swings forward over the first half of the cycle
    angles[:, :, 1] = lift * np.maximum(np.sin(phase), 0)  # and is in the air during that half
    return np.radians(angles.reshape(frames, 24))

"""Servos of hobby robots, with values from their data sheets, and the timing of their commands."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

_Float = TypeVar("_Float", bound=np.floating[Any])


def hold_commands(
    commands: NDArray[_Float], frame_rate: float, rate: float, steps: int = 1
) -> NDArray[_Float]:
    """Return the commands in force in each step, for a controller with a fixed command rate.

    Each command is the gait's pose at the moment of sending, interpolated between frames.

    Args:
        commands: commanded angles, (…, frames, joints) rad.
        frame_rate: frame rate of `commands`, Hz.
        rate: command rate of the controller, Hz. If it equals the frame rate, the angles of each
            frame are copied bit for bit.
        steps: number of steps per frame.

    Returns:
        The commands, (…, frames · steps, joints) rad, in the dtype of `commands`.
    """
    return commands_at(commands, np.arange(commands.shape[-2] * steps) / steps, frame_rate / rate)


def commands_at(
    commands: NDArray[_Float], moments: NDArray[np.float64], period: float, origin: int = 0
) -> NDArray[_Float]:
    """Return the commands in force at given moments, for a controller as in `hold_commands`.

    Args:
        commands: commanded angles, (…, frames, joints) rad.
        moments: times, (moments,) frames.
        period: time between commands, frames.
        origin: number of the first frame of `commands`.

    Returns:
        The commands, (…, moments, joints) rad.
    """
    # Without the 1e-9, rounding errors would delay some commands by a step.
    sent = np.floor(moments / period + 1e-9) * period
    whole = sent.astype(np.intp)
    last = commands.shape[-2] - 1
    before = np.clip(whole - origin, 0, last)
    after = np.minimum(before + 1, last)
    share = (sent - whole)[:, None]
    return _interpolate(commands[..., before, :], commands[..., after, :], share)


def delay_angles(angles: NDArray[_Float], steps: NDArray[Any] | float) -> NDArray[_Float]:
    """Delay joint angles, interpolating between steps; joints first hold their initial angle.

    Args:
        angles: joint angles, (…, steps, joints) rad.
        steps: delay in steps, at least 0: one number for all joints, or (joints,). A delay of whole
            steps copies the angles bit for bit.

    Returns:
        The delayed angles, in the shape and dtype of `angles`.
    """
    late = np.asarray(steps, np.float64)
    whole = np.floor(late)
    after = np.maximum(np.arange(angles.shape[-2])[:, None] - whole.astype(np.intp), 0)
    before = np.maximum(after - 1, 0)
    if late.ndim:
        column = np.arange(angles.shape[-1])
        here, there = angles[..., after, column], angles[..., before, column]
    else:  # indexing whole rows is five times faster
        here, there = angles[..., after[:, 0], :], angles[..., before[:, 0], :]
    return _interpolate(here, there, late - whole)


def _interpolate(
    here: NDArray[_Float], there: NDArray[_Float], share: NDArray[np.float64]
) -> NDArray[_Float]:
    """Interpolate from `here` to `there`; overwrite `there` and keep its dtype."""
    there -= here
    there *= share.astype(there.dtype)
    there += here
    return there


Bus = Literal["", "pwm", "dynamixel", "feetech"]

RPM = 2 * math.pi / 60
KGF_CM = 0.0980665
SIXTY_DEGREES = math.pi / 3
TURN = 2 * math.pi


@dataclass(frozen=True)
class Servo:
    """The capabilities of a servo.

    Attributes:
        name: name in experiment files.
        stall_torque: torque at rest, N m; 0 for a servo without force.
        no_load_speed: speed without load, at which the torque drops to 0, rad/s.
        latency: delay from a command to the torque that it causes, s.
        stiffness: torque per position error, N m/rad.
        damping: torque per speed, N m s/rad.
        armature: inertia of rotor and gears at the shaft, kg m².
        source: source of the values.
        continuous: share of the stall torque that it can deliver for long without overheating; 0 if
            unknown.
        bus: type of its commands: 'pwm' pulses, or the packets of a servo family; '' if unknown.
        travel: range from one end to the other, rad; the centre is in the middle.
        ticks: number of goal positions, counted from 0, of a servo on a bus; 0 for others.
        tick: angle between two goal positions, rad.
        mass: mass, kg; 0 if unknown.
    """

    name: str
    stall_torque: float
    no_load_speed: float
    latency: float
    stiffness: float
    damping: float
    armature: float
    source: str
    continuous: float = 0.0
    bus: Bus = ""
    travel: float = math.inf
    ticks: int = 0
    tick: float = 0.0
    mass: float = 0.0

    def scaled(self, factor: float) -> "Servo":
        """Return a servo of the same kind with a factor of torque, gains and mass."""
        if factor == 1:
            return self
        names = ("stall_torque", "stiffness", "damping", "armature", "mass")
        return replace(self, **{name: factor * getattr(self, name) for name in names})

    @property
    def centre_tick(self) -> float:
        """Goal position in the middle of the travel; may be fractional."""
        return self.travel / 2 / self.tick if self.tick else 0.0


CONTINUOUS = 0.2
"""Continuous torque of a hobby servo as a share of its stall torque.

Source: ROBOTIS, Torque Ratings (2020); likewise the e-Manuals of AX-12A and AX-18A: loads
of at most 1/5 of the stall torque allow stable motion. The data sheets of the other servos do not
state a continuous torque.
"""


def _proportional(name: str, torque: float, speed: float, band: float, **data: Any) -> Servo:
    """Return a servo that applies its full voltage at position errors of at least `band`, rad."""
    return Servo(
        name,
        torque,
        speed,
        stiffness=torque / band,
        damping=torque / speed,
        continuous=CONTINUOUS,
        **data,
    )


SERVOS: Mapping[str, Servo] = {
    servo.name: servo
    for servo in (
        _proportional(
            "ax-12a",
            1.5,
            59 * RPM,
            latency=0.034,
            band=math.radians(32 * 0.29),
            armature=0.014,
            source="ROBOTIS e-Manual, AX-12A, at 12 V, with its default compliance slope of 32 "
            "steps; latency: the middle of 17.4 to 50.2 ms measured by Smith and Jivraj, Analysis "
            "of Robotis Dynamixel AX-12+ Actuator Latencies; armature estimated from the "
            "STS3215's by the gear ratios",
            bus="dynamixel",
            travel=math.radians(300),
            ticks=1024,
            tick=math.radians(300) / 1023,
            mass=0.0546,
        ),
        _proportional(
            "sts3215",
            19.5 * KGF_CM,
            SIXTY_DEGREES / 0.192,
            latency=0.02,
            band=1 / (32 * 0.166),
            armature=0.026,
            source="DFRobot SER0069 (Feetech STS3215) data sheet, at 7.4 V; gain and armature "
            "measured by Duclusaud and Passault, Better Actuator Models, model m1; latency "
            "estimated as one command at 50 Hz",
            bus="feetech",
            travel=TURN,
            ticks=4096,
            tick=TURN / 4096,
            mass=0.055,
        ),
        _proportional(
            "mg995",
            9.4 * KGF_CM,
            SIXTY_DEGREES / 0.17,
            latency=0.02,
            band=0.2,
            armature=0.014,
            source="sellers' data sheets of the Tower Pro MG995, at 4.8 V: the lowest of the stall "
            "torques that they state, 9.4 to 13 kgf·cm; latency estimated as one pulse at 50 Hz; "
            "gain and armature estimated from similar servos",
            bus="pwm",
            travel=math.pi,  # some data sheets state 120°; a calibration sets the real limits
            mass=0.055,
        ),
        _proportional(
            "xl430-w250",
            1.4,
            57 * RPM,
            latency=0.02,
            band=885 / (640 / 128) * 2 * math.pi / 4096,
            armature=0.014,
            source="ROBOTIS e-Manual, XL430-W250, at 11.1 V, with its default position gain of "
            "640; latency estimated as one command at 50 Hz; armature estimated from the "
            "STS3215's by the gear ratios",
            bus="dynamixel",
            travel=TURN,
            ticks=4096,
            tick=TURN / 4096,
            mass=0.0572,
        ),
    )
}
"""Servos by name."""

"""Calibrating a robot by hand: one servo at a time moves until its joint looks as in a picture."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from gaitsim.plugin import GaitsimError, Motion, Skeleton, unknown
from gaitsim.plugin.toolkit import Damage
from gaitsim_hardware.calibration import Calibration, Joint, default_calibration
from gaitsim_hardware.calibration_file import read_calibration, write_joint
from gaitsim_hardware.keyframes import Keyframes
from gaitsim_robot.organism import Robot
from gaitsim_robot.skeleton import skeleton
from gaitsim_wire.buses import Reading, ServoBus
from gaitsim_wire.driving import (
    LEAST_VOLTS,
    RATE,
    Player,
    SafetyLimits,
    Session,
    Status,
    Stopped,
    Tape,
)
from gaitsim_wire.robots import FORMATS, ends_of

Floats = NDArray[np.float64]

STEPS = ("move", "stand", "low", "high")
"""Questions about each joint: which servo and direction, the standing pose, and both ends."""
SPEED = 30.0  # °/s, of a servo that is calibrated
BLOCKED = 4.0  # °, lag of a servo from which on it is turned from where it is, not commanded
PAUSE = 0.05  # s between two readings while the servos are off
SWAY, SWAYING = 5.0, 1.0  # ° and s, of each joint in the final check


class Jog(Player):
    """One servo that follows a person slowly, from where it is."""

    def __init__(self) -> None:
        self._goal = self._target = self._seen = math.nan
        self._by = 0.0

    @property
    def blocked(self) -> bool:
        """Whether the servo does not follow."""
        return abs(self._goal - self._seen) > BLOCKED

    def move(self, degrees: float) -> None:
        """Turn the servo by an angle from here; repeated keys do not add up."""
        self._by = degrees

    @property
    def first(self) -> Floats:
        """Not a number, as the servo stays where it is."""
        return np.full(1, math.nan)

    def step(self, reading: Reading) -> Floats:
        """Return the next angle of the servo, (1,) rad."""
        if reading.answered[0]:
            self._seen = math.degrees(reading.angles[0])
        if math.isnan(self._goal):
            self._goal = self._target = self._seen
        if self._by:
            self._target, self._by = (self._seen if self.blocked else self._goal) + self._by, 0.0
        self._goal += float(np.clip(self._target - self._goal, -SPEED / RATE, SPEED / RATE))
        return np.radians([self._goal])

    def stop(self) -> None:
        """Stay."""
        self._target = self._goal

    def give(self, command: str) -> None:
        """Ignore commands."""


class Calibrator:
    """A robot whose servos a person calibrates.

    Torque is on for one servo, from the first `jog` of a joint until `off` or the next joint, and
    during the check.

    Args:
        robot: robot in its standing pose.
        kind: 'feetech' or 'dynamixel'.
        port: open port.
        baud: baud rate of the port.
        path: calibration file; its joints are done.
        again: whether to calibrate these joints again.
        clock: function that returns the time, s.
        sleep: function that waits for some seconds.

    Attributes:
        names: names of the joints.
        joints: servos of the joints, as far as they are known.
        done: joints that are in the file.
        name: current joint.
        step: one of `STEPS`; 'done' if nothing is left to do.
        angle: angle of the joint's servo, °; NaN without an answer.
        reading: last measurements of this servo, or in the check, of all servos.
        problem: why the torque was switched off, or an answer was refused; '' otherwise.
        checked: time in the last check, s; 0 before it.

    Raises:
        GaitsimError: the file is invalid, or a servo is missing or wrong.
    """

    def __init__(
        self,
        robot: Robot,
        kind: str,
        port: Any,
        baud: int,
        path: Path,
        *,
        again: bool = False,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.robot, self.path, self.names = robot, path, robot.joint_names()
        self._wire = kind, port, baud, clock, sleep
        self._standing: dict[str, float] = dict(
            zip(self.names, np.degrees(robot.standing_pose()).tolist(), strict=True)
        )
        usual = default_calibration(FORMATS[kind], self.names, robot.standing_pose(), robot.servo)
        known: Mapping[str, Joint] = {}
        if path.exists():
            known = read_calibration(path, FORMATS[kind], self.names, partial=True).joints
        self.joints = {**usual.joints, **known}
        self.done = set() if again else {*known}
        self._ids = self._find_ids()
        self._bus(self.names).off()
        self._bus(self.names).check()
        self.closed, self.problem, self.checked = False, "", 0.0
        self.step, self._began, self._low = STEPS[0], math.nan, math.nan
        self._orders: SimpleQueue[Callable[[], object]] = SimpleQueue()
        self._player: Player | None = None
        self.choose(next((one for one in self.names if one not in self.done), self.names[0]))
        self.step = "done" if self.done >= {*self.names} else self.step

    def _find_ids(self) -> list[int]:
        """Return the ids of the servos; assign those that the file does not name.

        Without an answer from the usual ids, all others are tried.
        """
        ids = [int(joint.id or 0) for joint in self.joints.values()]
        if len({*ids}) == len(ids) and not self._bus(self.names).missing():
            return sorted(ids)
        found = self._bus(self.names).scan()
        taken = {self.joints[name].id for name in self.done}
        # Ids that do not answer are assigned last, and reported by the check.
        others = [*found, *(number for number in range(1, 253) if number not in found)]
        free = (number for number in others if number not in taken)
        for name in self.names:
            if name not in self.done:
                self._change(name, id=next(free))
        return found

    def _change(self, name: str, **values: float | None) -> None:
        self.joints[name] = self.joints[name].model_copy(update=values)

    def _raw(self, names: Sequence[str]) -> Calibration:
        """Return a calibration in which the angles of joints are those of their servos."""
        kind = self._wire[0]
        found = {}
        for name in names:
            joint = self.joints[name]
            one = default_calibration(FORMATS[kind], [name], np.zeros(1), joint.servo).joints[name]
            found[name] = one.model_copy(update={"id": joint.id})
        return Calibration(found, str(self.path))

    def _bus(self, names: Sequence[str], calibration: Calibration | None = None) -> ServoBus:
        kind, *rest, clock, sleep = self._wire
        return ServoBus(kind, *rest, calibration or self._raw(names), clock, sleep)

    def off_frame(self) -> bytes:
        """Return the bytes that switch all servos off."""
        return self._bus(self.names).off_frame()

    def order(self, what: str, *arguments: float) -> None:
        """Let the thread of `run` call a method after its next reading."""
        self._orders.put(partial(getattr(self, what), *arguments))

    def obey(self) -> None:
        """Carry out the orders."""
        while not self._orders.empty():
            self._orders.get()()

    def run(self, poll: Callable[[], object] | None = None) -> None:
        """Read the servo of the current joint, or move it, until `closed` is set.

        Args:
            poll: function called after each reading, which may call the other methods; None
                obeys orders.
        """
        poll = poll or self.obey
        while not self.closed:
            try:
                if (player := self._player) is not None:
                    self._serve(player, poll)
                    continue
                self._see(self._bus([self.name]).read())
            except OSError as error:
                self._player, self.angle = None, math.nan
                self.problem = f"The port was lost ({error})."
            poll()
            self._wire[-1](PAUSE)

    def _serve(self, player: Player, poll: Callable[[], object]) -> None:
        """Let one servo, or for the check all of them, follow a player until it is replaced."""
        kind, *_, clock, sleep = self._wire
        jogs = isinstance(player, Jog)
        calibration = self._raw([self.name]) if jogs else self._calibration

        def frame(status: Status) -> None:
            if jogs:
                self._see(status.reading)
            else:
                self.reading = status.reading
                self.checked += (status.phase == "driving") / RATE
            poll()
            if self._player is not player or self.closed:
                raise Stopped

        try:
            bus = self._bus([], calibration)
            if not jogs:
                bus.check()
            limits = SafetyLimits(volts=LEAST_VOLTS[kind])
            Session(bus, player, calibration, limits, clock, sleep).run(frame)
        except Stopped as stop:
            if text := str(stop):
                self.problem = f"{text[0].upper()}{text[1:]}. The servos are off."
        except GaitsimError as error:
            self.problem = str(error)
        if self._player is player:
            self._player = None

    def _see(self, reading: Reading) -> None:
        self.reading = reading
        if reading.answered[0] or not self.on:
            self.angle = math.degrees(reading.angles[0])
        if math.isnan(self._began):
            self._began = self.angle

    @property
    def on(self) -> bool:
        """Whether torque is on."""
        return self._player is not None

    @property
    def blocked(self) -> bool:
        """Whether the servo does not follow."""
        return isinstance(self._player, Jog) and self._player.blocked

    @property
    def checking(self) -> bool:
        """Whether the robot is swaying, and rising or lying down."""
        return isinstance(self._player, Tape)

    def off(self) -> None:
        """Switch the servos off."""
        self._player = None

    def choose(self, name: str) -> None:
        """Begin with a joint, with its servo off.

        Raises:
            GaitsimError: the robot has no such joint.
        """
        if name not in self.names:
            raise unknown("joint", name, self.names, where="--joint")
        self.off()
        self.name, self.step, self.problem = name, STEPS[0], ""
        self.angle = self._began = self._low = math.nan
        self.reading = Reading.empty(1)

    def turn_to(self, by: int) -> None:
        """Choose the joint `by` places further."""
        self.choose(self.names[(self.names.index(self.name) + by) % len(self.names)])

    def jog(self, degrees: float) -> None:
        """Turn the joint by an angle, up if positive; switch its servo on where it is."""
        if self._player is None and math.isfinite(self.angle) and self.step != "done":
            self.problem, self._player = "", Jog()
        if isinstance(self._player, Jog):
            self._player.move(degrees * self.joints[self.name].direction)

    def flip(self) -> None:
        """Turn the direction of the servo around."""
        self.step = STEPS[0]
        self._change(self.name, direction=-self.joints[self.name].direction)

    def other(self) -> None:
        """Assign the next id to the joint; the joint that had it gets the old one."""
        own = self.joints[self.name].id
        used = {self.joints[name].id for name in self.done if name != self.name}
        free = [number for number in self._ids if number not in used]
        number = next((one for one in free if one > (own or 0)), free[0])
        for name, joint in self.joints.items():
            if joint.id == number:
                self._change(name, id=own)
        self._change(self.name, id=number)
        self.choose(self.name)

    def accept(self) -> None:
        """Take the present angle as an answer, and go to the next step; the last one saves."""
        if math.isnan(self.angle) or self.step == "done":
            return
        name, self.problem = self.name, ""
        match self.step:
            case "stand":
                offset = self.angle - self.joints[name].direction * self._standing[name]
                self._change(name, offset=round(offset, 2))
            case "low":
                self._low = self.angle
            case "high":
                self._save(self._low, self.angle)
                return
        self.step = STEPS[STEPS.index(self.step) + 1]

    def keep(self) -> None:
        """Take the ends of the joint in the model, as far as the servo reaches."""
        if self.step in STEPS[2:]:
            joint, raw = self.joints[self.name], self._raw([self.name]).joints[self.name]
            low, high = (self._ends[self.name] * joint.direction + joint.offset).tolist()
            self._save(*(min(max(one, raw.min), raw.max) for one in (low, high)))

    def back(self) -> None:
        """Return to the step before."""
        if self.step in STEPS[1:]:
            self.step, self.problem = STEPS[STEPS.index(self.step) - 1], ""

    def _save(self, *ends: float) -> None:
        """Save the joint with both ends of its servo, °, and go to the next joint."""
        joint, name = self.joints[self.name], self.name
        low, high = (round(one, 2) for one in sorted(ends))
        stands = joint.direction * self._standing[name] + joint.offset
        if not low < stands < high:
            self.problem = (
                f"The standing pose, {stands:.0f}°, is not between {low:g}° and {high:g}°."
            )
            self.step = STEPS[2]
            return
        try:
            joint = Joint.model_validate(joint.model_dump() | {"min": low, "max": high})
            write_joint(self.path, name, joint)
        except (ValidationError, GaitsimError) as error:
            self.off()
            self.problem = str(error)
            return
        self.joints[name] = joint
        self.done.add(name)
        after = self.names[self.names.index(name) :] + self.names
        self.choose(next((one for one in after if one not in self.done), name))
        if name == self.name:
            self.step = "done"

    def check(self) -> None:
        """Let the robot rise to the standing pose, sway each joint a little, and lie down."""
        self.problem, self.checked = "", 0.0
        calibration = self._calibration
        degrees = calibration.servo_angles(np.radians(self.swaying))
        degrees = np.clip(degrees, calibration.low, calibration.high)
        seconds = np.arange(len(degrees)) / RATE
        keyframes = Keyframes(seconds, degrees, degrees[0], self.names, 0, 0.0)
        self._player = Tape(keyframes, calibration)

    @property
    def _calibration(self) -> Calibration:
        joints = {name: self.joints[name] for name in self.names}
        return Calibration(joints, str(self.path), ends=ends_of(self.robot))

    @cached_property
    def _ends(self) -> dict[str, Floats]:
        """Both ends of each joint in the model, °."""
        return dict(zip(self.names, np.degrees(ends_of(self.robot)), strict=True))

    @cached_property
    def swaying(self) -> Floats:
        """Joint angles of the final check, (frames, joints) °: each joint sways once, up first."""
        frames, joints = round(SWAYING * RATE), len(self.names)
        wave = SWAY * np.sin(2 * np.pi * np.arange(frames) / frames)
        found = np.tile([*self._standing.values()], (frames * joints + 1, 1))
        for joint in range(joints):
            found[joint * frames : (joint + 1) * frames, joint] += wave
        return found

    def picture(self) -> Skeleton:
        """Return the standing robot whose current joint turns by a degree in each frame.

        The joint is highlighted. Its first frame is at its lower end.
        """
        low, high = self._ends[self.name]
        sweep = np.arange(low, high + 1)
        angles = np.tile([*self._standing.values()], (len(sweep), 1))
        angles[:, self.names.index(self.name)] = sweep
        return drawn(self.robot, angles, self.name)

    @property
    def frame(self) -> int:
        """Number of the frame of `picture`, or of the check, that the robot should look like."""
        if self.checking:
            return round(self.checked * RATE)
        joint, angle = self.joints[self.name], self._standing[self.name]
        if self.step == "move" and math.isfinite(self.angle):
            angle += joint.direction * (self.angle - self._began)
        elif self.step in STEPS[2:] and math.isfinite(self.angle):
            angle = joint.direction * (self.angle - joint.offset)
        return max(round(angle - float(self._ends[self.name][0])), 0)


def drawn(robot: Robot, angles: Floats, moved: str = "") -> Skeleton:
    """Return a robot whose trunk stands, on level ground.

    Args:
        robot: the robot.
        angles: joint angles, (frames, joints) °.
        moved: joint whose parts are drawn as damaged ones, to be seen; '' for none.
    """
    marked = (Damage(moved, "stuck"),) if moved else ()
    simulation = replace(robot.simulation, damage=marked, ground=None, world={})
    pose = np.tile(simulation.anatomy.stance, (len(angles), 1))
    pose[:, simulation.qpos] = np.radians(angles)
    touching = np.zeros((1, len(angles), len(simulation.anatomy.legs)), dtype=np.bool_)
    motion = Motion(RATE, {"configuration": pose[None], "stance": touching})
    return skeleton(simulation, motion, 0)

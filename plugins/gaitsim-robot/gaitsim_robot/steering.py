"""A robot in physics that a person drives: presses of keys change the command of its gait.

A drive is recorded as options of the robot, with which it repeats the drive bit for bit.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import COMMAND, Command, GaitsimError, Motion, Steered
from gaitsim_robot.drives import SHORTENED, pushes, targets
from gaitsim_robot.feeling import Pilot
from gaitsim_robot.rollout import (
    Feelings,
    LockStep,
    Mover,
    empty_record,
    motion_of,
    record_segment,
)
from gaitsim_robot.simulation import FRAME_RATE, Simulation

LONGEST = 600.0  # s
STANDING = {"at": 0.0, "speed": 0.0}  # first entry of a drive
LEAST = 0.5  # s, shortest duration of a rollout
STEPS = 4  # presses of a key from 0 to the limit of a command
PUSH = 0.3  # m/s
GOLDEN_ANGLE = 137.5  # ° between the directions of two pushes, so that no direction repeats soon

COMMANDS = (
    Command("stop", "space", "stop and stand"),
    Command("push", "x", "push the robot"),
    Command("faster", "up", "walk faster"),
    Command("slower", "down", "walk slower, or backward"),
    Command("left", "left", "turn more to the left"),
    Command("right", "right", "turn more to the right"),
    Command("step left", "a", "walk more to the left"),
    Command("step right", "d", "walk more to the right"),
    Command("higher", "w", "raise the trunk"),
    Command("lower", "s", "lower the trunk"),
)
CHANGES = {
    "faster": ("speed", 1), "slower": ("speed", -1),
    "left": ("turn", 1), "right": ("turn", -1),
    "step left": ("sideways", 1), "step right": ("sideways", -1),
    "higher": ("height", 1), "lower": ("height", -1),
}  # fmt: skip
"""The part of the command that a key changes, and the sign of the change."""

# In an entry of a drive, a turn is in °/s. Recorded values are rounded to these digits.
DIGITS = {"speed": 3, "turn": 1, "sideways": 3, "height": 4}
NAMES = {"speed": "speed", "turn": "turn", "sideways": "sideways speed", "height": "height"}


class Wheel:
    """The commands of a driver, which presses of keys change by steps.

    Args:
        limits: largest commands, (4,), as `COMMAND`; the turn in rad/s.

    Attributes:
        drive: entries of the drive up to now.
        limits: largest commands by name; the turn in °/s.
    """

    def __init__(self, limits: NDArray[np.float64]) -> None:
        self.drive = [dict(STANDING)]
        most = limits.copy()
        most[COMMAND.index("turn")] *= 180 / np.pi
        self.limits: dict[str, float] = dict(zip(COMMAND, most.tolist(), strict=True))
        self._steps = dict.fromkeys(COMMAND, 0)
        self._beyond, self._pushed = "", 0

    def give(self, command: str, at: float) -> dict[str, float]:
        """Change the command at a time, s; return the new entry of the drive, {} for none."""
        entry = {"at": at}
        self._beyond = ""
        if command == "stop":
            if not any(self._steps.values()):
                return {}  # a held key would fill the drive with entries
            self._steps = dict.fromkeys(COMMAND, 0)
            entry |= dict.fromkeys(COMMAND, 0.0)
        elif command == "push":
            self._pushed += 1
            entry |= {"push": PUSH, "direction": self._pushed * GOLDEN_ANGLE % 360.0}
        elif command in CHANGES:
            part, sign = CHANGES[command]
            if abs(self._steps[part] + sign) > STEPS:
                self._beyond = part
                return {}
            self._steps[part] += sign
            entry[part] = self._wish(part)
        else:
            allowed = ", ".join(one.name for one in COMMANDS)
            raise GaitsimError(f"unknown command {command!r}", allowed=allowed)
        self.drive.append(entry)
        return entry

    def _wish(self, part: str) -> float:
        return float(round(self._steps[part] / STEPS * self.limits[part], DIGITS[part]))

    def facts(self) -> Mapping[str, str]:
        """Return the command in force."""
        speed, turn, sideways, height = map(self._wish, COMMAND)
        found = {
            "set speed": f"{speed:.2f} m/s",
            "set turn": f"{turn:.0f} °/s",
            "set sideways": f"{sideways:.2f} m/s",
            "set height": f"{100 * height:+.1f} cm",
        }
        return {name: value.replace("-", "−") for name, value in found.items()}

    def notice(self) -> str:
        """Say which part of the command the gait cannot follow."""
        part = self._beyond
        if not part:
            return ""
        most = {
            "turn": f"{self.limits['turn']:.0f} °/s",
            "height": f"{100 * self.limits['height']:.1f} cm",
        }.get(part, f"{self.limits[part]:.2f} m/s")
        return f"The {NAMES[part]} is clipped to {most}: this gait cannot do more."


class SteeredRobot(Steered):
    """A robot that stands at the start, and walks as a driver commands.

    Args:
        simulation: simulation of the robot.
        pilot: controller of the robot.
        framed: names of the channels of its motion that have frames.
        options: options with which the robot repeats a drive, besides the drive and its length.
    """

    frame_rate = FRAME_RATE

    def __init__(
        self,
        simulation: Simulation,
        pilot: Pilot,
        framed: Collection[str],
        options: Mapping[str, Any],
    ) -> None:
        self._simulation, self._pilot, self._framed = simulation, pilot, framed
        self._options = dict(options)
        self._new = list[dict[str, float]]()
        self._frames = round(LONGEST * FRAME_RATE) + 1
        self._target = np.zeros((1, self._frames, len(COMMAND)))
        self._walk = LockStep(simulation, pilot, self._target, Mover(simulation, 1))
        self._record = empty_record(simulation, 1, self._frames)
        self._wheel, self._now = Wheel(pilot.rhythm.limits[0]), 0

    def give(self, command: str) -> None:
        """Change the command by a step, stop, or push the robot."""
        entry = self._wheel.give(command, self._now / FRAME_RATE)
        if not entry:
            return
        self._new.append(entry)
        values = targets([{**entry, "at": 0.0}], 1, FRAME_RATE)[0]
        for column, name in enumerate(COMMAND):
            if name in entry:
                self._target[0, self._now :, column] = values[column]

    def advance(self, frames: int) -> Motion:
        """Simulate the next frames, which follow the robot standing at time 0."""
        if frames < 1:
            raise GaitsimError(f"cannot advance by {frames} frames", allowed="1 or more")
        first, last = self._now, self._now + frames
        if last >= self._frames:
            raise GaitsimError(f"a drive lasts at most {LONGEST:g} s")
        # Frame by frame, as sums over several frames would round differently.
        for frame in range(first, last):
            if self._record.lasted[0] == self._frames:  # it has not fallen
                self._move(frame)
        self._now = last
        return self._motion(first, last)

    def _move(self, frame: int) -> None:
        """Simulate and record the frame after a frame."""
        for push in pushes(self._new, FRAME_RATE).values():
            self._walk.mover.push(push)
        self._new.clear()
        before, robot = self._walk.mover.state.copy(), np.array([0])
        states, sensors = self._walk.advance(robot, frame, frame + 1)
        record_segment(
            self._simulation, self._record, robot, frame, frame + 1, before, states, sensors,
            self._walk.failures,
        )  # fmt: skip

    def _motion(self, first: int, last: int) -> Motion:
        """Return the motion in the frames after `first`, up to `last`."""
        frames = np.arange(first, last + 1)

        def cut(values: Any, rows: NDArray[np.intp]) -> dict[str, Any]:
            arrays = vars(values).items()
            return {
                name: array[:, rows]
                for name, array in arrays
                if isinstance(array, np.ndarray) and array.ndim > 1
            }

        lasted = np.clip(self._record.lasted - first, 0, len(frames))
        record = replace(self._record, **cut(self._record, frames), lasted=lasted)
        # What the robot felt in a frame moved it to the next one.
        felt = Feelings(**cut(self._walk.feelings, np.maximum(frames - 1, 0)))
        frequency = self._pilot.rhythm.frequency
        whole = motion_of(self._simulation, record, felt.angles, frequency, felt)
        failures = dict(self._record.failures)
        if self._record.lasted[0] < self._frames and not failures:
            failures[0] = "the robot fell"
        channels = {
            name: values[:, 1:] if name in self._framed else values
            for name, values in whole.items()
        }
        return Motion(FRAME_RATE, channels, failures=failures)

    def facts(self) -> Mapping[str, str]:
        """Return the command in force."""
        return self._wheel.facts()

    def notice(self) -> str:
        """Say which part of the command the gait cannot follow."""
        if beyond := self._wheel.notice():
            return beyond
        share = self._pilot.scale
        if share < SHORTENED:
            return f"The strides for all commands together are too long: clipped to {share:.0%}."
        return ""

    def drive(self) -> Mapping[str, Any]:
        """Return the commands up to now, their duration, and the other options."""
        return {
            "drive": [dict(entry) for entry in self._wheel.drive],
            "duration": max(self._now / FRAME_RATE, LEAST),
            **self._options,
        }

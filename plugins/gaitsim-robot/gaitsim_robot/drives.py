"""Drives: the commands that a driver gives to a robot over time."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import COMMAND, GaitsimError, Inputs, Motion, Rhythm, unknown
from gaitsim.plugin.toolkit import cos, sin

Floats = NDArray[np.float64]
Pushes = Mapping[int, Floats]
"""Sudden changes of a robot's velocity, (3,) m/s, by frame."""

PARTS = {
    "at": (3600.0, "s"),
    "speed": (10.0, "m/s"),
    "turn": (720.0, "°/s"),
    "sideways": (10.0, "m/s"),
    "height": (1.0, "m"),
    "push": (10.0, "m/s"),
    "direction": (360.0, "°"),
}
"""Parts of the entries of a drive, with their largest values and units."""


def check_drive(drive: Sequence[Mapping[str, float]]) -> None:
    """Validate a drive: known names, values within `PARTS`, in order of time.

    Raises:
        GaitsimError: an entry is invalid; the message has its number.
    """
    last = 0.0
    for number, entry in enumerate(drive, 1):
        where = f"entry {number}"
        for name, value in entry.items():
            if name not in PARTS:
                raise unknown("part of a command", name, PARTS, where=where, key="drive")
            most, unit = PARTS[name]
            least = 0.0 if name == "at" else -most
            if not least <= value <= most:
                raise GaitsimError(
                    f"invalid {name} in a drive: {value:g}",
                    where=where,
                    allowed=f"{least:g} to {most:g} {unit}",
                    key="drive",
                )
        if entry.get("at", 0.0) < last:
            raise GaitsimError(
                f"a drive must be in order of time, but {entry.get('at', 0.0):g} s follows "
                f"{last:g} s",
                where=where,
                allowed="times at that never decrease",
                key="drive",
            )
        last = entry.get("at", 0.0)


def targets(drive: Sequence[Mapping[str, float]], frames: int, frame_rate: float) -> Floats:
    """Return the command in each frame, (frames, 4), as `COMMAND`; 0 before the first entry.

    Parts that an entry does not name keep their values.

    Args:
        drive: entries with the time `at`, s, and parts of the command; the turn is in °/s.
        frames: number of frames.
        frame_rate: frames per second, Hz.
    """
    found = np.zeros((frames, len(COMMAND)))
    for entry in drive:
        first = frame_of(entry, frame_rate)
        for part, name in enumerate(COMMAND):
            if name in entry:
                value = math.radians(entry[name]) if name == "turn" else entry[name]
                found[first:, part] = value
    return found


SHORTENED = 0.98  # share of the commanded strokes below which gaitsim warns the driver


def clipped_commands(drive: Sequence[Mapping[str, float]], rhythm: Rhythm) -> str:
    """Return a warning about the commands for which strokes are shortened most; '' if none are.

    Args:
        drive: entries of the drive.
        rhythm: rhythm of one individual.
    """
    from gaitsim_robot.rhythm import RhythmState, advance  # Numba takes a while to import

    count = len(drive)
    rhythms = rhythm.select(np.zeros(count, dtype=np.intp))
    state, walking = RhythmState(rhythms), np.ones(count, dtype=np.bool_)
    commands = targets([{**entry, "at": at} for at, entry in enumerate(drive)], count, 1.0)
    inputs = Inputs.unchanged(commands, len(rhythm.names))
    advance(rhythms, state, walking, inputs, 0.02)
    worst = int(np.argmin(state.scale))
    if state.scale[worst] >= SHORTENED:
        return ""
    wanted, limits = commands[worst], rhythm.limits[0]
    parts = []
    for part, name in enumerate(COMMAND[:3]):
        if wanted[part]:
            turn, unit = math.degrees(1.0) if name == "turn" else 1.0, PARTS[name][1]
            said = f"{name} {turn * wanted[part]:.3g} of at most {turn * limits[part]:.2g} {unit}"
            parts.append(said.replace("-", "−"))
    together = " together" if len(parts) > 1 else ""
    at, share = drive[worst].get("at", 0.0), 100 * state.scale[worst]
    return (
        f"The drive exceeds what this gait can do: {', '.join(parts)}{together}, at {at:g} s; "
        f"strokes are shortened to {share:.0f} %."
    )


def pushes(drive: Sequence[Mapping[str, float]], frame_rate: float) -> dict[int, Floats]:
    """Return the pushes of a drive: changes of velocity, (3,) m/s, by frame."""
    found: dict[int, Floats] = {}
    for entry in drive:
        if entry.get("push"):
            angle, frame = math.radians(entry.get("direction", 0.0)), frame_of(entry, frame_rate)
            change = entry["push"] * np.array([float(cos(angle)), float(sin(angle)), 0.0])
            found[frame] = found.get(frame, 0.0) + change
    return found


CALIBRATION_TIME = 6.0  # s
SETTLED = 2.0  # s, start of the part of a motion from which true speeds are measured
LEAST, MOST_SHARE = 0.2, 2.0  # bounds of shares, for gaits that hardly obey a command


def true_shares(motion: Motion, commanded: Floats) -> tuple[float, float, float]:
    """Return true speed, turn and sideways speed as shares of the commanded ones.

    Args:
        motion: motion of three robots, with a command to walk, to turn, and to walk sideways.
        commanded: their commands, (3, 3); only the diagonal is not 0.
    """
    first = round(SETTLED * motion.frame_rate)
    place, yaw = motion["torso"][:, first:, :2], motion["orientation"][:, first:, 2]
    seconds = (yaw.shape[1] - 1) / motion.frame_rate
    steps = np.diff(place, axis=1)
    # Speeds in the frame of the trunk, which may turn.
    east, north = cos(yaw[:, :-1]), sin(yaw[:, :-1])
    forward = (east * steps[..., 0] + north * steps[..., 1]).sum(axis=1)
    aside = (east * steps[..., 1] - north * steps[..., 0]).sum(axis=1)
    true = np.array([forward[0], yaw[1, -1] - yaw[1, 0], aside[2]]) / seconds
    wanted = np.diag(commanded)
    share = np.divide(true, wanted, out=np.ones(3), where=wanted > 0)
    speed, turn, sideways = (float(one) for one in np.clip(share, LEAST, MOST_SHARE))
    return speed, turn, sideways


def frame_of(entry: Mapping[str, float], frame_rate: float) -> int:
    """Return the frame in which an entry of a drive takes effect."""
    return round(entry.get("at", 0.0) * frame_rate)

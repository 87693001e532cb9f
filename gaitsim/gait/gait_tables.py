"""Gaits as tables of text: times, units and names are those that the file states."""

import csv
import io
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

UNITS = {
    **dict.fromkeys(("rad", "radian", "radians"), 1.0),
    **dict.fromkeys(("deg", "degree", "degrees", "°"), np.pi / 180),
    "m": 1.0,
    "mm": 1e-3,
}
"""Factors to rad and m, by the unit in brackets after the name of a joint, or after '_'."""
TIMES = {
    **dict.fromkeys(("time_s", "time (s)", "time [s]", "time", "t", "seconds"), 1.0),
    **dict.fromkeys(("time_ms", "time (ms)", "time [ms]", "milliseconds"), 1e-3),
}
"""Factors to seconds, by the name of the first column."""
EVEN = 0.2  # of a step: how far times are from even ones that were rounded
SLOWEST = 1.0  # s, longest step of times whose name states no unit
DELIMITERS = (";", "\t", ",")
_UNIT = re.compile(r"(?P<name>.+?)(?:\s*[\[(](?P<unit>[^\])]+)[\])]|_(?P<suffix>rad|deg))")


def read_table(text: str, most: int, joints: int) -> dict[str, Any]:
    """Return the fields of a gait in a table.

    The first column is the time, the others are joints. Times are interpolated linearly if they
    are uneven, at the shortest step between two of them.

    Args:
        text: lines with commas, semicolons or tabs between cells; with the latter two, numbers may
            have decimal commas.
        most: largest number of frames.
        joints: largest number of joints.

    Returns:
        `joint_angles` (frames, joints) in rad or m, `joint_names`, `frame_rate`, `stated`: whether
        the name of each joint states its unit, and `notices`: what was changed.

    Raises:
        ValueError: the table is not a gait.
    """
    lines = io.StringIO(text)
    head = lines.readline()
    delimiter = next((one for one in DELIMITERS if one in head), ",")
    time, *columns = next(csv.reader([head], delimiter=delimiter), [""]) or [""]
    if (clock := TIMES.get(time.strip().lower())) is None:
        raise ValueError(
            f"its first column is not time_s but {time[:40]!r}; it may be {', '.join(TIMES)}"
        )
    if len(columns) > joints:
        raise ValueError(f"it has {len(columns):,} joints; at most {joints:,} are allowed")
    rest = lines.read()
    if delimiter != ",":
        rest = rest.replace(",", ".")
    table = np.loadtxt(io.StringIO(rest), delimiter=delimiter, comments=None, ndmin=2)
    named = [_named(name.strip()) for name in columns]
    angles = table[:, 1:] * np.array([factor or 1.0 for _, factor in named])
    fields = {
        "joint_angles": angles,
        "joint_names": np.array([name for name, _ in named]),
        "stated": np.array([factor is not None for _, factor in named], np.bool_),
    }
    if len(table) < 2 or not np.isfinite(table).all():
        return fields  # refused by the caller, who says why
    return {**fields, **_timed(table[:, 0] * clock, angles, time, most)}


def _named(column: str) -> tuple[str, float | None]:
    """Return the name of a joint, and the factor of its unit; None if it states none."""
    found = _UNIT.fullmatch(column)
    if found is None:
        return column, None
    unit = (found["unit"] or found["suffix"]).strip()
    if unit not in UNITS:
        raise ValueError(f"the column {column[:60]!r} has the unit {unit[:20]!r}, not {_units()}")
    return found["name"], UNITS[unit]


def _units() -> str:
    return ", ".join(UNITS)


def _timed(times: Floats, angles: Floats, name: str, most: int) -> dict[str, Any]:
    """Return the frame rate of angles, after interpolating those at uneven times."""
    steps = np.diff(times)
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 1
        raise ValueError(
            f"its times do not ascend: {times[row]:g} s in row {row + 1} follows {times[row - 1]:g}"
            " s"
        )
    if name.strip().lower() in ("time", "t") and np.median(steps) > SLOWEST:
        raise ValueError(
            f"its steps of {np.median(steps):g} look like milliseconds: name the first column "
            "time_ms, or time_s"
        )
    count = len(times) - 1
    span = float(times[-1] - times[0])
    away = np.abs(times - times[0] - np.arange(count + 1) * span / count).max()
    if away <= EVEN * span / count:
        return {"frame_rate": count / span}
    step = float(steps.min())
    if span / step >= most:
        raise ValueError(f"its shortest step, {step:g} s, gives more than {most:,} frames")
    grid = times[0] + step * np.arange(int(span / step + EVEN) + 1)
    even = np.stack([np.interp(grid, times, joint) for joint in angles.T], axis=1)
    return {
        "joint_angles": even,
        "frame_rate": 1 / step,
        "notices": (f"its times are uneven: interpolated at {1 / step:.4g} Hz",),
    }


def beyond_radians(angles: Floats, stated: Sequence[bool]) -> float:
    """Return the largest angle that no joint reaches in radians, with no unit stated; else 0."""
    unstated = angles[:, ~np.asarray(stated, np.bool_)] if len(stated) else angles
    largest = float(np.abs(unstated).max(initial=0.0))
    return largest if largest > 2 * np.pi else 0.0

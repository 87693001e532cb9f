"""Keyframes as CSV tables: degrees for any servo controller, goal positions for servo buses."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from gaitsim.gait.gait_files import check_folder
from gaitsim.runs.files.atomic import write_bytes
from gaitsim_hardware.calibration import Calibration
from gaitsim_hardware.keyframes import DECIMALS, Keyframes


def write_degrees(keyframes: Keyframes, path: Path) -> None:
    """Write servo angles as CSV, atomically.

    The columns are `time_ms`, then one for each joint, in degrees.
    """
    rows = [[f"{angle:.{DECIMALS}f}" for angle in row] for row in keyframes.degrees.tolist()]
    _write(keyframes, keyframes.joint_names, rows, path)


def write_ticks(keyframes: Keyframes, calibration: Calibration, path: Path) -> None:
    """Write the goal positions of servos on a bus as CSV, atomically.

    The columns are `time_ms`, then one for each servo, named after its id.
    """
    ids = [str(joint.id) for joint in calibration.joints.values()]
    _write(keyframes, ids, calibration.ticks(keyframes.degrees).tolist(), path)


def _write(
    keyframes: Keyframes, names: Sequence[str], rows: Sequence[Sequence[object]], path: Path
) -> None:
    check_folder(path)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time_ms", *names])
    for time, row in zip(keyframes.milliseconds.tolist(), rows, strict=True):
        writer.writerow([time, *row])
    write_bytes(path, text.getvalue().encode())

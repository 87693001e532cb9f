"""Write gaits to files for robots and other programs: MATLAB, CSV, NumPy."""

import csv
import io
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, RunError
from gaitsim.individual import Individual
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.runs.files.atomic import write_bytes


@dataclass(frozen=True, eq=False)
class Gait:
    """Joint angles over time.

    Attributes:
        angles: joint angles, (frames, joints) float64, radians.
        joint_names: name of each joint.
        frame_rate: frames per second, Hz.
        generation: generation of the individual; 0 if it has none.
        score: score of the individual.
        rest: joint angles of the standing pose, (joints,) rad; None for zeros.
    """

    angles: NDArray[np.float64]
    joint_names: tuple[str, ...]
    frame_rate: float
    generation: int
    score: float
    rest: NDArray[np.float64] | None = None

    @property
    def standing(self) -> NDArray[np.float64]:
        """The joint angles of the standing pose, (joints,) rad."""
        return np.zeros(self.angles.shape[1]) if self.rest is None else self.rest


def gait_of(individual: Individual) -> Gait:
    """Return the gait of an individual."""
    organism, entry = individual.experiment.organism, individual.experiment.entries["organism"]
    if "joint_angles" not in organism.channels:
        raise GaitsimError(
            f"{entry} has no joint angles",
            where=str(individual.source),
            allowed="a body with the channel 'joint_angles'",
        )
    motion = individual.motion
    with plugin_errors(entry, "moving the champion"):
        angles = np.asarray(motion["joint_angles"][0], dtype=np.float64)
        names = tuple(str(name) for name in organism.joint_names())
        frame_rate = float(motion.frame_rate)
        rest = np.asarray(organism.standing_pose(), dtype=np.float64)
    if angles.ndim != 2 or len(names) != angles.shape[1]:
        raise contract_error(
            entry,
            f"names {len(names)} joints, but its angles have the shape {angles.shape}",
            "a name for each joint of (population, frames, joints)",
        )
    if not 0 < frame_rate < np.inf:
        raise contract_error(entry, f"moves at {frame_rate} frames per second", "above 0")
    if rest.shape != (len(names),):
        raise contract_error(
            entry, f"returned a standing pose of shape {rest.shape}", f"({len(names)},)"
        )
    return Gait(angles, names, frame_rate, individual.generation, individual.score, rest)


def write_gait(gait: Gait, path: Path, format: str) -> None:
    """Write a gait atomically.

    Args:
        gait: gait to write.
        path: path of the file.
        format: 'mat' or 'npz', with `bestGait`, `frameRate`, `jointNames`, `units`, `generation`
            and `score`; or 'csv', with a column for the time in seconds and one per joint.
    """
    write = {"mat": _mat, "csv": _csv, "npz": _npz}[format]
    check_folder(path)
    write_bytes(path, write(gait))


def check_folder(path: Path) -> None:
    """Check the path of a file before computing its content."""
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    if os.path.isdir(path):  # noqa: PTH112
        raise RunError(f"cannot write {path}: it is a folder", remedy="give the path of a file")
    check_parent(path)


def check_parent(path: Path) -> None:
    """Check that the parent folder of a new file or folder exists."""
    if not os.path.isdir(path.parent):  # noqa: PTH112
        raise RunError(
            f"cannot write {path}: there is no folder {path.parent}",
            remedy="create the folder first",
        )


def _mat(gait: Gait) -> bytes:
    from scipy.io import savemat

    file = io.BytesIO()
    names = np.empty(len(gait.joint_names), dtype=object)  # a cell array of texts
    names[:] = gait.joint_names
    # SciPy's type stubs allow only paths.
    savemat(file, {**_fields(gait), "jointNames": names}, oned_as="column")  # type: ignore[arg-type]
    return file.getvalue()


def _npz(gait: Gait) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **_fields(gait), jointNames=np.array(gait.joint_names))  # type: ignore[arg-type]
    return file.getvalue()


def _fields(gait: Gait) -> dict[str, object]:
    return {
        "bestGait": gait.angles,
        "frameRate": gait.frame_rate,
        "units": "rad",
        "generation": gait.generation,
        "score": gait.score,
    }


def _csv(gait: Gait) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time_s", *gait.joint_names])
    for frame, row in enumerate(gait.angles.tolist()):
        writer.writerow([frame / gait.frame_rate, *row])
    return text.getvalue().encode()

"""Gait files, which hold joint angles: MATLAB, CSV and NumPy."""

import csv
import io
import os
import warnings
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation.playing import play, require_play
from gaitsim.experiment import Experiment
from gaitsim.gait.gait_tables import beyond_radians, read_table
from gaitsim.gait.matlab import read_matlab
from gaitsim.gait.robustness import Angles
from gaitsim.individual import Individual
from gaitsim.opening import read_regular
from gaitsim.registry import contract_error, plugin_errors
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.toml import literal, shortened


@dataclass(frozen=True, eq=False)
class Gait:
    """Joint angles over time.

    Attributes:
        angles: joint angles, (frames, joints) float64, radians, or metres of joints that slide.
        joint_names: name of each joint.
        frame_rate: frames per second, Hz.
        generation: generation of the individual; 0 if it has none.
        score: score of the individual.
        rest: joint angles of the standing pose, (joints,) rad; None for zeros.
        slides: names of the joints that slide.
    """

    angles: NDArray[np.float64]
    joint_names: tuple[str, ...]
    frame_rate: float
    generation: int
    score: float
    rest: NDArray[np.float64] | None = None
    slides: tuple[str, ...] = ()

    @property
    def units(self) -> str:
        """The units of the angles, such as 'radians; metres of FL_slide'."""
        return "radians" + f"; metres of {', '.join(self.slides)}" * bool(self.slides)

    @property
    def standing(self) -> NDArray[np.float64]:
        """The joint angles of the standing pose, (joints,) rad."""
        return np.zeros(self.angles.shape[1]) if self.rest is None else self.rest


def gait_of(individual: Individual) -> Gait:
    """Return the gait of an individual."""
    organism, entry = individual.body, individual.experiment.entries["organism"]
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
        slides = organism.sliding_joints()
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
    return Gait(angles, names, frame_rate, individual.generation, individual.score, rest, slides)


def write_gait(gait: Gait, path: Path, format: str) -> None:
    """Write a gait atomically.

    Args:
        gait: gait to write.
        path: path of the file.
        format: 'mat' or 'npz', with `bestGait`, `frameRate`, `jointNames`, `units`, `generation`
            and `score`; or 'csv', with a column for the time in seconds and one per joint.
    """
    write = {"mat": _write_mat, "csv": _write_csv, "npz": _write_npz}[format]
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


_MAT_HEADER = b"MATLAB 5.0 MAT-file, created by gaitsim".ljust(116)


def _write_mat(gait: Gait) -> bytes:
    from scipy.io import savemat

    file = io.BytesIO()
    names = np.empty(len(gait.joint_names), dtype=object)  # a cell array of texts
    names[:] = gait.joint_names
    # SciPy's type stubs allow only paths.
    savemat(file, {**_fields(gait), "jointNames": names}, oned_as="column")  # type: ignore[arg-type]
    # SciPy's header contains the time, but the same gait gives the same bytes.
    return _MAT_HEADER + file.getvalue()[len(_MAT_HEADER) :]


def _write_npz(gait: Gait) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **_fields(gait), jointNames=np.array(gait.joint_names))  # type: ignore[arg-type]
    return file.getvalue()


def _fields(gait: Gait) -> dict[str, object]:
    return {
        "bestGait": gait.angles,
        "frameRate": gait.frame_rate,
        "units": gait.units if gait.slides else "rad",
        "generation": gait.generation,
        "score": gait.score,
    }


def _write_csv(gait: Gait) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    radians = RADIANS * bool(beyond_radians(gait.angles, ()))  # wheels turn on and on
    names = [name + (METRES if name in gait.slides else radians) for name in gait.joint_names]
    writer.writerow(["time_s", *names])
    for frame, row in enumerate(gait.angles.tolist()):
        writer.writerow([frame / gait.frame_rate, *row])
    return text.getvalue().encode()


METRES, RADIANS = " [m]", " [rad]"  # after the names of joints in CSV
SUFFIXES = (".csv", ".npz", ".mat")
LARGEST = 64 * 2**20  # limit for the size of a file, packed and unpacked, bytes
MOST_FRAMES = 10_000  # the time of the footfall analysis grows with the square of the frames
MOST_JOINTS = 1000
_LONGEST = 100 * MOST_JOINTS  # limit for a line of CSV, bytes
_MEMBERS = 100  # limit for arrays in a .npz file
_SAME_RATE = 1e-3  # relative difference up to which frame rates are equal, as files round them
_ANGLES = ("joint_angles", "bestGait")
_RATE = ("frame_rate", "frameRate")
_NAMES = ("joint_names", "jointNames")
_CLOSED = 1e-6  # rad, difference of frames that are the same
_ALLOWED = (
    "a .csv with a column time_s and a column per joint, or a .npz or .mat with joint_angles or "
    "bestGait, (frames, joints) in radians"
)


@dataclass(frozen=True, eq=False)
class GaitFile:
    """Joint angles over time from a file.

    Attributes:
        path: path of the file.
        angles: joint angles, (frames, joints) float64, radians.
        frame_rate: frames per second, Hz; None if missing.
        joint_names: name of each joint; () if missing.
        notices: what was changed while it was read.
    """

    path: Path
    angles: Angles
    frame_rate: float | None
    joint_names: tuple[str, ...]
    notices: tuple[str, ...] = ()

    def left_over(self, joints: Sequence[str]) -> list[str]:
        """Return the names of columns that a body with these joints does not use."""
        return [name for name in self.joint_names if name not in joints]

    def repeated(self, times: int) -> "GaitFile":
        """Return the gait several times in a row; a last frame like the first is not doubled."""
        if times * len(self.angles) > MOST_FRAMES:
            raise GaitsimError(
                f"{self.path} has {len(self.angles):,} frames, too many to repeat {times:,} times",
                allowed=f"at most {MOST_FRAMES:,} frames in all",
            )
        closed = np.allclose(self.angles[0], self.angles[-1], atol=_CLOSED)
        cycle = self.angles[: len(self.angles) - closed]
        angles = np.concatenate([np.tile(cycle, (times, 1)), self.angles[-1:][:closed]])
        return replace(self, angles=angles)

    def in_order(self, joints: Sequence[str]) -> Angles:
        """Return the angles in the order of a body's joints; other columns are left over."""
        if not self.joint_names and self.angles.shape[1] == len(joints):
            return self.angles
        if len({*self.joint_names}) == len(self.joint_names) and {*joints} <= {*self.joint_names}:
            return self.angles[:, [self.joint_names.index(joint) for joint in joints]]
        unknown = self.left_over(joints)
        what = f"{self.path} has {self.angles.shape[1]} joints, but this body has {len(joints)}"
        if unknown:
            what = f"{self.path} has the joint {literal(unknown[0])}, which this body does not have"
        raise GaitsimError(
            what,
            allowed=f"{len(joints)} joints: {', '.join(joints[:4])} …",
            remedy="use a gait of the same body, or the body of this gait",
        )


def play_gait(file: GaitFile, experiment: Experiment) -> Individual:
    """Play a gait from a file on the body of an experiment, at the frame rate of the body."""
    angles = fit_to_body(file, experiment)
    return Individual.of_motion(experiment, play(experiment, angles[None]), file.path)


def fit_to_body(file: GaitFile, experiment: Experiment) -> Angles:
    """Return the angles in the order of a body's joints, at its frame rate.

    Angles at the frame rate of the body are returned unchanged, bit for bit.
    """
    require_play(experiment)
    with plugin_errors(experiment.entries["organism"], "naming its joints"):
        joints = tuple(experiment.organism.joint_names())
    angles = file.in_order(joints)
    if file.frame_rate is None:
        return angles
    rate = play(experiment, angles[None, :2]).frame_rate
    if abs(file.frame_rate / rate - 1) <= _SAME_RATE:
        return angles
    return _resample(file, angles, file.frame_rate, rate)


def _resample(file: GaitFile, angles: Angles, given: float, rate: float) -> Angles:
    """Interpolate angles linearly from one frame rate to another."""
    last = (len(angles) - 1) / given * rate
    if not 1 <= last < MOST_FRAMES:
        raise GaitsimError(
            f"{file.path} lasts {last / rate:g} s at {given:g} frames per second",
            allowed=f"{1 / rate:g} to {MOST_FRAMES / rate:g} s",
            remedy="check the frame rate, or use a part of the gait",
        )
    times = np.arange(int(last + 1e-9) + 1) * (given / rate)  # in frames of the file
    frames = np.arange(len(angles))
    return np.stack([np.interp(times, frames, joint) for joint in angles.T], axis=1)


def read_gait(path: Path, unit: Literal["rad", "deg"] | None = None) -> GaitFile:
    """Read a gait file, .csv, .npz or .mat; no code in it is executed.

    Args:
        path: path of the file.
        unit: unit of the angles of joints whose unit the file does not state; None takes radians,
            unless no joint could reach them.

    Raises:
        GaitsimError: the file is not a gait, or its angles cannot be radians.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise GaitsimError(f"{path} does not have the extension of a gait file", allowed=_ALLOWED)
    data = read_bounded(path, LARGEST)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # invalid values and headers are reported below
            return _check_fields(path, _READERS[suffix](data), unit)
    except GaitsimError:
        raise
    # Invalid data can make the readers raise any exception.
    except Exception as error:
        raise _invalid_file(path, shortened(str(error), 200) or type(error).__name__) from None


def read_bounded(path: Path, largest: int) -> bytes:
    """Return the content of a regular file of at most `largest` bytes."""
    try:
        return read_regular(path, largest, follow=True)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise GaitsimError(f"cannot read {path}: {reason}", remedy="check the path") from None


def read_npz(data: bytes, largest: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of a `.npz` file whose unpacked size is at most `largest` bytes."""
    if data.count(b"PK\1\2") > _MEMBERS:  # checked first, because reading the directory is slow
        raise ValueError(f"it contains more than {_MEMBERS} arrays")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        if sum(member.file_size for member in archive.infolist()) > largest:
            raise ValueError(f"it expands to more than {largest:,} bytes")
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        return dict(file)


def _check_fields(path: Path, fields: Mapping[str, Any], unit: str | None) -> GaitFile:
    found = next((fields[name] for name in _ANGLES if name in fields), None)
    if found is None:
        raise _invalid_file(path, f"it has neither {' nor '.join(_ANGLES)}")
    angles = np.asarray(found)
    if angles.dtype.kind not in "fiu" or angles.ndim != 2 or len(angles) < 2:
        raise _invalid_file(path, f"its angles have dtype {angles.dtype} and shape {angles.shape}")
    frames, joints = angles.shape
    if frames > MOST_FRAMES or joints > MOST_JOINTS:
        raise GaitsimError(
            f"{path} is too long: {frames:,} frames of {joints:,} joints",
            allowed=f"at most {MOST_FRAMES:,} frames and {MOST_JOINTS:,} joints",
            remedy="use a part of the gait",
        )
    angles = angles.astype(np.float64)
    if not np.isfinite(angles).all():
        raise _invalid_file(path, "its angles are not all finite")
    rate = next((float(np.ravel(fields[name])[0]) for name in _RATE if name in fields), None)
    if rate is not None and not 0 < rate < np.inf:
        raise _invalid_file(path, f"its frame rate is {rate}")
    names = np.ravel(next((fields[name] for name in _NAMES if name in fields), ()))
    if len(names) and names.dtype.kind != "U":
        raise _invalid_file(path, f"its joint names have dtype {names.dtype}; they should be text")
    if len(names) not in (0, joints):
        raise _invalid_file(path, f"it names {len(names):,} of its {joints:,} joints")
    stated = fields.get("stated", np.full(joints, "units" in fields))
    if unit == "deg":
        angles = np.where(stated, angles, np.radians(angles))
    elif unit is None and (largest := beyond_radians(angles, stated)):
        raise GaitsimError(
            f"{path} has angles up to {largest:.4g} without a unit, which no joint reaches in "
            "radians",
            allowed="radians, or names of columns with a unit, such as 'L1 knee [deg]'",
            remedy="add the unit to the names, or give it beside --gait: --gait-unit deg, or rad",
        )
    return GaitFile(path, angles, rate, tuple(names.tolist()), tuple(fields.get("notices", ())))


def _invalid_file(path: Path, reason: str) -> GaitsimError:
    return GaitsimError(f"{path} is not a gait file: {reason}", allowed=_ALLOWED)


def _read_npz(data: bytes) -> Mapping[str, Any]:
    return read_npz(data, LARGEST)


def _read_mat(data: bytes) -> Mapping[str, Any]:
    return read_matlab(data, (*_ANGLES, *_RATE, *_NAMES, "units"), LARGEST)


def _read_csv(data: bytes) -> Mapping[str, Any]:
    lines = data.count(b"\n")
    if lines > MOST_FRAMES + 1:
        raise ValueError(f"it has {lines:,} lines; at most {MOST_FRAMES:,} frames are allowed")
    if any(len(line) > _LONGEST for line in io.BytesIO(data)):
        raise ValueError(f"it has a line of more than {_LONGEST:,} bytes")
    return read_table(data.decode("utf-8-sig"), MOST_FRAMES, MOST_JOINTS)


_READERS = dict(zip(SUFFIXES, (_read_csv, _read_npz, _read_mat), strict=True))

"""The gaits of many individuals as compact data from which a page computes their motions."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Genomes, plugin_errors
from gaitsim.plugin.runs import Evaluator, Experiment, move_genomes
from gaitsim_page.packing import Packed, pack

MAX_WAVE_ERROR = 1e-6  # rad: maximum error of an angle computed from shared waves
SAMPLE_SIZE = 64  # number of individuals from which waves are derived
MAX_WAVES = 8
_CHUNK = 50  # individuals with motions in memory at once, per worker
_WAVE_STEP = 1e-9  # rounding of waves, which are at most 1
_STRIDE_STEP = float(np.radians(0.4))  # rounding of the angles of strides
_PERIOD_STEP = 1e-4  # rounding of periods, frames

SETTLED = 0.15  # share of the motion at its start in which the gait may not have settled
_SEARCHED = 4  # number of harmonics in the search for the period
_MAX_DIFFERENCE = 0.02  # differences of equal strides, as a share of the greatest difference

Floats = NDArray[np.float64]
Json = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Waves:
    """Functions of time whose linear combinations are the joint angles.

    Attributes:
        values: values over time, (waves, frames), at most 1.
        step: rounding of amplitudes, rad.
    """

    values: Floats
    step: float

    def amplitudes(self, angles: Floats) -> tuple[Floats, Floats]:
        """Return the amplitudes of the waves in joint angles, and the errors of their sums.

        Args:
            angles: (individuals, frames, joints) rad.

        Returns:
            Rounded amplitudes, (individuals, joints, waves) rad, and the largest error of each
            individual, (individuals,) rad.
        """
        courses = angles.swapaxes(1, 2)
        found = np.rint(courses @ np.linalg.pinv(self.values) / self.step) * self.step
        return found, np.abs(found @ self.values - courses).max(axis=(1, 2))


def shared_waves(angles: Floats) -> Waves | None:
    """Return the waves that joint angles share; None if more than `MAX_WAVES` are needed.

    Angles of one frequency, such as A sin(2πft + φ), are sums of a sine and a cosine. The
    Gram-Schmidt process on the angles over time, starting with the largest remainder, finds these
    waves and any others. A singular value decomposition takes 100 times as long.

    Args:
        angles: joint angles of some individuals, (individuals, frames, joints) rad.
    """
    courses = angles.swapaxes(1, 2).reshape(-1, angles.shape[1])
    left, found = courses.copy(), []
    for _ in range(MAX_WAVES):
        most = left[np.abs(left).max(axis=1).argmax()]
        size = np.abs(most).max()
        if size > 0:
            found.append(np.rint(most / size / _WAVE_STEP) * _WAVE_STEP)
            left -= np.outer(left @ found[-1], found[-1]) / (found[-1] @ found[-1])
        if np.abs(left).max() < MAX_WAVE_ERROR / 10:
            waves = np.array(found or [np.ones(len(most))])
            # Rounding changes each amplitude by at most half a step. The body may round its
            # angles, too, so the remainders differ slightly between individuals.
            spare = 0.98 * MAX_WAVE_ERROR - 2 * np.abs(left).max()
            return Waves(waves, float(2 * spare / np.abs(waves).sum(axis=0).max()))
    return None


def gaits_data(
    experiment: Experiment,
    genomes: Genomes,
    workers: int | None = None,
    *,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> Json | None:
    """Return the joint angles of individuals as data for a page; None for a body without joints.

    If all angles are sums of a few waves, the data are the waves and each individual's amplitudes,
    with a measured error of at most `MAX_WAVE_ERROR`. Otherwise the data are a stride of each
    individual, with an error of at most 0.2°. Only a part of the motions is in memory at any time.

    Args:
        experiment: experiment with the body.
        genomes: (individuals, genes).
        workers: number of workers; None chooses the body's default.
        begin: function called with the number of individuals to move, and once more with the new
            number if all must be moved a second time.
        advance: function called with the number of individuals moved since the last call.
    """
    channel = experiment.organism.channels.get("joint_angles")
    if channel is None or channel.axes != ("frames", "joints") or not len(genomes):
        return None
    some = genomes[np.unique(np.linspace(0, len(genomes) - 1, SAMPLE_SIZE).astype(int))]
    angles, rate = _angles(experiment, some)
    shared: Json = {"joints": list(experiment.organism.joint_names()), "frameRate": rate}
    waves = shared_waves(angles)
    begin(len(genomes))
    if waves is not None:
        work = partial(_wave_amplitudes, waves=waves)
        amounts, errors = map_genomes(experiment, genomes, work, workers, advance)
        if errors.max() <= MAX_WAVE_ERROR:
            return shared | {
                "form": "waves",
                "frames": angles.shape[1],
                "waves": pack(waves.values, _WAVE_STEP),
                "error": float(errors.max()),
                **_compact(amounts.reshape(len(genomes), -1), waves.step),
            }
        begin(2 * len(genomes))
    return shared | strides_data(*map_genomes(experiment, genomes, _strides, workers, advance))


def map_genomes(
    experiment: Experiment,
    genomes: Genomes,
    work: Callable[..., tuple[NDArray[Any], ...]],
    workers: int | None,
    advance: Callable[[int], object],
) -> list[NDArray[Any]]:
    """Return the arrays of a function of the experiment and genomes, called for some at a time."""
    parts: list[tuple[NDArray[Any], ...]] = []
    with Evaluator(experiment, workers) as evaluator:
        step = 2 * evaluator.workers * _CHUNK
        for start in range(0, len(genomes), step):
            some = genomes[start : start + step]
            parts += evaluator.map(work, np.split(some, range(_CHUNK, len(some), _CHUNK)))
            advance(len(some))
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def strides_data(periods: Floats, lengths: Floats, changes: Floats, errors: Floats) -> Json:
    """Return the arrays of `strides_of` as data for a page."""
    return {
        "form": "strides",
        "periods": pack(periods, _PERIOD_STEP),
        "lengths": pack(lengths, 1.0),
        "error": float(errors.max()),
        **_compact(changes, _STRIDE_STEP),
    }


def _compact(amounts: Floats, step: float) -> Json:
    """Return amounts (individuals, …) relative to the lowest one, which avoids signs.

    The amounts are in one row, as `pack` stores differences between rows, which would have a
    wider range here. Together these save a tenth of the file.
    """
    lowest = float(np.rint(amounts.min() / step) * step)
    found: Packed = pack((amounts - lowest).reshape(1, -1), step)
    return {"lowest": lowest, "amounts": found}


def _angles(experiment: Experiment, genomes: Genomes) -> tuple[Floats, float]:
    """Return the joint angles, (individuals, frames, joints) rad, and the frame rate, Hz."""
    motion = move_genomes(experiment, genomes)
    with plugin_errors(experiment.entries["organism"], "computing the channel 'joint_angles'"):
        angles = np.asarray(motion["joint_angles"], np.float64)
    return np.nan_to_num(angles), float(motion.frame_rate)


def _wave_amplitudes(
    experiment: Experiment, genomes: Genomes, waves: Waves
) -> tuple[Floats, Floats]:
    return waves.amplitudes(_angles(experiment, genomes)[0])


def _strides(experiment: Experiment, genomes: Genomes) -> tuple[Floats, Floats, Floats, Floats]:
    return strides_of(_angles(experiment, genomes)[0])


def strides_of(motions: Iterable[Floats]) -> tuple[Floats, Floats, Floats, Floats]:
    """Return one stride of each individual.

    Args:
        motions: joint angles of each individual, (frames, joints) rad; the joints may differ.

    Returns:
        The periods, (individuals,) frames; the lengths, (individuals,) frames; the rounded angles
        as changes from frame to frame, starting from zero, by individual, joint and frame, rad;
        and the largest error of each individual, rad.
    """
    periods, lengths, changes, errors = [], [], [], []
    for angles in motions:
        period, stride = stride_of(angles)
        steps = np.rint(stride / _STRIDE_STEP)
        periods.append(period)
        lengths.append(len(stride))
        changes.append(np.diff(steps, axis=0, prepend=0.0).T.ravel() * _STRIDE_STEP)
        errors.append(np.abs(steps * _STRIDE_STEP - stride).max(initial=0.0))
    return np.array(periods), np.array(lengths), np.concatenate(changes), np.array(errors)


def stride_of(angles: Floats) -> tuple[float, Floats]:
    """Return a stride of a gait after it has settled.

    Args:
        angles: (frames, joints) rad.

    Returns:
        The period of the stride in frames, usually a fraction, and the angles of its frames and
        one more, (frames, joints) rad, so that angles can be interpolated up to the end. For a
        motion that does not repeat, such as one with an early fall, the number of frames after
        settling and their angles.
    """
    changing = np.flatnonzero(np.diff(angles, axis=0).any(axis=1))
    end = int(changing[-1]) + 2 if len(changing) else len(angles)  # a fallen body does not move
    settled = angles[min(int(SETTLED * end), max(end - 2, 0)) : end]
    period = _period(settled)
    if period > len(settled) - 1:
        return float(len(settled)), settled
    return period, settled[: int(np.ceil(period)) + 1]


def _basis(frames: int, period: float, harmonics: int) -> Floats:
    """Return ones, cosines and sines over time, (frames, 1 + 2 harmonics)."""
    turns = 2 * np.pi / period * np.outer(np.arange(frames), np.arange(1, harmonics + 1))
    return np.concatenate([np.ones((frames, 1)), np.cos(turns), np.sin(turns)], axis=1)


def _period(angles: Floats) -> float:
    """Return the period of joint angles (frames, joints) in frames, or `frames` without a period.

    The period is the first shift by whole frames that hardly changes the angles, refined by least
    squares.
    """
    frames = len(angles)
    if frames < 6:
        return float(frames)
    lags = np.arange(2, int(0.85 * frames) + 1)
    differences = np.array([np.mean((angles[lag:] - angles[:-lag]) ** 2) for lag in lags])
    if not differences.max() > 0:
        return float(frames)
    near = differences <= differences.min() + _MAX_DIFFERENCE * differences.max()
    # Skip short shifts, up to the first that changes the angles: neighbouring frames are similar.
    first = int(np.argmax(differences > differences.max() / 3))
    candidates = np.flatnonzero(near[first:]) + first
    if not len(candidates):
        return float(frames)
    lag = int(candidates[0])
    while lag + 1 < len(lags) and differences[lag + 1] < differences[lag]:
        lag += 1
    if lag + 1 == len(lags):  # the motion ends before the minimum
        return float(frames)
    guess = float(lags[lag])
    for reach, count in ((0.75, 16), (0.06, 9), (0.01, 9)):
        tried = guess + np.linspace(-reach, reach, count)
        guess = float(min(tried, key=lambda period: _misfit(angles, period)))
    return guess


def _misfit(angles: Floats, period: float) -> float:
    basis = _basis(len(angles), period, max(1, min(_SEARCHED, int(period / 2))))
    orthonormal = np.linalg.qr(basis)[0]
    return float(np.sum((angles - orthonormal @ (orthonormal.T @ angles)) ** 2))

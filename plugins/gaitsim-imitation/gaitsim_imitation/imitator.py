"""A network that plays a gait by predicting each frame from the previous one."""

import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, shortened
from gaitsim.plugin.gait import Gait, read_bounded, read_npz
from gaitsim.plugin.runs import write_bytes
from gaitsim.plugin.toolkit import Network

Angles = NDArray[np.float64]
"""Joint angles, (frames, joints), radians."""

TURN = 2 * math.pi
"""Limit of commanded angles, a whole turn, so that a diverging network does not overflow."""


@dataclass(frozen=True, eq=False)
class Imitator:
    """A network that maps the joint angles of one frame to the joint angles of the next frame.

    Attributes:
        network: network with an input and an output for each joint.
        centre: angles at which the inputs are 0, (joints,), radians.
        scale: difference from the centre at which an input is 1, radians.
    """

    network: Network
    centre: NDArray[np.float64]
    scale: float

    def predict(self, frames: Angles) -> Angles:
        """Predict the frames after given frames, (frames, joints), radians."""
        answers: NDArray[Any] = self.network.activate(((frames - self.centre) / self.scale).T)
        return answers.T * self.scale + self.centre

    def free_run(self, first: NDArray[np.float64], frames: int) -> Angles:
        """Play without the expert: predict each frame from the previous prediction.

        Args:
            first: first frame, (joints,), radians.
            frames: number of frames, including the first.

        Returns:
            Joint angles, (frames, joints), radians.
        """
        played = np.empty((frames, len(first)))
        played[0] = first
        for frame in range(1, frames):
            commanded = self.predict(played[frame - 1 : frame])[0]
            played[frame] = np.clip(commanded, -TURN, TURN)
        return played

    def one_step_error(self, expert: Angles) -> float:
        """Return the mean squared error of predictions from the expert's frames, rad²."""
        return float(np.mean(np.square(self.predict(expert[:-1]) - expert[1:])))


LARGEST = 64 * 2**20  # bytes, packed and unpacked


@dataclass(frozen=True, eq=False)
class Imitation:
    """A network and the gait that it plays.

    Attributes:
        gait: gait as the body played it, with the expert's generation; its score is NaN if the
            body cannot play joint angles.
        commanded: angles from the network, (frames, joints), radians; they differ from the gait's
            angles where they exceed the body's limits.
        imitator: network with its scaling.
        seed: seed of the training.
    """

    gait: Gait
    commanded: Angles
    imitator: Imitator
    seed: int


def save_imitator(imitation: Imitation, path: Path) -> None:
    """Write an imitation atomically, without pickles."""
    imitator = imitation.imitator
    network = imitator.network
    layers = {
        f"{kind}{layer}": array
        for kind, arrays in (("W", network.weights), ("b", network.biases))
        for layer, array in enumerate(arrays, 1)
    }
    file = io.BytesIO()
    fields: Mapping[str, Any] = {
        "joint_angles": imitation.gait.angles,
        "commanded": imitation.commanded,
        "frame_rate": imitation.gait.frame_rate,
        "joint_names": np.array(imitation.gait.joint_names),
        "units": "rad",
        "generation": imitation.gait.generation,
        "score": imitation.gait.score,
        "seed": imitation.seed,
        "activation": network.activation,
        "output": network.output,
        "centre": imitator.centre,
        "scale": imitator.scale,
        **layers,
    }
    np.savez_compressed(file, **fields)
    write_bytes(path, file.getvalue())


def load_imitator(path: Path) -> Imitation:
    """Read a file written by `save_imitator`, without executing anything in it."""
    data = read_bounded(path, LARGEST)
    try:
        return _imitation(read_npz(data, LARGEST))
    except KeyError as error:
        reason = f"{error.args[0]!r} is missing"
    except ValueError as error:
        reason = shortened(str(error), 200)
    except Exception as error:  # untrusted bytes can make the readers raise any exception
        reason = shortened(f"{type(error).__name__}: {error}", 200)
    raise GaitsimError(
        f"{path} is not an imitator file: {reason}",
        allowed="an imitator.npz written by 'gaitsim imitate'",
    )


def _imitation(fields: Mapping[str, NDArray[Any]]) -> Imitation:
    angles, commanded = _numbers(fields, "joint_angles", 2), _numbers(fields, "commanded", 2)
    given = fields["joint_names"]
    joints = given.size
    if angles.shape != commanded.shape or angles.shape[1] != joints or len(angles) < 2:
        raise ValueError(
            f"the arrays of angles have the shapes {angles.shape} and {commanded.shape}; both must "
            f"be (frames, {joints}), with at least 2 frames"
        )
    names = tuple(str(name) for name in given)
    count = sum(name[:1] == "W" and name[1:].isdecimal() for name in fields)
    network = Network(
        tuple(_numbers(fields, f"W{layer}", 2) for layer in range(1, count + 1)),
        tuple(_numbers(fields, f"b{layer}", 1) for layer in range(1, count + 1)),
        str(fields["activation"]),
        str(fields["output"]),
    )
    centre, scale = _numbers(fields, "centre", 1), float(_numbers(fields, "scale", 0))
    rate = float(_numbers(fields, "frame_rate", 0))
    if {network.sizes[0], network.sizes[-1], len(centre)} != {joints}:
        raise ValueError(
            f"the network has layers of {network.sizes} units and the centre has {len(centre)} "
            f"angles; expected {joints} inputs, outputs and angles, one per joint"
        )
    if rate <= 0 or scale <= 0:
        raise ValueError(f"the frame rate ({rate}) and the scale ({scale}) must be positive")
    gait = Gait(angles, names, rate, int(fields["generation"]), float(fields["score"]))
    return Imitation(gait, commanded, Imitator(network, centre, scale), int(fields["seed"]))


def _numbers(fields: Mapping[str, NDArray[Any]], name: str, dimensions: int) -> Angles:
    array = fields[name]
    if array.dtype.kind not in "fiu" or array.ndim != dimensions:
        raise ValueError(
            f"{name!r} must be an array of numbers with {dimensions} axes, but has dtype "
            f"{array.dtype} and shape {array.shape}"
        )
    values: Angles = array.astype(np.float64)
    if not np.isfinite(values).all():
        raise ValueError(f"{name!r} has values that are not finite")
    return values

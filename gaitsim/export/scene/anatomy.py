"""What a skeleton looks like: how thick its limbs are, and which of its segments frame a body."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton

THICKNESS = 0.13  # a limb's radius, in lengths of the middle segment
SLENDER = 0.022  # and at most, in spans of the body


@dataclass(frozen=True, eq=False)
class Anatomy:
    """How to draw a skeleton, told from its segments alone.

    Attributes:
        limbs: indices of the segments that are limbs, (limbs,).
        radii: of both ends of each limb, (limbs, 2) m.
        trunks: which of them are what others are hinged on, (limbs,).
        plates: segments that form a closed loop, such as a body's outline or a wing.
        plate_radii: half of each plate's thickness, m.
        span: of the body, m.
    """

    limbs: NDArray[np.intp]
    radii: NDArray[np.float64]
    trunks: NDArray[np.bool_]
    plates: tuple[tuple[int, ...], ...]
    plate_radii: tuple[float, ...]
    span: float


def anatomy(skeleton: Skeleton) -> Anatomy:
    """Look at a skeleton.

    A limb is thick where it joins others or the body and thin at its free end; a segment
    that joins nothing at its ends and touches nothing, such as a spine, is a trunk.
    """
    segments = skeleton.segments.astype(np.float64)
    lengths = np.median(np.linalg.norm(segments[:, :, 1] - segments[:, :, 0], axis=-1), axis=0)
    about = segments - np.asarray(skeleton.path, dtype=np.float64)[:, None, None]
    span = max(float(np.ptp(about.reshape(-1, 3), axis=0).max()), 1e-6)
    plates = _loops(segments, 1e-6 * span)
    framed = {index for plate in plates for index in plate}
    limbs = np.array([i for i in range(len(skeleton.names)) if i not in framed], dtype=np.intp)
    usual = float(np.median(lengths[limbs])) if len(limbs) else span
    radius = max(min(THICKNESS * usual, SLENDER * span), 0.004 * span)
    ends = segments[0].reshape(-1, 3)
    near = np.linalg.norm(ends[:, None] - ends, axis=-1) < 1e-6 * span
    shared = (near.sum(axis=1) > 1).reshape(-1, 2)
    radii = np.where(shared, 1.0, 0.6)
    lonely = np.zeros(len(radii), dtype=np.bool_)
    if skeleton.contacts is not None:
        feet = skeleton.contacts[0].astype(np.float64)
        foot = (np.linalg.norm(ends[:, None] - feet, axis=-1) < 1e-3 * span).any(axis=1)
        lonely = ~(shared | foot.reshape(-1, 2)).any(axis=1)
        radii[lonely] = 2.2
        radii[~foot.reshape(-1, 2) & ~lonely[:, None]] = 1.0
    shortest = [float(lengths[list(plate)].min()) for plate in plates]
    return Anatomy(
        limbs,
        radius * radii[limbs],
        lonely[limbs],
        plates,
        tuple(0.04 * length for length in shortest),
        span,
    )


def _loops(segments: NDArray[np.float64], tolerance: float) -> tuple[tuple[int, ...], ...]:
    """Runs of segments, each beginning where the one before ends, that close on themselves."""
    starts, ends = segments[0, :, 0], segments[0, :, 1]
    found: list[tuple[int, ...]] = []
    first = 0
    while first < len(starts):
        last = first
        while last + 1 < len(starts) and _near(ends[last], starts[last + 1], tolerance):
            last += 1
            if last - first >= 2 and _near(ends[last], starts[first], tolerance):
                found.append(tuple(range(first, last + 1)))
                break
        else:
            first += 1
            continue
        first = last + 1
    return tuple(found)


def _near(one: NDArray[np.float64], other: NDArray[np.float64], tolerance: float) -> bool:
    return float(np.linalg.norm(one - other)) <= tolerance

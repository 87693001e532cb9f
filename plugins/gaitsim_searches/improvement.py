"""Improvement of an archive by candidates, which the emitters of CMA-ME and CMA-MAE maximise."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.portable import power
from gaitsim_searches.archive import Archive, Candidates


@dataclass(frozen=True)
class SoftThresholds:
    """Parameters of thresholds that rise slowly, so that a cell rewards several improvements.

    Attributes:
        minimum: threshold of an empty cell.
        rate: learning rate of the thresholds, 0 to 1.
    """

    minimum: float
    rate: float


@dataclass(frozen=True, eq=False)
class Improvement:
    """Improvement of an archive by each candidate, compared with the archive before the batch.

    Attributes:
        status: 2 if a candidate discovers a cell, 1 if it improves a cell, otherwise 0,
            (candidates,) int64.
        gain: score minus the threshold of the cell, (candidates,); −inf for an invalid candidate.
    """

    status: NDArray[np.int64]
    gain: NDArray[np.float64]


def improvement(
    archive: Archive, candidates: Candidates, soft: SoftThresholds | None
) -> Improvement:
    """Return the improvement by each candidate.

    Without soft thresholds, the gain of a candidate that discovers a cell is its score, as in
    Fontaine, Togelius, Nikolaidis and Hoover 2020, "Covariance matrix adaptation for the rapid
    illumination of behavior space".
    """
    empty = soft.minimum if soft else -np.inf
    limits = archive.lookup(candidates.cells, archive.thresholds, empty)
    occupied = archive.lookup(candidates.cells, np.ones(len(archive.cells)), 0) > 0
    accepted = candidates.valid & (candidates.scores > limits)
    gain = candidates.scores - np.where(occupied, limits, soft.minimum if soft else 0)
    return Improvement(
        np.where(accepted, np.where(occupied, 1, 2), 0), np.where(candidates.valid, gain, -np.inf)
    )


def with_soft_thresholds(
    before: Archive, after: Archive, candidates: Candidates, soft: SoftThresholds
) -> Archive:
    """Return the archive after an insertion, with the thresholds of CMA-MAE.

    Every candidate above the threshold of its cell moves the threshold towards its score; a whole
    batch is applied at once (Fontaine and Nikolaidis 2023, "Covariance matrix adaptation
    MAP-annealing", appendix).
    """
    thresholds = before.lookup(after.cells, before.thresholds, soft.minimum)
    accepted = improvement(before, candidates, soft).status > 0
    slots = np.searchsorted(after.cells, candidates.cells[accepted])
    counts = np.bincount(slots, minlength=len(thresholds))
    sums = np.bincount(slots, candidates.scores[accepted], len(thresholds))
    kept = power(1 - soft.rate, counts)
    moved = kept * thresholds + (1 - kept) * sums / np.maximum(counts, 1)
    return replace(after, thresholds=np.where(counts > 0, moved, thresholds))

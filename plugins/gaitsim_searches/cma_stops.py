"""Stopping criteria of CMA-ES, after which it restarts."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

SMALLEST_RANGE = 1e-11  # range of scores that counts as equal
LARGEST_CONDITION = 1e14  # condition number of the covariance
LONGEST_HISTORY = 20_000  # number of updates remembered


def converged(
    state: Mapping[str, NDArray[Any]], scores: NDArray[np.float64], tolerance: float
) -> bool:
    """Return whether the search has converged (Hansen 2016, appendix B.3).

    Args:
        state: state after the update.
        scores: scores of the samples of the update.
        tolerance: smallest standard deviation worth sampling, in widths.
    """
    genes, samples, updates = len(state["mean"]), len(scores), int(state["updates"])
    step, mean, lengths = float(state["step"]), state["mean"], state["lengths"]
    covariance = state["covariance"]
    deviations = step * np.sqrt(np.diag(covariance) if covariance.ndim == 2 else covariance)
    axis = updates % genes
    along = np.eye(genes)[axis] if covariance.ndim == 1 else state["axes"][axis]
    if (mean == mean + 0.1 * step * lengths[axis] * along).all():
        return True
    if (mean == mean + 0.2 * deviations).any() or lengths.max() > np.sqrt(
        LARGEST_CONDITION
    ) * lengths.min():
        return True
    if (deviations < tolerance).all() and (step * np.abs(state["path"]) < tolerance).all():
        return True
    best, middle = state["best scores"], state["middle scores"]
    recent = 10 + int(np.ceil(30 * genes / samples))
    if len(best) >= recent and _range(np.append(scores, best[-recent:])) < SMALLEST_RANGE:
        return True
    return len(best) >= _history_length(genes, samples, updates) and all(
        np.median(scores[-(len(scores) * 3 // 10) :]) <= np.median(scores[: len(scores) * 3 // 10])
        for scores in (best, middle)
    )


def history(
    scores: NDArray[np.float64], latest: float, genes: int, samples: int, updates: int
) -> NDArray[np.float64]:
    """Append the latest score to a history, and drop scores that `converged` no longer needs."""
    return np.append(scores, latest)[-_history_length(genes, samples, updates) :]


def _history_length(genes: int, samples: int, updates: int) -> int:
    """Return the number of updates whose scores `converged` compares."""
    shortest = 120 + 30 * genes // samples
    return min(max(shortest, updates // 5), LONGEST_HISTORY)


def _range(scores: NDArray[np.float64]) -> float:
    lowest, highest = scores.min(), scores.max()
    return 0.0 if lowest == highest else float(highest - lowest)  # 0 even if all are −inf

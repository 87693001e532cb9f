"""Find the conditions of the world that reduce a result, and in which intervals.

The range of each condition is divided into thirds. The share of the variance that the means of the
thirds explain is the first-order sensitivity index from given data (Plischke, Borgonovo and Smith
2013, "Global sensitivity measures from given data"). Unlike a correlation, it detects a condition
that hurts on both sides, such as a slope. A condition is reported only if its share exceeds the
largest share of all conditions in 95 % of random permutations of the results (Westfall and Young
1993, "Resampling-based multiple testing").
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.gait.feet import Floats

PARTS = 3
LEAST = 12  # least number of worlds: four per third
PERMUTATIONS = 999
LEVEL = 0.05
MOST_PERMUTED = 2**20  # number of values permuted at a time, 8 MB


@dataclass(frozen=True)
class Effect:
    """The effect of a condition on a result.

    Attributes:
        condition: name of the condition.
        share: share of the variance of the result over worlds, from 0 to 1, corrected for chance.
        p: probability of at least this share by chance, corrected for multiple conditions.
        hurting: intervals in which the result is low, (low, high) each, ascending.
        loss: mean result of the worlds outside these intervals, minus the mean result within.
    """

    condition: str
    share: float
    p: float
    hurting: tuple[tuple[float, float], ...]
    loss: float

    def within(self, values: Floats) -> NDArray[np.bool_]:
        """Return whether each value of the condition, (worlds,), is in an interval that hurts."""
        inside = np.zeros(len(values), dtype=np.bool_)
        for low, high in self.hurting:
            inside |= (low <= values) & (values <= high)
        return inside


def effects(
    conditions: Mapping[str, Floats], ranges: Mapping[str, tuple[float, float]], results: Floats
) -> tuple[Effect, ...]:
    """Return the conditions that affect a result significantly, the strongest first.

    Args:
        conditions: values of each condition by name, (worlds,) each.
        ranges: lowest and highest value of each condition.
        results: result in each world, (worlds,), higher is better; non-finite values are ignored.
    """
    counted = np.isfinite(results)
    names = [name for name in conditions if ranges[name][0] < ranges[name][1]]
    y = results[counted]
    if len(y) < LEAST or not names or np.ptp(y) <= 1e-9 * np.abs(y).max():
        return ()
    y = y - y.mean()
    edges = np.array([np.linspace(*ranges[name], PARTS + 1) for name in names])
    parts = np.stack(
        [
            np.searchsorted(inner, conditions[name][counted])
            for name, inner in zip(names, edges[:, 1:-1], strict=True)
        ]
    )
    member = (parts[:, None] == np.arange(PARTS)[:, None]).astype(np.float64)
    counts = member.sum(axis=2)  # (conditions, parts)
    shares = _explained(y[None], member, counts)[0]
    largest = _largest_by_chance(y, member, counts)
    found = []
    for index in np.argsort(-shares, kind="stable").tolist():
        p = float((1 + (largest >= shares[index]).sum()) / (1 + PERMUTATIONS))
        if p > LEVEL:
            break
        found.append(_effect(names[index], edges[index], parts[index], y, float(shares[index]), p))
    return tuple(found)


def _explained(results: Floats, member: Floats, counts: Floats) -> Floats:
    """Return the share of the variance that the means of the parts explain.

    Args:
        results: results with a mean of 0, (draws, worlds).
        member: 1 if a world is in a part, else 0, (conditions, parts, worlds).
        counts: number of worlds in each part, (conditions, parts).

    Returns:
        The shares, (draws, conditions).
    """
    flat = member.reshape(-1, member.shape[2])
    sums = (results @ flat.T).reshape(len(results), *counts.shape)
    between = np.where(counts > 0, sums**2 / np.maximum(counts, 1), 0.0).sum(axis=2)
    shares: Floats = between / (results**2).sum(axis=1, keepdims=True)
    return shares


def _largest_by_chance(results: Floats, member: Floats, counts: Floats) -> Floats:
    """Return the largest share of all conditions in each permutation, (permutations,)."""
    rng, most = np.random.default_rng(0), max(1, MOST_PERMUTED // len(results))
    largest = []
    for start in range(0, PERMUTATIONS, most):
        draws = min(most, PERMUTATIONS - start)
        permuted = rng.permuted(np.tile(results, (draws, 1)), axis=1)
        largest.append(_explained(permuted, member, counts).max(axis=1))
    return np.concatenate(largest)


def _effect(
    name: str, edges: Floats, parts: NDArray[np.intp], results: Floats, share: float, p: float
) -> Effect:
    occupied = [part for part in range(PARTS) if (parts == part).any()]
    means = {part: results[parts == part].mean() for part in occupied}
    low, high = min(means.values()), max(means.values())
    # With a linear response, the middle third is half-way and does not count as hurting.
    hurting = [part for part in occupied if means[part] <= low + (high - low) / 3]
    inside = np.isin(parts, hurting)
    worlds, groups = len(results), len(occupied)
    return Effect(
        name,
        max(0.0, 1 - (1 - share) * (worlds - 1) / (worlds - groups)),
        p,
        _join_intervals([(float(edges[part]), float(edges[part + 1])) for part in hurting]),
        float(results[~inside].mean() - results[inside].mean()),
    )


def _join_intervals(intervals: list[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Join adjacent intervals."""
    joined: list[tuple[float, float]] = []
    for low, high in intervals:
        touches = bool(joined) and joined[-1][1] == low
        joined.append((joined.pop()[0] if touches else low, high))
    return tuple(joined)

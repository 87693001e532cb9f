"""Transfer the map of an atlas to another intact body, the body's twin in rigid-body physics."""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from gaitsim.adaptation.prior import OnProgress, Prior, atlas_members
from gaitsim.adaptation.trials import MeasureGait
from gaitsim.errors import GaitsimError
from gaitsim.runs.snapshot import RunSnapshot

MAX_MEASURED = 100  # number of gaits measured on the other body


def count_intact_gaits(run: RunSnapshot, *, physics: bool) -> int:
    """Return the largest number of gaits measured on intact bodies before an adaptation."""
    members = len(atlas_members(run).scores)
    return members + (min(members, MAX_MEASURED) if physics else 0)


def measure_intact(
    prior: Prior,
    measure_gait: MeasureGait,
    pool: Executor,
    on_progress: OnProgress = lambda done: None,
) -> dict[int, float]:
    """Measure the most promising gaits on another intact body.

    Args:
        prior: map for the atlas's own body.
        measure_gait: function that measures a gait on the other body.
        pool: thread pool in which the gaits are measured.
        on_progress: called with the number of gaits measured since the last call.

    Returns:
        The measured performance by member, counted from 1.
    """
    members = most_promising(prior, MAX_MEASURED)
    found: dict[int, float] = {}
    for member, value in zip(
        members, pool.map(measure_gait, map(prior.individual, members)), strict=True
    ):
        found[member] = value
        on_progress(1)
    if not max(found.values()) > 0:
        raise GaitsimError(
            f"the measure {prior.measure!r} is not above 0 for any of the {len(found)} best "
            f"gaits of the atlas {prior.source} on the intact body in rigid-body physics",
            remedy="evolve the atlas further with 'gaitsim resume', or omit --physics",
        )
    return found


def most_promising(prior: Prior, count: int) -> tuple[int, ...]:
    """Return the numbers, from 1, of the members with the best performance above 0, best first."""
    order = np.argsort(-prior.performance, kind="stable")[:count]
    return tuple(int(index) + 1 for index in order if prior.performance[index] > 0)


def transfer_map(prior: Prior, measured: Mapping[int, float]) -> Prior:
    """Return the map for another intact body, given measurements of some gaits on that body.

    Measured gaits get their measured performance. The performance of all other gaits is scaled by
    the median ratio of measured performance to performance in the map.

    Args:
        prior: map for the atlas's own body.
        measured: performance on the other body by member, counted from 1. Each of these members
            must have a performance above 0 in the map.
    """
    indices, values = np.array([*measured]) - 1, np.array([*measured.values()])
    performance = prior.performance * np.median(values / prior.performance[indices])
    performance[indices] = values
    return replace(prior, performance=performance)

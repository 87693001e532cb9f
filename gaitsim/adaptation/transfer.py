"""The map of an atlas as it is on another intact body, such as the physical twin."""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from gaitsim.adaptation.prior import OnProgress, Prior, atlas_members
from gaitsim.adaptation.trials import Measured
from gaitsim.errors import GaitsimError
from gaitsim.runs.snapshot import RunSnapshot

INTACT = 100  # gaits that are measured on the other body


def intact_gaits(run: RunSnapshot, *, physics: bool) -> int:
    """Return how many gaits of an atlas move on the intact body before an adaptation, at most.

    Raises:
        RunError: the run is not an atlas, or has no members.
    """
    members = len(atlas_members(run).scores)
    return members + (min(members, INTACT) if physics else 0)


def measured_intact(
    prior: Prior, measured: Measured, pool: Executor, on_progress: OnProgress = lambda done: None
) -> dict[int, float]:
    """Return what the most promising gaits measure on another intact body, by member from 1.

    Args:
        prior: the map, on its own body.
        measured: measures a gait on the other body.
        pool: of threads, in which gaits are measured.
        on_progress: called with the number of gaits that were measured since the last call.

    Raises:
        GaitsimError: none of them has a performance above 0 there.
    """
    members = most_promising(prior, INTACT)
    found: dict[int, float] = {}
    for member, value in zip(
        members, pool.map(measured, map(prior.individual, members)), strict=True
    ):
        found[member] = value
        on_progress(1)
    if not max(found.values()) > 0:
        raise GaitsimError(
            f"none of the {len(found)} best gaits of the atlas {prior.source} has a measure "
            f"{prior.measure!r} above 0 on the intact twin",
            remedy="continue the atlas, or try gaits without physics",
        )
    return found


def most_promising(prior: Prior, count: int) -> tuple[int, ...]:
    """Return the members with the best performance above 0, the best first; by number from 1."""
    order = np.argsort(-prior.performance, kind="stable")[:count]
    return tuple(int(index) + 1 for index in order if prior.performance[index] > 0)


def transferred(prior: Prior, measured: Mapping[int, float]) -> Prior:
    """Return the map as it is on another intact body, where some of its gaits were measured.

    Those have what they measured. All others are scaled by the median ratio of the measured ones.

    Args:
        prior: the map, on its own body.
        measured: performance on the other body by the number of the member, from 1; on its own
            body each of these members has a performance above 0.
    """
    tried, values = np.array([*measured]) - 1, np.array([*measured.values()])
    performance = prior.performance * np.median(values / prior.performance[tried])
    performance[tried] = values
    return replace(prior, performance=performance)

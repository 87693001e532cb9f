"""The map of an atlas as it is on another intact body, such as the physical twin."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gaitsim.adaptation.prior import Prior


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

"""The order of individuals by score."""

import numpy as np
from numpy.typing import NDArray


def best_first(scores: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the indices of scores, (population,), from best to worst; ties keep their order."""
    return np.argsort(-scores, kind="stable")

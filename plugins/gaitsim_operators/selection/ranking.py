"""Best first: the order from which most selections choose."""

import numpy as np
from numpy.typing import NDArray


def best_first(scores: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of scores (population,) from best to worst; equals keep their order."""
    return np.argsort(-scores, kind="stable")

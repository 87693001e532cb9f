"""The four motions of the body that follow from the motion of both sides (Shores 2012).

Both sides forward is forward, both backward is backward; one forward and one backward
is a rotation, away from the side that goes forward. Where a side stands still, so does
the body.
"""

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]


def forward(sides: Values) -> Values:
    """Return forward motion, by the side that moves less; negative backward, 0 in all other cases.

    Args:
        sides: motion of the left and of the right side, (population, 2), positive forward.

    Returns:
        (population,), in the unit of `sides`.
    """
    less, more = sides.min(axis=1), sides.max(axis=1)
    moved: Values = np.maximum(less, 0) + np.minimum(more, 0)  # one of the two is 0
    return moved


def clockwise(sides: Values) -> Values:
    """Return clockwise motion, left − right; negative counter-clockwise, 0 in all other cases.

    Args:
        sides: motion of the left and of the right side, (population, 2), positive forward.

    Returns:
        (population,), in the unit of `sides`: by how much the left path is longer.
    """
    left, right = sides.T
    return np.where(np.sign(left) * np.sign(right) < 0, left - right, 0)

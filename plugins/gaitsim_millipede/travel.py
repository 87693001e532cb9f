"""The four motions of the body that result from the motions of its sides (Shores 2012).

If both sides move forward or both backward, so does the body. If one side moves forward and the
other backward, the body rotates away from the side that moves forward. If a side does not move,
neither does the body.
"""

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]


def forward_motion(sides: Values) -> Values:
    """Return the forward motion, which is the motion of the slower side; negative backward.

    Args:
        sides: motion of the left and of the right side, (population, 2), positive forward.

    Returns:
        The motion, (population,), in the unit of `sides`; 0 if the sides move in opposite
        directions.
    """
    less, more = sides.min(axis=1), sides.max(axis=1)
    moved: Values = np.maximum(less, 0) + np.minimum(more, 0)  # one of the two is 0
    return moved


def clockwise_motion(sides: Values) -> Values:
    """Return the clockwise motion, left − right; negative counter-clockwise.

    Args:
        sides: motion of the left and of the right side, (population, 2), positive forward.

    Returns:
        The motion, (population,), in the unit of `sides`; 0 unless the sides move in opposite
        directions.
    """
    left, right = sides.T
    return np.where(np.sign(left) * np.sign(right) < 0, left - right, 0)

"""Draws from the standard normal distribution; compiled code.

NumPy's own draws take exponentials and logarithms from the C library, so that about one in 3,000
may differ between machines. These are the same draws from the same bits, in the order of NumPy's
generator, but for the last bit of that one in 3,000.
"""

import math
from decimal import Context, Decimal
from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.portable.compiled import exp, log

STRIPS = 256
_TAIL = 3.6541528853610088  # start of the tail, the rightmost strip
_AREA = 0.004928673233974652  # of each strip under exp(−x²/2)
_STEPS = 2.0**52  # numbers within a strip
_DECIMAL = Context(prec=30)


@cache
def strips() -> tuple[NDArray[np.float64], NDArray[np.uint64], NDArray[np.float64]]:
    """Return the strips of the ziggurat (Marsaglia and Tsang 2000, "The ziggurat method for
    generating random variables").

    Returns:
        The width of each strip divided by 2⁵², (256,); the numbers below which a draw lies wholly
        under the curve, (256,); and the height of the curve at the end of each strip, (256,).
    """
    ends, heights, limits = [0.0] * STRIPS, [1.0] * STRIPS, [0] * STRIPS
    ends[-1], heights[-1] = _TAIL, _curve(_TAIL)
    for strip in range(STRIPS - 2, 0, -1):
        height = Decimal(_AREA / ends[strip + 1] + heights[strip + 1])
        ends[strip] = math.sqrt(-2 * float(_DECIMAL.ln(height)))
        heights[strip] = _curve(ends[strip])
        if strip == 38:
            # The exponential with which NumPy's table was made was one unit too large here.
            heights[strip] = math.nextafter(heights[strip], 1)
        limits[strip + 1] = round(ends[strip] / ends[strip + 1] * _STEPS)
    limits[0] = int(_TAIL * heights[-1] / _AREA * _STEPS)
    ends[0] = _AREA / heights[-1]
    return np.array(ends) / _STEPS, np.array(limits, np.uint64), np.array(heights)


def _curve(x: float) -> float:
    """Return exp(−x²/2), correctly rounded."""
    return float(_DECIMAL.exp(Decimal(-0.5 * x * x)))


@njit(nogil=True, cache=True, error_model="numpy")
def fill(
    bits: NDArray[np.uint64],
    widths: NDArray[np.float64],
    limits: NDArray[np.uint64],
    heights: NDArray[np.float64],
    out: NDArray[np.float64],
) -> Any:
    """Fill `out`, (draws,), from random bits, (numbers,), and the strips.

    Returns:
        The count of numbers used, or −1 if there were too few.
    """
    used, drawn = 0, 0
    while drawn < len(out):
        if used + 2 > len(bits):
            return -1
        number = bits[used]
        used += 1
        strip = np.int64(number & np.uint64(0xFF))
        negative = (number >> np.uint64(8)) & np.uint64(1) == np.uint64(1)
        place = (number >> np.uint64(9)) & np.uint64(0x000FFFFFFFFFFFFF)
        x = np.float64(place) * widths[strip]
        if place >= limits[strip]:
            if strip > 0:
                share = np.float64(bits[used] >> np.uint64(11)) * 2.0**-53
                used += 1
                height = (heights[strip - 1] - heights[strip]) * share + heights[strip]
                if height >= exp(-0.5 * x * x):
                    continue
            else:
                # The tail, by Marsaglia 1964.
                while True:
                    if used + 2 > len(bits):
                        return -1
                    one = np.float64(bits[used] >> np.uint64(11)) * 2.0**-53
                    other = np.float64(bits[used + 1] >> np.uint64(11)) * 2.0**-53
                    used += 2
                    beyond, height = -log(1 - one) * (1 / _TAIL), -log(1 - other)
                    if height + height > beyond * beyond:
                        break
                x = _TAIL + beyond
                negative = (place >> np.uint64(8)) & np.uint64(1) == np.uint64(1)
        out[drawn] = -x if negative else x
        drawn += 1
    return used

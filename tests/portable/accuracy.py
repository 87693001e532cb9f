"""Print the largest error of each portable function found with random arguments.

    python accuracy.py [COUNT]

Errors are distances from mpmath's values, in units in the last place (ulp).
"""

import math
import sys

import mpmath
import numpy as np

from gaitsim import portable

BITS = 200
FUNCTIONS = {
    "exp": mpmath.exp,
    "log": mpmath.log,
    "power": mpmath.power,
    "sin": mpmath.sin,
    "cos": mpmath.cos,
    "tan": mpmath.tan,
    "tanh": mpmath.tanh,
    "arctan2": mpmath.atan2,
    "arctan": mpmath.atan,
    "arcsin": mpmath.asin,
    "arccos": mpmath.acos,
}
BOUNDS = dict.fromkeys(FUNCTIONS, 0.8) | {
    "exp": 0.7,
    "log": 0.51,
    "power": 0.7,
    "tan": 1.0,
    "arctan2": 0.7,
    "arctan": 0.7,
    "arcsin": 2.0,
    "arccos": 2.0,
}
"""Errors that the docstrings promise to stay below, ulp."""


def arguments(name, count, rng):
    """Return tuples of arguments, (count,) each, over the whole range and near hard places."""

    def sizes(low, high):
        """Return numbers of both signs with all magnitudes from 2^low to 2^high."""
        return rng.choice([-1, 1], count) * 2.0 ** rng.uniform(low, high, count)

    near_one = 1 + sizes(-52, -2)
    turns = np.round(sizes(0, 19)) * (np.pi / 2)
    angles = [(sizes(-1000, 20),), (rng.uniform(-10, 10, count),), (turns,)]
    ranges = {
        "exp": [(rng.uniform(-745, 709.7, count),), (sizes(-60, 4),)],
        "log": [(abs(sizes(-1074, 1023)),), (near_one,)],
        "power": [
            (rng.random(count), rng.uniform(0, 3, count)),
            (abs(sizes(-300, 300)), rng.uniform(-2.4, 2.4, count)),
            (near_one, sizes(0, 50)),
            (sizes(-20, 20), np.round(sizes(0, 5))),
        ],
        "tanh": [(sizes(-1000, 6),), (rng.normal(0, 1, count),)],
        "arctan2": [
            (sizes(-1074, 1023), sizes(-1074, 1023)),
            (rng.normal(0, 1, count), rng.normal(0, 1, count)),
        ],
        "arctan": [(sizes(-1074, 1023),), (rng.normal(0, 1, count),)],
    }
    inside = [(rng.uniform(-1, 1, count),), (np.clip(near_one, -1, 1),)]
    return ranges.get(name) or (inside if name.startswith("arc") else angles)


def errors(name, values):
    """Return the errors of a portable function, in ulp, (count,)."""
    found = getattr(portable, name)(*values)
    with mpmath.workprec(BITS):
        return np.array([_error(FUNCTIONS[name], *one) for one in zip(found, *values, strict=True)])


def _error(function, found, *values):
    exact = function(*(mpmath.mpf(float(value)) for value in values))
    rounded = float(exact)
    if not math.isfinite(rounded):
        return 0.0 if found == rounded else math.inf
    if abs(rounded) < sys.float_info.min:  # subnormal: at most one unit
        return 0.0 if abs(found - rounded) <= math.ulp(0.0) else math.inf
    return float(abs(mpmath.mpf(float(found)) - exact) / math.ulp(abs(rounded)))


def largest_error(name, count, rng):
    return max(float(errors(name, values).max()) for values in arguments(name, count, rng))


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    for name in FUNCTIONS:
        worst = largest_error(name, count, np.random.default_rng(0))
        print(f"{name:8} {worst:.3f} ulp", flush=True)


if __name__ == "__main__":
    main()

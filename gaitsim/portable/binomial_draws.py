"""Draws from the binomial distribution.

NumPy's draws compare with logarithms and exponentials of the C library. These use the same
algorithms and the same uniform numbers, so the results are NumPy's.
"""

import math

import numpy as np

from gaitsim.portable.scalar import exp, log

FEW = 30.0  # expected successes up to which probabilities are summed


def draw(rng: np.random.Generator, trials: int, probability: float) -> int:
    """Return the number of successes in trials."""
    rarer = min(probability, 1.0 - probability)
    if trials == 0 or probability == 0:
        return 0
    method = _by_inversion if rarer * trials <= FEW else _by_rejection
    found = method(rng, trials, rarer)
    return found if probability <= 0.5 else trials - found


def _by_inversion(rng: np.random.Generator, n: int, p: float) -> int:
    """Sum the probabilities of 0, 1, 2 … successes until they exceed a uniform number."""
    q = 1.0 - p
    none = float(exp(n * log(q)))
    bound = min(float(n), n * p + 10.0 * math.sqrt(n * p * q + 1))
    successes, chance, rest = 0, none, rng.random()
    while rest > chance:
        successes += 1
        if successes > bound:
            successes, chance, rest = 0, none, rng.random()
        else:
            rest -= chance
            chance = ((n - successes + 1) * p * chance) / (successes * q)
    return successes


def _by_rejection(rng: np.random.Generator, n: int, p: float) -> int:
    """Draw by rejection (Kachitvichyanukul and Schmeiser 1988, "Binomial random variate
    generation", algorithm BTPE), from a triangle, two parallelograms and two exponential tails.
    """
    q = 1.0 - p
    spread = n * p * q
    peak = n * p + p
    mode = math.floor(peak)
    middle = mode + 0.5
    half = math.floor(2.195 * math.sqrt(spread) - 4.6 * q) + 0.5
    left, right = middle - half, middle + half
    height = 0.134 + 20.5 / (15.3 + mode)
    slope = (peak - left) / (peak - left * p)
    left_rate = slope * (1.0 + slope / 2.0)
    slope = (right - peak) / (right * q)
    right_rate = slope * (1.0 + slope / 2.0)
    # Areas up to the end of each region.
    parallelograms = half * (1.0 + 2.0 * height)
    left_tail = parallelograms + height / left_rate
    right_tail = left_tail + height / right_rate
    while True:
        u, v = rng.random() * right_tail, rng.random()
        if u <= half:
            return math.floor(middle - half * v + u)
        if u <= parallelograms:
            x = left + (u - half) / height
            v = v * height + 1.0 - abs(mode - x + 0.5) / half
            if v > 1.0:
                continue
            y = math.floor(x)
        elif v == 0:
            continue
        elif u <= left_tail:
            y = math.floor(left + log(v) / left_rate)
            if y < 0:
                continue
            v = v * (u - parallelograms) * left_rate
        else:
            y = math.floor(right - log(v) / right_rate)
            if y > n:
                continue
            v = v * (u - left_tail) * right_rate
        if _accepted(v, y, n, p, mode):
            return y


def _accepted(v: float, y: int, n: int, p: float, mode: int) -> bool:
    """Return whether v is at most the probability of y successes, relative to the mode's."""
    q = 1.0 - p
    spread, away = n * p * q, abs(y - mode)
    if away <= 20 or away >= spread / 2.0 - 1:
        odds = p / q
        factor, ratio = odds * (n + 1), 1.0
        for k in range(mode + 1, y + 1):
            ratio *= factor / k - odds
        for k in range(y + 1, mode + 1):
            ratio /= factor / k - odds
        return v <= ratio
    # Bounds on the logarithm decide most cases.
    error = (away / spread) * ((away * (away / 3.0 + 0.625) + 0.16666666666666666) / spread + 0.5)
    about, level = -away * away / (2 * spread), log(v)
    if level < about - error:
        return True
    if level > about + error:
        return False
    at_y, at_mode, beyond_mode, beyond_y = y + 1, mode + 1, n + 1 - mode, n - y + 1
    exact = (
        (mode + 0.5) * log(at_mode / at_y)
        + (n - mode + 0.5) * log(beyond_mode / beyond_y)
        + (y - mode) * log(beyond_y * p / (at_y * q))
    )
    # Not `sum`, which differs between versions of Python.
    exact += _stirling(at_mode) + _stirling(beyond_mode) + _stirling(at_y) + _stirling(beyond_y)
    return bool(level <= exact)


def _stirling(x: int) -> float:
    """Return the rest of Stirling's series for the logarithm of a factorial."""
    square = float(x * x)
    # The series has 13,860; NumPy has 13,680, which hardly matters.
    inner = 13680.0 - (462.0 - (132.0 - (99.0 - 140.0 / square) / square) / square) / square
    return inner / x / 166320.0

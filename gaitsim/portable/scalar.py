"""Elementary functions of one number, from additions, products, quotients and roots alone.

IEEE 754 defines the result of these operations to the bit, but not that of `exp` or `sin`, which
differ between C libraries, and between processors within one library. The functions here run as
plain Python, and, once `gaitsim.portable.compiled` is imported, as part of compiled code. Neither
Python nor Numba fuses a product and a sum.

Arguments are reduced to a small interval around zero, where a Taylor polynomial is exact to less
than 0.05 units in the last place (ulp). Where a double is not enough, a number is the sum of a pair
of doubles (Dekker 1971, "A floating-point technique for extending the available precision").
"""

import math
from typing import Any

import numpy as np

MODERATE = 2.0**20
"""Largest magnitude of an argument of `sin`, `cos` and `tan`, rad; beyond, they return NaN."""

# A number plus this constant is rounded to an integer, which is then in its lowest bits.
_ROUNDER = 1.5 * 2.0**52
_ROUNDER_BITS = 0x4338000000000000
_MANTISSA, _EXPONENT_OF_ONE = 0x000FFFFFFFFFFFFF, 0x3FF0000000000000
_SPLITTER = 2.0**27 + 1

# Constants as sums; the leading parts have trailing zeros, so that small multiples are exact.
_LN2 = (0.6931471805598903, 5.497923018708371e-14)
_PER_LN2 = 1.4426950408889634  # 1 / log 2
_THIRD = (0.3333333333333333, 1.850371707708594e-17)
_FIFTH = (0.2, -1.1102230246251566e-17)
_QUARTER_TURN = (
    1.5707963267341256,
    6.077100506303966e-11,
    2.0222662487111665e-21,
    8.4784276603689e-32,
)
_EIGHTH_TURN = (0.7853981633974456, 2.6951514290790595e-15)
_TAN_SIXTEENTH_TURN = 0.41421356237309503

# Coefficients of Taylor polynomials, the highest power first.
_EXP = tuple(1 / math.factorial(n) for n in range(14, 1, -1))
_LOG = tuple(2 / (2 * n + 1) for n in range(12, 2, -1))
_SIN = tuple((-1) ** n / math.factorial(2 * n + 1) for n in range(9, 0, -1))
_COS = tuple((-1) ** n / math.factorial(2 * n) for n in range(9, 1, -1))
_ARCTAN = tuple((-1) ** n / (2 * n + 1) for n in range(21, 0, -1))


def _polynomial(x: Any, coefficients: Any) -> Any:
    """Return a polynomial (Horner's rule)."""
    total = 0.0
    for coefficient in coefficients:
        total = total * x + coefficient
    return total


def _float(bits: Any) -> Any:
    """Return the number that these 64 bits represent."""
    return np.int64(bits).view(np.float64)


def _bits(x: Any) -> Any:
    """Return the 64 bits of a number."""
    return np.float64(x).view(np.int64)


def _power_of_two(exponent: Any) -> Any:
    """Return 2ᵏ, for k from −1022 to 1023."""
    return _float((exponent + 1023) << 52)


def _sum(a: Any, b: Any) -> Any:
    """Return a + b and its rounding error (Knuth 1969, "Seminumerical algorithms")."""
    total = a + b
    other = total - a
    return total, (a - (total - other)) + (b - other)


def _product(a: Any, b: Any) -> Any:
    """Return a b and its rounding error, for factors below 2⁹⁹⁶ (Dekker 1971)."""
    total = a * b
    high = a * _SPLITTER
    a1 = high - (high - a)
    high = b * _SPLITTER
    b1 = high - (high - b)
    a2, b2 = a - a1, b - b1
    return total, ((a1 * b1 - total) + a1 * b2 + a2 * b1) + a2 * b2


def _quotient(a: Any, b: Any, c: Any, d: Any) -> Any:
    """Return (a + b) / (c + d) as a pair; b and d are small beside a and c."""
    ratio = a / c
    back, error = _product(ratio, c)
    return ratio, ((a - back) - error + b - ratio * d) / c


def _exp_reduced(x: Any, low: Any) -> Any:
    """Return k and a pair r + s with exp(x + low) = 2ᵏ (1 + r + s)."""
    rounded = x * _PER_LN2 + _ROUNDER
    turns = rounded - _ROUNDER
    high = x - turns * _LN2[0]
    tail = low - turns * _LN2[1]
    r = high + tail
    rest = (high - r) + tail
    return _bits(rounded) - _ROUNDER_BITS, r, r * r * _polynomial(r, _EXP) + (rest + rest * r)


def _exp_pair(x: Any, low: Any) -> Any:
    """Return exp(x + low)."""
    # Beyond these numbers the result is 0 or infinite; NaN is neither.
    x = -746.0 if x < -746.0 else x
    x = 710.0 if x > 710.0 else x
    exponent, r, s = _exp_reduced(x, low)
    half = exponent >> 1
    one = 1.0 + r
    found = one + ((r - (one - 1.0)) + s)
    return found * _power_of_two(half) * _power_of_two(exponent - half)


def exp(x: Any) -> Any:
    """Return the exponential."""
    return _exp_pair(x, 0.0)


def _log_pair(x: Any) -> Any:
    """Return the natural logarithm of a positive, finite number as a pair."""
    tiny = x < 2.0**-1022
    bits = _bits(x * (2.0**54 if tiny else 1.0))
    m = _float((bits & _MANTISSA) | _EXPONENT_OF_ONE)
    large = m > 1.4142135623730951
    m = 0.5 * m if large else m
    exponent = (bits >> 52) - 1023 + (1 if large else 0) - (54 if tiny else 0)
    turns = _float(exponent + _ROUNDER_BITS) - _ROUNDER
    # log m = 2 artanh s = 2 s (1 + s²/3 + s⁴/5 + …) of s = (m − 1) / (m + 1)
    below, error = _sum(m, 1.0)
    s, s_low = _quotient(m - 1.0, 0.0, below, error)
    z, z_low = _product(s, s)
    z_low += 2 * s * s_low
    p, p_low = _sum(_FIFTH[0], 0.5 * z * _polynomial(z, _LOG))
    p_low += _FIFTH[1]
    q, q_low = _product(z, p)
    q_low += z * p_low + z_low * p
    p, p_low = _sum(_THIRD[0], q)
    p_low += q_low + _THIRD[1]
    q, q_low = _product(z, p)
    q_low += z * p_low + z_low * p
    p, p_low = _product(s, q)
    p_low += s * q_low + s_low * q
    high, low = _sum(turns * _LN2[0], 2 * s)
    other, rest = _sum(turns * _LN2[1], 2 * p)
    high, more = _sum(high, other)
    low = low + more + (rest + 2 * (s_low + p_low))
    return _sum(high, low)


def log(x: Any) -> Any:
    """Return the natural logarithm."""
    usual = (x > 0) & (x < math.inf)
    high, _ = _log_pair(x if usual else 1.0)
    special = -math.inf if x == 0 else (x if x > 0 else math.nan)
    return high if usual else special


def power(x: Any, y: Any) -> Any:
    """Return xʸ."""
    size = abs(x)
    usual = (size > 0) & (size < math.inf)
    high, low = _log_pair(size if usual else 1.0)
    # Beyond 2⁶⁵, every power of a number but 1 is 0 or infinite.
    limit = 2.0**65
    top = limit if y > limit else (-limit if y < -limit else y)
    exponent, error = _product(top, high)
    found = _exp_pair(exponent, error + top * low if abs(exponent) < 800 else 0.0)
    growing = (size > 1) == (y > 0)
    found = found if usual else (math.inf if growing else 0.0)
    # NumPy's floor is compiled to an instruction; `x // 1` is not.
    even = np.floor(y * 0.5) * 2 == y
    whole = np.floor(y) == y
    negative = np.copysign(1.0, x) < 0
    found = -found if negative & whole & (not even) else found
    found = math.nan if (x < 0) & (not whole) & usual else found
    found = math.nan if np.isnan(x) | np.isnan(y) else found
    found = 1.0 if (size == 1) & (abs(y) == math.inf) else found
    return 1.0 if (x == 1) | (y == 0) else found


def tanh(x: Any) -> Any:
    """Return the hyperbolic tangent."""
    size = abs(x)
    size = 20.0 if size > 20.0 else size  # tanh 20 is 1 to less than half an ulp
    # tanh x = e / (e + 2), where e = exp(2x) − 1
    exponent, r, s = _exp_reduced(2 * size, 0.0)
    scale = _power_of_two(exponent)
    a, b = _sum(scale - 1.0, scale * r)
    a, b = _sum(a, b + scale * s)
    c, d = _sum(2.0, a)
    high, low = _quotient(a, b, c, d + b)
    found = np.copysign(high + low, x)
    return x if (x == 0) | np.isnan(x) else found


def quarter_turns(x: Any) -> Any:
    """Return k, r and s with x = k π/2 + r + s and |r| ≤ π/4, for |x| up to `MODERATE`.

    Subtracts k times π/2 in four parts (Cody and Waite 1980, "Software manual for the elementary
    functions"); the first three products are exact.
    """
    rounded = x * (2 / math.pi) + _ROUNDER
    turns = rounded - _ROUNDER
    a, b = _sum(x - turns * _QUARTER_TURN[0], -turns * _QUARTER_TURN[1])
    r, s = _sum(a, -turns * _QUARTER_TURN[2])
    r, s = _sum(r, (b + s) - turns * _QUARTER_TURN[3])
    return _bits(rounded) & 3, r, s


def _sin_pair(r: Any, s: Any) -> Any:
    """Return sin(r + s) as a pair, for |r| ≤ π/4."""
    z = r * r
    return r, r * z * _polynomial(z, _SIN) + s * (1 - 0.5 * z)


def _cos_pair(r: Any, s: Any) -> Any:
    """Return cos(r + s) as a pair, for |r| ≤ π/4."""
    z, error = _product(r, r)
    high = 1 - 0.5 * z
    return high, ((1 - high) - 0.5 * z) + (z * z * _polynomial(z, _COS) - (r * s + 0.5 * error))


def sin_of(quarter: Any, r: Any, s: Any) -> Any:
    """Return sin(k π/2 + r + s)."""
    a, b = _sin_pair(r, s)
    c, d = _cos_pair(r, s)
    found = c + d if quarter & 1 else a + b
    return -found if quarter & 2 else found


def tan_of(quarter: Any, r: Any, s: Any) -> Any:
    """Return tan(k π/2 + r + s)."""
    a, b = _sum(*_sin_pair(r, s))
    c, d = _sum(*_cos_pair(r, s))
    odd = quarter & 1
    high, low = _quotient(-c if odd else a, -d if odd else b, a if odd else c, b if odd else d)
    return high + low


def sin(x: Any) -> Any:
    """Return the sine, for |x| up to `MODERATE`."""
    usual = abs(x) <= MODERATE
    quarter, r, s = quarter_turns(x if usual else 0.0)
    found = sin_of(quarter, r, s)
    return (x if x == 0 else found) if usual else math.nan


def cos(x: Any) -> Any:
    """Return the cosine, for |x| up to `MODERATE`."""
    usual = abs(x) <= MODERATE
    quarter, r, s = quarter_turns(x if usual else 0.0)
    found = sin_of(quarter + 1, r, s)
    return found if usual else math.nan


def sin_and_cos(x: Any) -> Any:
    """Return the sine and the cosine, for |x| up to `MODERATE`; compiled, they share most work."""
    usual = abs(x) <= MODERATE
    quarter, r, s = quarter_turns(x if usual else 0.0)
    sine, cosine = sin_of(quarter, r, s), sin_of(quarter + 1, r, s)
    sine = x if x == 0 else sine
    return (sine, cosine) if usual else (math.nan, math.nan)


def tan(x: Any) -> Any:
    """Return the tangent, for |x| up to `MODERATE`."""
    usual = abs(x) <= MODERATE
    quarter, r, s = quarter_turns(x if usual else 0.0)
    found = tan_of(quarter, r, s)
    return (x if x == 0 else found) if usual else math.nan


def arctan2(y: Any, x: Any) -> Any:
    """Return the angle of the point (x, y)."""
    a, b = abs(y), abs(x)
    steep = a > b
    long = a if steep else b
    short = b if steep else a
    infinite = long == math.inf
    short = (1.0 if short == math.inf else 0.0) if infinite else short
    long = 1.0 if infinite else long
    # Scaled so that rounding errors are neither subnormal nor infinite.
    scale = 2.0**-60 if long > 2.0**960 else (2.0**150 if long < 2.0**800 else 1.0)
    long, short = long * scale, short * scale
    # arctan q = π/4 + arctan((q − 1) / (q + 1))
    wide = short > _TAN_SIXTEENTH_TURN * long
    above, above_low = _sum(short, -long)
    below, below_low = _sum(short, long)
    above = above if wide else short
    above_low = above_low if wide else 0.0
    below = below if wide else long
    below_low = below_low if wide else 0.0
    empty = below == 0
    q, q_low = _quotient(above, above_low, 1.0 if empty else below, below_low)
    z = q * q
    q_low = (q_low if abs(q) > 2.0**-960 else 0.0) * (1 - z) + q * z * _polynomial(z, _ARCTAN)
    # Multiples of π/4 that the angle is counted from, and its direction.
    eighths = 1.0 if wide else 0.0
    sign = -1.0 if steep else 1.0
    eighths = 2.0 - eighths if steep else eighths
    left = np.copysign(1.0, x) < 0
    eighths = 4.0 - eighths if left else eighths
    sign = -sign if left else sign
    high, low = _sum(eighths * _EIGHTH_TURN[0], sign * q)
    found = high + (low + (eighths * _EIGHTH_TURN[1] + sign * q_low))
    return math.nan if np.isnan(x) | np.isnan(y) else np.copysign(found, y)


def arctan(x: Any) -> Any:
    """Return the arc tangent."""
    return arctan2(x, 1.0)


def arcsin(x: Any) -> Any:
    """Return the arc sine; NaN for |x| > 1."""
    inside = (1 - x) * (1 + x)
    return arctan2(x, np.sqrt(inside)) if inside >= 0 else math.nan


def arccos(x: Any) -> Any:
    """Return the arc cosine; NaN for |x| > 1."""
    inside = (1 - x) * (1 + x)
    return arctan2(np.sqrt(inside), x) if inside >= 0 else math.nan

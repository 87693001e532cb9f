"""Compression of arrays and JSON to short strings, which pages unpack."""

import base64
import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.plugin import GaitsimError

Packed = dict[str, Any]
"""A packed array as JSON: shape, step and data."""

MAX_STEPS = 2**31 - 1
"""Largest number of steps."""

_DIGITS = 7  # decimal places of numbers in packed JSON: 0.1 µm


def pack(values: ArrayLike, step: float) -> Packed:
    """Round numbers to multiples of a step, and compress them.

    The integers round(value / step) are replaced by their differences along the first axis, modulo
    2³², which are small as motion is smooth. Their four bytes are grouped in planes, lowest byte
    first, as the higher bytes are mostly equal. Raw deflate and base64 follow. The same numbers
    always give the same string.

    Args:
        values: numbers or truth values, (…).
        step: distance of representable numbers, in their unit; 1 for truth values.

    Returns:
        `{"shape": […], "step": step, "data": "…"}`, with rounding errors of at most step / 2.
    """
    array = np.asarray(values, dtype=np.float64)
    whole = np.rint(array / step)
    if not (np.abs(whole) <= MAX_STEPS).all():  # NaN is rejected as well
        raise GaitsimError(
            f"numbers of a motion cannot be stored in steps of {step:g}",
            allowed=f"finite numbers up to {MAX_STEPS * step:.3g}",
        )
    numbers = whole.astype(np.int32)
    differences = numbers.copy()
    with np.errstate(over="ignore"):
        differences[1:] -= numbers[:-1]
    planes = differences.astype("<i4").reshape(-1, 1).view(np.uint8).T
    return {"shape": list(array.shape), "step": step, "data": deflated(planes.tobytes())}


def unpack(found: Packed) -> NDArray[np.float64]:
    """Return the numbers in a packed array, as pages decode them."""
    shape = tuple(found["shape"])
    data = zlib.decompress(base64.b64decode(found["data"]), -15)
    planes = np.frombuffer(data, dtype=np.uint8).reshape(4, -1)
    differences = np.ascontiguousarray(planes.T).view("<i4").reshape(shape)
    numbers = np.cumsum(differences, axis=0, dtype=np.int32) if shape else differences
    return np.asarray(numbers * float(found["step"]))


def pack_json(value: Any) -> str:
    """Return JSON as a compressed string, with its numbers rounded to 7 decimal places.

    Values with equal parts, such as bodies that differ in a few lengths, take little room.
    """
    text = json.dumps(value, allow_nan=False)
    rounded = json.loads(text, parse_float=lambda number: round(float(number), _DIGITS))
    return deflated(json.dumps(rounded, separators=(",", ":")).encode())


def deflated(data: bytes) -> str:
    """Return bytes as raw deflate data in base64."""
    deflate = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS)
    return base64.b64encode(deflate.compress(data) + deflate.flush()).decode()

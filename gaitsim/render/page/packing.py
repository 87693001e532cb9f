"""Arrays as short texts, which a page unpacks."""

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.errors import GaitsimError

Packed = dict[str, Any]
"""shape, step and data, as JSON holds them."""

LARGEST = 2**31 - 1
"""The largest number of steps."""


def packed(values: ArrayLike, step: float) -> Packed:
    """Round numbers to multiples of a step, and compress them.

    Whole numbers round(value / step) are replaced by their differences along the first axis, modulo
    2³², as motion is smooth; the four bytes of all of them are put in planes, the lowest first, as
    the higher ones are mostly equal; raw deflate and base64 follow. It is a function of the
    numbers: the same text each time.

    Args:
        values: numbers or truth values, (…).
        step: the distance of representable numbers, in their unit; 1 for truth values.

    Returns:
        `{"shape": […], "step": step, "data": "…"}`; the numbers in it differ by at most step / 2.

    Raises:
        GaitsimError: a number is not finite, or is too large for the step.
    """
    array = np.asarray(values, dtype=np.float64)
    whole = np.rint(array / step)
    if not (np.abs(whole) <= LARGEST).all():  # False for what is not a number, too
        raise GaitsimError(
            f"numbers of a motion cannot be stored in steps of {step:g}",
            allowed=f"finite numbers up to {LARGEST * step:.3g}",
        )
    numbers = whole.astype(np.int32)
    differences = numbers.copy()
    with np.errstate(over="ignore"):
        differences[1:] -= numbers[:-1]
    planes = differences.astype("<i4").reshape(-1, 1).view(np.uint8).T
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = deflate.compress(planes.tobytes()) + deflate.flush()
    return {"shape": list(array.shape), "step": step, "data": base64.b64encode(data).decode()}


def unpacked(found: Packed) -> NDArray[np.float64]:
    """Return the numbers of `packed`, as a page reads them."""
    shape = tuple(found["shape"])
    data = zlib.decompress(base64.b64decode(found["data"]), -15)
    planes = np.frombuffer(data, dtype=np.uint8).reshape(4, -1)
    differences = np.ascontiguousarray(planes.T).view("<i4").reshape(shape)
    numbers = np.cumsum(differences, axis=0, dtype=np.int32) if shape else differences
    return np.asarray(numbers * float(found["step"]))

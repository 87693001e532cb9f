"""Types of values read from a file: exact builtins, printable names, bounded arrays.

pydantic validates dataclasses with these types. Numbers must have exactly their type, so that
`True` is not a whole number.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    PlainValidator,
    StrictBytes,
    StrictInt,
    StrictStr,
    TypeAdapter,
    ValidationError,
)

from gaitsim.contracts import Array
from gaitsim.experiment.model import MOST_GENERATIONS
from gaitsim.toml import LARGEST

EXACT_KEYS = ConfigDict(extra="forbid")


def printable(name: str) -> str:
    """Return a text of a file, after checking that it can be printed."""
    if not name.isprintable():
        raise ValueError("a name should have only printable characters")
    return name


def _real(allowed: str, accepts: Callable[[float], bool]) -> PlainValidator:
    def check(value: Any) -> float:
        if type(value) is not float or not accepts(value):
            raise ValueError(f"should be {allowed}")
        return value

    return PlainValidator(check)


Name = Annotated[StrictStr, Field(min_length=1, max_length=200), AfterValidator(printable)]
Names = dict[Name, Name]
Toml = Annotated[StrictStr, Field(max_length=LARGEST)]
Count = Annotated[StrictInt, Field(ge=0)]
Number = Annotated[StrictInt, Field(ge=1, le=MOST_GENERATIONS)]
Finite = Annotated[float, _real("a finite number", math.isfinite)]
BelowInfinity = Annotated[
    float, _real("a finite number or −inf", lambda value: value < math.inf)  # nor NaN
]


@dataclass(frozen=True)
class _StoredArray:
    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    dtype: StrictStr
    shape: tuple[Annotated[StrictInt, Field(ge=0, le=2**40)], ...]
    bytes: StrictBytes


_STORED_ARRAY = TypeAdapter(_StoredArray)


def array(
    shape: tuple[str, ...] | None,
    dtypes: tuple[str, ...],
    allowed: str,
    accepts: Callable[[Array], Array],
) -> PlainValidator:
    """Return a validator that reads an array stored by `plain_array`.

    The array is in native byte order. It is writable, because Numba would compile kernels a second
    time for read-only arrays.

    Args:
        shape: names of the axes, which must not be empty; None allows any shape.
        dtypes: NumPy names of the allowed dtypes, never object dtypes.
        allowed: description of valid elements, for messages.
        accepts: function that checks every element.
    """
    axes = "of any shape" if shape is None else f"({', '.join(shape)})"

    def read(value: Any) -> Array:
        stored = _STORED_ARRAY.validate_python(value)
        if stored.dtype not in dtypes:
            raise ValueError(f"its dtype should be {' or '.join(dtypes)}")
        dtype = np.dtype(stored.dtype)
        if shape is not None and (len(stored.shape) != len(shape) or 0 in stored.shape):
            raise ValueError(f"its shape should be {axes}")
        if dtype.itemsize * math.prod(stored.shape) != len(stored.bytes):
            raise ValueError("its shape and dtype should fit the number of bytes")
        flat = np.frombuffer(stored.bytes, dtype).astype(dtype.newbyteorder("="))
        if not accepts(flat).all():
            raise ValueError(f"each element should be {allowed}")
        return flat.reshape(stored.shape)

    return PlainValidator(read)


def plain_array(values: Array) -> dict[str, object]:
    """Return an array as builtins, which `array` reads."""
    little = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return {"dtype": little.dtype.str, "shape": list(values.shape), "bytes": little.tobytes()}


def first_problem(error: ValidationError, root: str) -> tuple[str, str]:
    """Return the key of the first invalid value, below `root` and safe to print, and the reason."""
    first = error.errors(include_url=False, include_input=False)[0]
    parts = [root, *map(str, first["loc"])]
    key = ".".join(part if part.isprintable() else ascii(part) for part in parts)
    return key[:200], first["msg"].removeprefix("Value error, ")

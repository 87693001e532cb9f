"""Rules for builtins that were read from a file: exact types, exact keys, bounded arrays.

A rule takes a value and its key, and returns what the value means. Rules are put
together like the data that they describe:

    record(Stage, {"generation": count, "experiment": text})
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from gaitsim.contracts import Array

Rule = Callable[[Any, str], Any]
_T = TypeVar("_T")


class MismatchError(Exception):
    """A value breaks its rule: where it stands, and what is allowed there."""

    def __init__(self, key: str, allowed: str) -> None:
        self.key = key
        self.allowed = allowed
        super().__init__(f"{key} should be {allowed}")


def exactly(kind: type[_T], allowed: str, accepts: Callable[[_T], object]) -> Rule:
    """A value of the type itself, so that True is no whole number, and that `accepts` likes."""

    def rule(value: Any, key: str) -> Any:
        if type(value) is not kind or not accepts(value):
            raise MismatchError(key, allowed)
        return value

    return rule


def _is_name(value: str) -> bool:
    return 0 < len(value) <= 200 and value.isprintable()


text = exactly(str, "a text", lambda _: True)
name = exactly(str, "printable, of 1 to 200 characters", _is_name)
count = exactly(int, "a whole number, 0 or more", lambda value: value >= 0)
finite = exactly(float, "a finite number", math.isfinite)
below_infinity = exactly(float, "a finite number or −inf", lambda value: value < math.inf)

_list = exactly(list, "a list", lambda _: True)
_dict = exactly(dict, "a dict", lambda _: True)


def optional(inner: Rule) -> Rule:
    """None, or what `inner` describes."""
    return lambda value, key: None if value is None else inner(value, key)


def each(inner: Rule) -> Rule:
    """A tuple, out of a list whose every item `inner` describes."""

    def rule(value: Any, key: str) -> Any:
        return tuple(inner(item, f"{key}[{at}]") for at, item in enumerate(_list(value, key)))

    return rule


def named(inner: Rule) -> Rule:
    """A dict by names fit to print, whose every value `inner` describes."""

    def rule(value: Any, key: str) -> Any:
        items = _dict(value, key).items()
        return {name(k, f"a key of {key}"): inner(item, f"{key}.{k}") for k, item in items}

    return rule


def record(make: Callable[..., Any], rules: dict[str, Rule]) -> Rule:
    """What `make` makes of a dict with exactly the keys of `rules`."""
    fitting = exactly(
        dict,
        f"a dict with exactly the keys {', '.join(rules)}",
        lambda value: value.keys() == rules.keys(),
    )

    def rule(value: Any, key: str) -> Any:
        fitting(value, key)
        return make(**{k: inner(value[k], f"{key}.{k}") for k, inner in rules.items()})

    return rule


def array(
    shape: tuple[str, ...], dtypes: tuple[str, ...], allowed: str, accepts: Callable[[Array], Array]
) -> Rule:
    """An array whose every element `accepts` likes: a writable copy, in the machine's byte order.

    Writable, because compiled code would be compiled once more for arrays that are not.

    Args:
        shape: what each axis is, for people.
        dtypes: NumPy's names of the dtypes allowed; never one that holds objects.
        allowed: what the elements have to be, for people.
        accepts: says it of every element.
    """
    axes = f"({', '.join(shape)})"
    parts = record(
        dict,
        {
            "dtype": exactly(str, f"one of {', '.join(dtypes)}", lambda value: value in dtypes),
            "shape": each(exactly(int, "a length from 1 to 2^40", lambda n: 0 < n <= 2**40)),
            "bytes": exactly(bytes, "bytes", lambda _: True),
        },
    )

    def rule(value: Any, key: str) -> Any:
        raw = parts(value, key)
        dtype = np.dtype(raw["dtype"])
        if len(raw["shape"]) != len(shape):
            raise MismatchError(f"{key}.shape", f"that of {axes}")
        if dtype.itemsize * math.prod(raw["shape"]) != len(raw["bytes"]):
            raise MismatchError(f"{key}.bytes", "as many as shape and dtype say")
        flat = np.frombuffer(raw["bytes"], dtype).astype(dtype.newbyteorder("="))
        if not accepts(flat).all():
            raise MismatchError(key, f"{axes}, each element {allowed}")
        return flat.reshape(raw["shape"])

    return rule


def plain_array(values: Array) -> dict[str, object]:
    """`values` as the builtins that `array` reads."""
    little = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return {"dtype": little.dtype.str, "shape": list(values.shape), "bytes": little.tobytes()}

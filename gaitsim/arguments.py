"""Arguments shared by the functions of the Python API: checks, and conversion to options."""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from gaitsim.errors import GaitsimError

ARGUMENTS = "arguments"  # source of the options, for messages


def check_workers(workers: Any) -> None:
    """Check a number of workers."""
    whole = isinstance(workers, int | np.integer) and not isinstance(workers, bool)
    if workers is not None and not (whole and workers >= 1):
        raise GaitsimError(
            f"invalid number of workers: {workers!r}",
            where="workers",
            allowed="a whole number, 1 or more, or None for the body's default",
        )


def warn(text: str) -> None:
    warnings.warn(text, stacklevel=2)


def as_overrides(set: Any, short: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of `set` and the options of `short` that are not None, by key.

    An option in `set` overrides the same option in `short`.
    """
    if not isinstance(set, Mapping | None):
        raise GaitsimError(
            f"{set!r} is not a mapping of options",
            where="set",
            allowed='a mapping, such as {"mutation.rate": 0.1}',
        )
    return {key: value for key, value in short.items() if value is not None} | dict(set or {})

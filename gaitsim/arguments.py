"""Arguments that the functions of `gaitsim` in Python share: checked, and as options."""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from gaitsim.errors import GaitsimError

ARGUMENTS = "arguments"  # where options come from, for messages


def check_workers(workers: Any) -> None:
    """Refuse an invalid number of workers."""
    whole = isinstance(workers, int | np.integer) and not isinstance(workers, bool)
    if workers is not None and not (whole and workers >= 1):
        raise GaitsimError(
            f"{workers!r} is not a number of workers",
            where="workers",
            allowed="a whole number, 1 or more; None for what suits the body",
        )


def warn(text: str) -> None:
    warnings.warn(text, stacklevel=2)


def as_overrides(set: Any, short: Mapping[str, Any]) -> dict[str, Any]:
    """Return options by key, without those of `short` that are None.

    Raises:
        GaitsimError: `set` is not a mapping.
    """
    if not isinstance(set, Mapping | None):
        raise GaitsimError(
            f"{set!r} is not a mapping of options",
            where="set",
            allowed='a mapping, such as {"mutation.rate": 0.1}',
        )
    return {key: value for key, value in short.items() if value is not None} | dict(set or {})

"""Conditions that vary between the worlds that a body moves in, such as friction."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gaitsim.errors import GaitsimError, unknown

WORLD_HELP = (
    "conditions of the body's world by name, such as friction = 0.4; the others are nominal. The "
    "key seed, a whole number, determines everything random in the world"
)
SEED = "seed"
"""Key of the seed of a world's random choices, such as the sign of a joint's error."""


@dataclass(frozen=True)
class Condition:
    """A quantity that varies between worlds.

    Attributes:
        unit: unit as printed, '' for a pure number.
        nominal: value in a world that does not name the condition.
        low: lower end of the usual range.
        high: upper end of the usual range.
        least: smallest value that the body supports.
        most: largest value that the body supports.
        help: description of the condition, one phrase.
    """

    unit: str
    nominal: float
    low: float
    high: float
    least: float
    most: float
    help: str

    def table_cells(self) -> tuple[str, str, str, str]:
        """Return the nominal value, usual range, unit and description as strings for a table."""
        return f"{self.nominal:g}", f"{self.low:g} to {self.high:g}", self.unit, self.help

    def __str__(self) -> str:
        span = f"{self.low:g} to {self.high:g} {self.unit}".rstrip()
        return f"{self.help}; nominal {self.nominal:g}, usually {span}"


def check_world(world: Mapping[str, float], conditions: Mapping[str, Condition]) -> None:
    """Validate the option `world` of a body.

    Args:
        world: values by name of the condition, and optionally a `seed`.
        conditions: conditions of the body by name.

    Raises:
        GaitsimError: a name is unknown, a value is outside the range that the body supports, or
            the seed is invalid.
    """
    for name, value in world.items():
        if name == SEED:
            if not (value == math.floor(value) and 0 <= value < 2**53):
                raise GaitsimError(
                    f"invalid seed of a world: {value:g}",
                    key="world",
                    allowed="a whole number from 0 to 2^53 − 1",
                )
            continue
        if name not in conditions:
            raise unknown("condition", name, [*conditions, SEED], key="world")
        condition = conditions[name]
        if not condition.least <= value <= condition.most:
            raise GaitsimError(
                f"invalid value of the condition {name!r}: {value:g}",
                key="world",
                allowed=f"{condition.least:g} to {condition.most:g} {condition.unit}".rstrip(),
            )

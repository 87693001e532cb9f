"""Conditions of a world: what may vary between the worlds that a body moves in."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gaitsim.errors import GaitsimError, unknown

WORLD_HELP = (
    "conditions of the world that the body is in, by name, such as friction = 0.4; others are "
    "nominal. The whole number seed chooses what is drawn at random in it"
)
SEED = "seed"
"""The key of a world that seeds what its conditions leave to chance, such as which way each joint
is off."""


@dataclass(frozen=True)
class Condition:
    """What may vary between worlds.

    Attributes:
        unit: as printed, '' for a pure number.
        nominal: its value in a world that does not name it.
        low: lower end of the range that worlds usually have.
        high: upper end.
        least: smallest value that the body can be in.
        most: largest value.
        help: what it is, one phrase.
    """

    unit: str
    nominal: float
    low: float
    high: float
    least: float
    most: float
    help: str

    def texts(self) -> tuple[str, str, str, str]:
        """Return nominal value, usual range, unit and meaning, as tables show them."""
        return f"{self.nominal:g}", f"{self.low:g} to {self.high:g}", self.unit, self.help

    def __str__(self) -> str:
        span = f"{self.low:g} to {self.high:g} {self.unit}".rstrip()
        return f"{self.help}; nominal {self.nominal:g}, usually {span}"


def check_world(world: Mapping[str, float], conditions: Mapping[str, Condition]) -> None:
    """Check the option `world` of a body.

    Args:
        world: values by the names of conditions, and perhaps `seed`.
        conditions: of the body.

    Raises:
        GaitsimError: a name is unknown, or a value is beyond what the body can be in.
    """
    for name, value in world.items():
        if name == SEED:
            if not (value == math.floor(value) and 0 <= value < 2**53):
                raise GaitsimError(
                    f"the seed {value:g} of a world is not a whole number",
                    key="world",
                    allowed="a whole number from 0 to 2^53 − 1",
                )
            continue
        if name not in conditions:
            raise unknown("condition", name, [*conditions, SEED], key="world")
        condition = conditions[name]
        if not condition.least <= value <= condition.most:
            raise GaitsimError(
                f"the condition {name} is {value:g}",
                key="world",
                allowed=f"{condition.least:g} to {condition.most:g} {condition.unit}".rstrip(),
            )

"""Options of the transferability model: what stands for reality, and how often it is tested."""

from typing import Any

from pydantic import BaseModel, ConfigDict

from gaitsim.contracts import Organism, option
from gaitsim.registry import options

TRANSFERABILITY = "transferability"
"""The section of an experiment, and the name by which a search reads the prediction."""

FEATURES = ("forward", "yaw", "body height", "slip ratio", "duty factor", "stride frequency")
"""The features by default, of which a body may lack some."""


class Transferability(BaseModel):
    """What stands for reality, and how its difference from the simulation is learnt. Options."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    reality: dict[str, Any] = option(
        {},
        "options of the body that stand for reality, such as world = {friction = 0.3}; none tests "
        "nothing",
    )
    every: int = option(
        5, "generations from one test to the next, each of one individual in reality", ge=1
    )
    features: tuple[str, ...] = option(
        (),
        "measures of the simulated motion by which the model tells individuals apart; none takes "
        f"those of {', '.join(FEATURES[:-1])} and {FEATURES[-1]} that the body has",
    )

    def resolved(self, reality: Organism | None) -> "Transferability":
        """Return the options with those of the body in reality as that body has read them."""
        if reality is None:
            return self
        found = options.values(reality)
        told = {name: found[name] for name in self.reality if name in found}
        return self.model_copy(update={"reality": told})


NO_REALITY = Transferability()

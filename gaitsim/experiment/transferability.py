"""Options of the transferability model: the body in reality, and the frequency of tests."""

from typing import Any

from pydantic import BaseModel, ConfigDict

from gaitsim.contracts import Organism, option
from gaitsim.registry import options

TRANSFERABILITY = "transferability"
"""The section of an experiment, and the name of the prediction that a search reads."""

FEATURES = ("forward", "yaw", "body height", "slip ratio", "duty factor", "stride frequency")
"""The default features; a body may lack some of them."""


class Transferability(BaseModel):
    """Options for reality, and for learning how it differs from the simulation; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    reality: dict[str, Any] = option(
        {},
        "options of the body that represents reality, such as world = {friction = 0.3}; {} turns "
        "off tests in reality",
    )
    every: int = option(5, "generations between tests in reality, each of one individual", ge=1)
    features: tuple[str, ...] = option(
        (),
        "measures of the simulated motion from which the model predicts; [] uses those of "
        f"{', '.join(FEATURES[:-1])} and {FEATURES[-1]} that the body has",
    )

    def resolved(self, reality: Organism | None) -> "Transferability":
        """Return the options with `reality` as validated by the body."""
        if reality is None:
            return self
        validated = options.values(reality)
        values = {name: validated[name] for name in self.reality if name in validated}
        return self.model_copy(update={"reality": values})


NO_REALITY = Transferability()

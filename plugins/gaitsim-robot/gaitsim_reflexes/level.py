"""The reflex that keeps the trunk level."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Floats, Inputs, Legs, Observation, Reflex, option
from gaitsim_reflexes.shared import of_legs


class Level(Reflex):
    """Keeps the trunk level: legs below a tilted trunk's low side get longer, the others shorter.

    The vestibulospinal reflex of Fukuoka, Kimura and Cohen 2003, by lengths instead of angles. The
    change follows the height of each hip above that of a level trunk, for small angles, its
    integral, and its speed. On a slope, the trunk stays level as far as the legs reach. The strokes
    of a level trunk do not follow a slope uphill or downhill, so by default, half of the pitch
    counts, and without an integral, which would level it completely.
    """

    pitch: float = option(0.5, "share of the pitch that it levels", ge=0, le=1)
    gain: float = option(0.3, "change of a leg's length per height of its hip", ge=0, le=5)
    integral_gain: float = option(
        0.0, "change of a leg's length per height of its hip and second", unit="1/s", ge=0, le=20
    )
    damping: float = option(
        0.02, "change of a leg's length per vertical speed of its hip", unit="s", ge=0, le=1
    )
    limit: float = option(0.15, "largest change, as a share of the legs' length", ge=0, le=0.5)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("orientation", "rates")

    def start(self, legs: Legs, weights: Floats) -> dict[str, Floats]:
        """Return the integral, each leg's place, and the legs' length, in m."""
        shape = len(weights), len(legs.names)
        return {
            "integral": np.zeros(shape),
            "ahead": np.broadcast_to(legs.feet[..., 0], shape).copy(),
            "left": np.broadcast_to(legs.feet[..., 1], shape).copy(),
            "length": np.full(len(weights), legs.length),
        }

    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Change the lengths of the legs."""
        ahead, left = of_legs(self.pitch) * state["ahead"], state["left"]
        limit = (self.limit * state["length"])[:, None]
        roll, pitch = seen.orientation[:, 0, None], seen.orientation[:, 1, None]
        height = left * roll - ahead * pitch
        speed = left * seen.rates[:, 0, None] - ahead * seen.rates[:, 1, None]
        integral = state["integral"] - of_legs(self.integral_gain) * height * interval
        state["integral"][:] = np.clip(integral, -limit, limit)
        change = state["integral"] - of_legs(self.gain) * height - of_legs(self.damping) * speed
        inputs.reach += np.clip(change, -limit, limit)

    def c99(self) -> str:
        """Return `step` in C99."""
        return """\
const double limit = o->limit * s->length;
for (int leg = 0; leg < GAIT_LEGS; leg++) {
    const double ahead = o->pitch * s->ahead[leg], left = s->left[leg];
    const double height = left * seen->orientation[0] - ahead * seen->orientation[1];
    const double speed = left * seen->rates[0] - ahead * seen->rates[1];
    const double integral = s->integral[leg] - o->integral_gain * height * interval;
    s->integral[leg] = gait_clip(integral, -limit, limit);
    const double change = s->integral[leg] - o->gain * height - o->damping * speed;
    inputs->reach[leg] += gait_clip(change, -limit, limit);
}
"""

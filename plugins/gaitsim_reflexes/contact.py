"""The reflex that adapts the legs to the height of the ground."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import Inputs, Legs, Observation, Reflex, option
from gaitsim.contracts.reflex import Floats
from gaitsim_reflexes.shared import WALKING, of_legs, walking


class Contact(Reflex):
    """Adapts each leg to the ground where its foot lands, by foot contacts.

    A foot that finds no ground in the first half of stance is extended until it does. A foot that
    lands in the second half of swing is retracted instead of lowered further, and its swing ends
    sooner. The leg keeps the change in stance, and loses it in swing. The reflexes follow those for
    late and early landings of Kimura, Fukuoka and Cohen 2007.
    """

    speed: float = option(
        1.0, "speed of extension and retraction, in legs' lengths", unit="1/s", ge=0, le=10
    )
    limit: float = option(0.1, "largest change, as a share of the legs' length", ge=0, le=0.5)
    hurry: float = option(2.0, "factor of the speed of a swing whose foot has landed", ge=1, le=5)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("contacts",)

    def start(self, legs: Legs, weights: Floats) -> dict[str, Floats]:
        """Return the extension of each leg, (population, legs), and the legs' length, in m."""
        return {
            "extension": np.zeros((len(weights), len(legs.names))),
            "length": np.full(len(weights), legs.length),
        }

    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Extend or retract the legs, and shorten swings."""
        extension = state["extension"]
        limit = (self.limit * state["length"])[:, None]
        most = (self.speed * interval * state["length"])[:, None]
        walks, touches = walking(seen)[:, None], seen.contacts > 0.5
        late = walks & ~touches & (seen.phase < seen.duty / 2)
        early = walks & touches & (seen.phase > (1 + seen.duty) / 2)
        returns = walks & (seen.phase >= seen.duty) & ~early
        change = most * late - most * early - returns * np.clip(extension, -most, most)
        extension[:] = np.clip(extension + change, -limit, limit)
        inputs.reach += extension
        inputs.rate *= np.where(early, of_legs(self.hurry), 1.0)

    def c99(self) -> str:
        """Return `step` in C99."""
        return f"""\
{WALKING}\
const double limit = o->limit * s->length, most = o->speed * interval * s->length;
for (int leg = 0; leg < GAIT_LEGS; leg++) {{
    const int touches = seen->contacts[leg] > 0.5;
    const double phase = seen->phase[leg];
    double extension = s->extension[leg];
    if (walks && !touches && phase < seen->duty / 2) {{
        extension += most;
    }} else if (walks && touches && phase > (1 + seen->duty) / 2) {{
        extension -= most;
        inputs->rate[leg] *= o->hurry;
    }} else if (walks && phase >= seen->duty) {{
        extension -= gait_clip(extension, -most, most);
    }}
    s->extension[leg] = gait_clip(extension, -limit, limit);
    inputs->reach[leg] += s->extension[leg];
}}
"""

"""The reflex that adapts the legs to the height of the ground."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Floats, Inputs, Legs, Observation, Reflex, option
from gaitsim_reflexes.shared import WALKING, of_legs, walking

RETURN = 1.0  # legs' lengths per second, with which a swinging leg loses its change


class Contact(Reflex):
    """Adapts each leg to the ground where its foot lands, by foot contacts.

    A foot that finds no ground in the first half of stance is extended until it does. A foot that
    lands in the second half of swing is retracted, and its swing ends sooner. The leg keeps the
    change in stance, and loses it in swing. The conditions are those of Kimura, Fukuoka and Cohen
    2007 for walking on natural ground: feet land reliably, at the end of swing. On level ground,
    quick reflexes upset a trot, whose feet often lose contact for a moment.
    """

    extension: float = option(
        0.3, "speed of extension, in legs' lengths per second", unit="1/s", ge=0, le=5
    )
    retraction: float = option(
        0.1, "speed of retraction, in legs' lengths per second", unit="1/s", ge=0, le=5
    )
    limit: float = option(0.05, "largest change, as a share of the legs' length", ge=0, le=0.5)
    hurry: float = option(1.5, "factor of the speed of a swing whose foot has landed", ge=1, le=5)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("contacts",)

    def start(self, legs: Legs, weights: Floats) -> dict[str, Floats]:
        """Return the change of each leg, (population, legs), and the legs' length, in m."""
        return {
            "change": np.zeros((len(weights), len(legs.names))),
            "length": np.full(len(weights), legs.length),
        }

    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Extend or retract the legs, and shorten swings."""
        change, length = state["change"], state["length"][:, None]
        limit = of_legs(self.limit) * length
        most = RETURN * interval * length
        walks, touches = walking(seen)[:, None], seen.contacts > 0.5
        late = walks & ~touches & (seen.phase < seen.duty / 2)
        early = walks & touches & (seen.phase > (1 + seen.duty) / 2)
        swings = walks & (seen.phase >= seen.duty) & ~early
        change += late * of_legs(self.extension) * interval * length
        change -= early * of_legs(self.retraction) * interval * length
        change -= swings * np.clip(change, -most, most)
        change[:] = np.clip(change, -limit, limit)
        inputs.reach += change
        inputs.rate *= np.where(early, of_legs(self.hurry), 1.0)

    def c99(self) -> str:
        """Return `step` in C99."""
        return f"""\
{WALKING}\
const double limit = o->limit * s->length, most = {RETURN} * interval * s->length;
for (int leg = 0; leg < GAIT_LEGS; leg++) {{
    const int touches = seen->contacts[leg] > 0.5;
    const double phase = seen->phase[leg];
    double change = s->change[leg];
    if (walks && !touches && phase < seen->duty / 2) {{
        change += o->extension * interval * s->length;
    }} else if (walks && touches && phase > (1 + seen->duty) / 2) {{
        change -= o->retraction * interval * s->length;
        inputs->rate[leg] *= o->hurry;
    }} else if (walks && phase >= seen->duty) {{
        change -= gait_clip(change, -most, most);
    }}
    s->change[leg] = gait_clip(change, -limit, limit);
    inputs->reach[leg] += s->change[leg];
}}
"""

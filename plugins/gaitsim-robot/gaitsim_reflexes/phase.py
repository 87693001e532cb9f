"""The reflex that coordinates legs by their loads."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Floats, Inputs, Observation, Reflex, option
from gaitsim.plugin.toolkit import cos
from gaitsim_reflexes.shared import of_legs


class Phase(Reflex):
    """Keeps loaded legs in stance, so that legs coordinate by the load that they share.

    The phase oscillators of Owaki, Kano, Nagasawa, Tero and Ishiguro 2013: dφ/dt = ω − σ N cos φ,
    with the load N of the leg, and stance from π to 2π. A loaded leg slows down in the second half
    of its stance, and speeds up in the first. Here N is a share of the weight, σ is a share of ω,
    and the factor 1 − σ N cos φ applies to the speed of the phase of the body's own rhythm.
    """

    gain: float = option(0.5, "σ, as a share of the rhythm's own speed", ge=0, le=10)
    limit: float = option(0.8, "largest change of the factor", ge=0, le=1)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("load",)

    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Change the speed of each leg's phase."""
        phase, duty = seen.phase, seen.duty
        turns = np.where(phase < duty, 1 + phase / duty, (phase - duty) / (1 - duty))
        change = -of_legs(self.gain) * seen.load * cos(np.pi * turns)
        inputs.rate *= 1 + np.clip(change, -of_legs(self.limit), of_legs(self.limit))

    def c99(self) -> str:
        """Return `step` in C99."""
        return """\
for (int leg = 0; leg < GAIT_LEGS; leg++) {
    const double phase = seen->phase[leg], duty = seen->duty;
    const double turns = phase < duty ? 1 + phase / duty : (phase - duty) / (1 - duty);
    const double change = -o->gain * seen->load[leg] * cos(3.141592653589793 * turns);
    inputs->rate[leg] *= 1 + gait_clip(change, -o->limit, o->limit);
}
"""

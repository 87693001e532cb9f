"""The reflex that keeps a direction."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Floats, Inputs, Legs, Observation, Reflex, option
from gaitsim_reflexes.shared import COURSE_ERROR, DEGREE, WALKING, course_error, walking


class Heading(Reflex):
    """Turns the body back to the direction that the commands ask for, by the measured yaw.

    A proportional–integral controller (Åström and Murray 2008, chapter 10) of the turning speed,
    whose integral stops while the correction is at its limit. The rhythm turns by longer strokes on
    one side and shorter ones on the other. A robot that stands on command is not turned.
    """

    gain: float = option(4.0, "turning speed per angle off course", unit="1/s", ge=0, le=50)
    integral_gain: float = option(
        1.0, "change of the turning speed per angle off course and second", unit="1/s²", ge=0, le=50
    )
    limit: float = option(90.0, "largest correction", unit="°/s", ge=0, le=360)
    bound: float = option(45.0, "largest part of the integral in it", unit="°/s", ge=0, le=360)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("orientation",)

    def start(self, legs: Legs, weights: Floats) -> dict[str, Floats]:
        """Return the integral's part of the correction, (population,) rad/s."""
        return {"integral": np.zeros(len(weights))}

    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Add the correction to the commanded turn."""
        limit, bound = self.limit * DEGREE, self.bound * DEGREE
        error, walks = course_error(seen), walking(seen)
        wanted = self.gain * error + state["integral"]
        inputs.command[:, 1] += walks * np.clip(wanted, -limit, limit)
        grows = walks & ((np.abs(wanted) < limit) | (wanted * error < 0))
        integral = state["integral"] + grows * self.integral_gain * error * interval
        state["integral"][:] = np.clip(integral, -bound, bound)

    def c99(self) -> str:
        """Return `step` in C99."""
        return f"""\
{COURSE_ERROR}{WALKING}\
const double limit = o->limit * turn / 360, bound = o->bound * turn / 360;
const double wanted = o->gain * error + s->integral;
if (walks) {{
    inputs->command[1] += gait_clip(wanted, -limit, limit);
    if (fabs(wanted) < limit || wanted * error < 0)
        s->integral += o->integral_gain * error * interval;
}}
s->integral = gait_clip(s->integral, -bound, bound);
"""

"""The reflex that is learned: a small network with weights in the genome."""

from typing import ClassVar

import numpy as np

from gaitsim.plugin import Floats, Inputs, Legs, Observation, Reflex, option
from gaitsim.plugin.toolkit import Network, cos, gene_count, sin
from gaitsim_reflexes.shared import COURSE_ERROR, DEGREE, WALKING, course_error, walking

ANGLE = 0.25  # rad; angles of this size are inputs of 1
RATE = 2.0  # rad/s
INPUTS = 8


class NetworkReflex(Reflex):
    """Changes the command by a network that feels the body, with weights that evolve.

    It has a hidden layer of tanh neurons. Inputs are roll, pitch and the angle off course, in
    0.25 rad, the angular velocity, in 2 rad/s, and sine and cosine of the first leg's phase.
    Outputs are a tanh, too, times the limits. A robot that stands on command is not moved.
    """

    hidden: int = option(4, "number of hidden neurons", ge=1, le=16)
    strength: float = option(2.0, "largest weight of the network", gt=0, le=10)
    speed: float = option(0.05, "largest change of the speed", unit="m/s", ge=0, le=1)
    turn: float = option(30.0, "largest change of the turning speed", unit="°/s", ge=0, le=360)
    sideways: float = option(0.0, "largest change of the sideways speed", unit="m/s", ge=0, le=1)
    height: float = option(0.0, "largest change of the trunk's height", unit="m", ge=0, le=0.2)

    portable: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("orientation", "rates")

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of neurons in each layer, inputs first."""
        return INPUTS, self.hidden, 4

    def weights(self, legs: Legs) -> int:
        """Return the number of weights and biases."""
        return gene_count(self.sizes)

    def start(self, legs: Legs, weights: Floats) -> dict[str, Floats]:
        """Return the genes, (population, weights), in the order of `Network.genes`."""
        return {"genes": np.array(weights, np.float64)}

    def step(
        self, state: dict[str, Floats], seen: Observation, inputs: Inputs, interval: float
    ) -> None:
        """Add the outputs of the network to the command."""
        angle = 2 * np.pi * seen.phase[:, 0]
        felt = np.column_stack(
            [
                seen.orientation[:, :2] / ANGLE,
                course_error(seen) / ANGLE,
                seen.rates / RATE,
                sin(angle),
                cos(angle),
            ]
        )
        genes = np.asarray(self.strength)[..., None] * state["genes"]
        network = Network.from_genes(self.sizes, genes, output="tanh")
        outputs = network.activate(felt[..., None])[..., 0] * walking(seen)[:, None]
        limits = (self.speed, self.turn * DEGREE, self.sideways, self.height)
        for part, limit in enumerate(limits):
            inputs.command[:, part] += limit * outputs[:, part]

    def c99(self) -> str:
        """Return `step` in C99."""
        return f"""\
{COURSE_ERROR}{WALKING}\
const int hidden = (int)o->hidden;
const double angle = turn * seen->phase[0];
const double felt[{INPUTS}] = {{
    seen->orientation[0] / {ANGLE}, seen->orientation[1] / {ANGLE}, error / {ANGLE},
    seen->rates[0] / {RATE}, seen->rates[1] / {RATE}, seen->rates[2] / {RATE},
    sin(angle), cos(angle)
}};
const double limits[4] = {{o->speed, o->turn * turn / 360, o->sideways, o->height}};
const double *first = s->genes, *first_bias = first + hidden * {INPUTS};
const double *last = first_bias + hidden, *last_bias = last + 4 * hidden;
double neurons[16];
for (int to = 0; to < hidden; to++) {{
    double sum = o->strength * first_bias[to];
    for (int from = 0; from < {INPUTS}; from++)
        sum += o->strength * first[{INPUTS} * to + from] * felt[from];
    neurons[to] = tanh(sum);
}}
for (int to = 0; walks && to < 4; to++) {{
    double sum = o->strength * last_bias[to];
    for (int from = 0; from < hidden; from++)
        sum += o->strength * last[hidden * to + from] * neurons[from];
    inputs->command[to] += limits[to] * tanh(sum);
}}
"""

"""The fly in JavaScript is the fly in Python."""

from importlib import resources

import numpy as np
import pytest
from javascript import call

from gaitsim_fly import assets
from gaitsim_fly.organism import Fly
from gaitsim_fly.page import control_data, mechanics_data

FLY = """
const { own, control, genes, frames } = data;
const state = {
  position: [0, 0, 0], rotation: [1, 0, 0, 0], velocity: [0, 0, 0], momentum: [0, 0, 0],
  wings: [0, 0, 0, 0, 0, 0], rates: [0, 0, 0, 0, 0, 0], alive: true,
};
const states = [];
for (let frame = 0; frame < frames; frame += 1) {
  states.push([...state.position, ...state.rotation, ...state.velocity, ...state.wings]);
  command(state, answer(genes, see(state, WORLD, control, own), control), control, own);
  step(state, control.dt, control.steps, own);
}
return { states, alive: state.alive };
"""


@pytest.mark.parametrize(
    "options",
    [
        {"wings": "asymmetric"},
        pytest.param(
            {"activation": "sigmoid", "mass": 0.3, "wing_speed": 20.0}, marks=pytest.mark.slow
        ),
        pytest.param(
            {"wings": "asymmetric", "activation": "leaky-relu", "hidden": (7, 5, 3), "dt": 0.0005},
            marks=pytest.mark.slow,
        ),
    ],
)
def test_it_flies_as_python_does_to_the_bit(options):
    fly = Fly(duration=5.0, **options)
    space = fly.genome_space()
    genes = np.random.default_rng(1).normal(0, 0.5, (1, len(space.labels)))
    motion = fly.move(genes)
    data = {
        "own": mechanics_data(fly.mechanics({})),
        "control": control_data(fly),
        "genes": genes[0].tolist(),
        "frames": fly.frames,
    }
    files = resources.files(assets)
    scripts = "\n".join(
        files.joinpath(name).read_text("utf-8") for name in ("flight.js", "control.js")
    )
    found = call(scripts, FLY, data)
    assert found["alive"]
    assert not motion.failures
    channels = ("position", "rotation", "velocity", "wing_angles")
    expected = np.concatenate([motion[name][0, :, 0] for name in channels], axis=-1)
    assert np.array_equal(np.array(found["states"]), expected)

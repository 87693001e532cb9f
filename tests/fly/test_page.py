"""The fly in JavaScript is the fly in Python."""

from importlib import resources

import numpy as np
import pytest
from gaitsim_fly.steering import NAMES
from javascript import call

from gaitsim.experiment import load_experiment
from gaitsim.steering import PRESET
from gaitsim_fly import assets
from gaitsim_fly.organism import Fly
from gaitsim_fly.page import control_data, mechanics_data, page, scripts

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


COMMANDED = """
const fly = steeredFly(data.page);
return data.commands.map(([name, frames]) => {
  const { ends, shares } = fly.advance(name, frames);
  const { position, rotation, velocity, wings } = fly.state;
  return { state: [...position, ...rotation, ...velocity, ...wings], ends: [...ends], shares };
});
"""


def commanded(fly, controllers, seconds, seed):
    """States, ends of segments and shares after each of some random commands: here, there."""
    rng = np.random.default_rng(seed)
    commands = []
    while sum(frames for _, frames in commands) < 100 * seconds:
        commands.append((NAMES[rng.integers(len(NAMES))], int(rng.integers(1, 150))))
    steered, here = fly.steer(controllers), []
    for name, frames in commands:
        motion = steered.advance(name, frames)
        assert not motion.failures
        channels = ("position", "rotation", "velocity", "wing_angles")
        state = np.concatenate([motion[channel][0, -1, 0] for channel in channels])
        ends = fly.skeleton(motion, 0).segments[-1].ravel()
        here.append((state, ends, motion["shares"][0, -1]))
    data = {"page": page(fly, controllers).data, "commands": commands}
    there = call(scripts(), COMMANDED, data)
    return here, [(one["state"], one["ends"], one["shares"]) for one in there]


@pytest.mark.parametrize("wings", ["mirrored", pytest.param("asymmetric", marks=pytest.mark.slow)])
def test_it_follows_commands_as_python_does_to_the_bit(wings):
    fly = Fly(wings=wings, hidden=(12,))
    rng, genes = np.random.default_rng(2), fly.genome_space().genes
    controllers = {name: rng.normal(0, 0.5, genes) for name in NAMES}
    for here, there in zip(*commanded(fly, controllers, 4.0, 5), strict=True):
        assert np.array_equal(here[0], there[0])
        assert np.array_equal(here[2], there[2])
        assert np.allclose(here[1], there[1], rtol=0, atol=1e-11)


@pytest.mark.slow
def test_the_trained_networks_fly_the_same_minute_in_a_page():
    fly = load_experiment(PRESET).organism
    here, there = commanded(fly, fly.controllers(), 60.0, 7)
    assert all(np.array_equal(one[0], other[0]) for one, other in zip(here, there, strict=True))
    assert min(one[1][2::3].min() for one in here) > 0


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

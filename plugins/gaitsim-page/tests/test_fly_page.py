"""The fly in JavaScript against the fly in Python."""

from importlib import resources

import numpy as np
import pytest
from javascript import call

from gaitsim.experiment import load_experiment
from gaitsim_fly import assets
from gaitsim_fly.organism import Fly
from gaitsim_fly.page import control_data, mechanics_data, page, scripts
from gaitsim_fly.steering import NAMES

FLY = """
const { own, control, genes, frames } = data;
const state = {
  position: [0, 0, 0], rotation: [1, 0, 0, 0], velocity: [0, 0, 0], momentum: [0, 0, 0],
  wings: [0, 0, 0, 0, 0, 0], rates: [0, 0, 0, 0, 0, 0], alive: true,
};
const states = [];
for (let frame = 0; frame < frames; frame += 1) {
  states.push([...state.position, ...state.rotation, ...state.velocity, ...state.wings]);
  const inputs = networkInputs(state, WORLD, control, own);
  command(state, wingCommands(genes, inputs, control), control, own);
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
    """Return states, ends of segments and shares after random commands in Python and JavaScript."""
    rng = np.random.default_rng(seed)
    commands = []
    while sum(frames for _, frames in commands) < 100 * seconds:
        commands.append((NAMES[rng.integers(len(NAMES))], int(rng.integers(1, 150))))
    steered, expected = fly.steer(controllers), []
    for name, frames in commands:
        steered.give(name)
        motion = steered.advance(frames)
        assert not motion.failures
        channels = ("position", "rotation", "velocity", "wing_angles")
        state = np.concatenate([motion[channel][0, -1, 0] for channel in channels])
        ends = fly.skeleton(motion, 0).segments[-1].ravel()
        expected.append((state, ends, motion["shares"][0, -1]))
    data = {"page": page(fly, controllers).data, "commands": commands}
    found = call(scripts(), COMMANDED, data)
    return expected, [(one["state"], one["ends"], one["shares"]) for one in found]


@pytest.mark.parametrize("wings", ["mirrored", pytest.param("asymmetric", marks=pytest.mark.slow)])
def test_commands_give_the_same_bits_as_in_python(wings):
    fly = Fly(wings=wings, hidden=(12,))
    rng, genes = np.random.default_rng(2), fly.genome_space().genes
    controllers = {name: rng.normal(0, 0.5, genes) for name in NAMES}
    for expected, found in zip(*commanded(fly, controllers, 4.0, 5), strict=True):
        assert np.array_equal(expected[0], found[0])
        assert np.array_equal(expected[2], found[2])
        assert np.allclose(expected[1], found[1], rtol=0, atol=1e-11)


@pytest.mark.slow
def test_the_trained_networks_fly_for_a_minute_with_the_same_bits():
    fly = load_experiment("fly-steer-hover").organism
    for expected, found in zip(*commanded(fly, fly.controllers(), 60.0, 7), strict=True):
        assert np.array_equal(expected[0], found[0])


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
def test_flights_have_the_same_bits_as_in_python(options):
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

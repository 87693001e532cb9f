"""Rhythms: the tape without changes, strokes against rigid motion, limits, and standing."""

from functools import cache

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gaitsim.contracts import Inputs
from gaitsim_robot.organism import Robot
from gaitsim_robot.rhythm import RAMP_TIME, RhythmState, advance

INTERVAL = 0.02  # s
ROBOTS = ("quadruped", "hexapod", "spider-physics")


@cache
def robot(model, encoding="steps"):
    return Robot(model=model, encoding=encoding, symmetry="alternating", servo="ideal")


def start(body, count=1):
    return np.tile(next(iter(body.starts().values())), (count, 1))


def play(rhythm, command, frames, *, walking=True, reach=None):
    """Return the joint angles of a population with one command, (frames, population, joints)."""
    state, walks = RhythmState(rhythm), np.full(len(rhythm), walking)
    inputs = inputs_of(rhythm, np.tile(command, (len(rhythm), 1)))
    if reach is not None:
        inputs.reach[:] = reach
    return np.array([advance(rhythm, state, walks, inputs, INTERVAL).copy() for _ in range(frames)])


def inputs_of(rhythm, command):
    return Inputs.unchanged(np.array(command), len(rhythm.names))


def place_feet(body, angles):
    """Return the feet, (frames, legs, 3) m, by MuJoCo, with the trunk held in its standing pose."""
    simulation = body.simulation
    model, data = simulation.model, mujoco.MjData(simulation.model)
    found = []
    for pose in angles:
        data.qpos[:] = simulation.anatomy.stance
        data.qpos[simulation.qpos] = pose
        mujoco.mj_kinematics(model, data)
        found.append(
            [data.site(f"world: foot {leg.name}").xpos.copy() for leg in simulation.anatomy.legs]
        )
    return np.array(found)


@pytest.mark.parametrize("model", ROBOTS)
@pytest.mark.parametrize("encoding", ["steps", "sine"])
def test_own_speed_is_the_tape(model, encoding):
    body = robot(model, encoding)
    coder, genomes = body._encoding, start(body)
    rhythm = coder.rhythm(genomes)
    angles = play(rhythm, [rhythm.own_speed[0], 0, 0, 0], 150)
    tape, frequency = coder.commands(genomes, 151)
    ramp = round(RAMP_TIME / INTERVAL)
    np.testing.assert_allclose(angles[ramp:, 0], tape[0, 1 + ramp :], atol=np.radians(0.05))
    np.testing.assert_allclose(rhythm.frequency, frequency)


@pytest.mark.parametrize("model", ROBOTS)
@pytest.mark.parametrize(
    "command", [(0.1, 0, 0, 0), (0, 0.5, 0, 0), (0, 0, 0.08, 0), (0.1, 0.3, 0.05, 0)]
)
def test_stance_feet_move_as_on_the_ground(model, command):
    """Relative to the trunk, feet on the ground move by −(v + ω × r) dt."""
    body = robot(model)
    rhythm = body._encoding.rhythm(start(body))
    frames = 100
    angles = play(rhythm, command, frames)[:, 0]
    feet = place_feet(body, angles) - body.simulation.anatomy.stance[:3]
    feet = (
        Rotation.from_quat(body.simulation.anatomy.stance[3:7], scalar_first=True)
        .inv()
        .apply(feet.reshape(-1, 3))
        .reshape(feet.shape)
    )
    phase = (
        rhythm.frequency[0] * INTERVAL * np.arange(1, frames + 1)[:, None] + rhythm.offset[0]
    ) % 1
    first = round(RAMP_TIME / INTERVAL)
    inner = (phase > 0.1 * rhythm.duty[0]) & (phase < 0.9 * rhythm.duty[0])
    both = inner[first:-1] & inner[first + 1 :]
    moved = np.diff(feet[first:], axis=0)[..., :2] / INTERVAL
    arm = rhythm.tips[:, :2] - rhythm.tips[:, :2].mean(axis=0)
    expected = -np.array(
        [command[0] - command[1] * arm[:, 1], command[2] + command[1] * arm[:, 0]]
    ).T
    error = np.where(both[..., None], moved - expected, 0.0)
    assert both.any(axis=0).all()
    assert np.abs(error).max() < 0.12 * np.abs(expected).max() + 0.01


def test_standing_returns_to_the_standing_pose():
    body = robot("hexapod")
    rhythm = body._encoding.rhythm(start(body))
    state, inputs = RhythmState(rhythm), inputs_of(rhythm, [[0.2, 0.2, 0.0, 0.0]])
    for frame in range(200):
        walks = np.array([frame < 100])
        angles = advance(rhythm, state, walks, inputs, INTERVAL)
        if frame == 99:
            assert np.abs(angles[0] - rhythm.standing).max() > np.radians(5)
    np.testing.assert_allclose(angles[0], rhythm.standing, atol=1e-6)


@pytest.mark.slow
def test_height_and_reach_move_the_feet():
    body = robot("quadruped")
    rhythm = body._encoding.rhythm(start(body))
    standing = place_feet(body, rhythm.standing[None])[0]
    high = place_feet(body, play(rhythm, [0, 0, 0, 0.02], 20, walking=False)[-1])[0]
    np.testing.assert_allclose(high - standing, [[0, 0, -0.02]] * 4, atol=1e-3)
    reach = np.array([[0.01, 0.0, 0.0, -0.01]])
    long = place_feet(body, play(rhythm, [0, 0, 0, 0], 20, walking=False, reach=reach)[-1])[0]
    np.testing.assert_allclose(standing[:, 2] - long[:, 2], reach[0], atol=1e-3)


def test_long_strokes_are_shortened_for_all_legs():
    body = robot("hexapod")
    rhythm = body._encoding.rhythm(start(body))
    state = RhythmState(rhythm)
    for factor, scale in ((0.5, 1.0), (1.0, 1.0), (4.0, 0.25)):
        inputs = inputs_of(rhythm, [[factor * rhythm.limits[0, 0], 0.0, 0.0, 0.0]])
        advance(rhythm, state, np.array([True]), inputs, INTERVAL)
        assert state.scale[0] == pytest.approx(scale)


def test_commands_stay_within_angles_and_speeds():
    body = robot("spider-physics")
    space = body.genome_space()
    shares = np.random.default_rng(0).random((20, space.genes))
    rhythm = body._encoding.rhythm(space.lower + shares * (space.upper - space.lower))
    angles = play(rhythm, [3.0, 9.0, 2.0, 0.5], 100, reach=np.full((20, 8), 0.1))
    assert np.all((angles >= rhythm.lower - 1e-12) & (angles <= rhythm.upper + 1e-12))
    steps = np.abs(np.diff(angles, axis=0))
    assert np.all(steps <= rhythm.speed_limit * INTERVAL + 1e-12)


def test_rates_of_legs_return_to_the_gait():
    body = robot("hexapod")
    rhythm = body._encoding.rhythm(start(body))
    state = RhythmState(rhythm)
    inputs = inputs_of(rhythm, [[rhythm.own_speed[0], 0.0, 0.0, 0.0]])
    inputs.rate[0, 2] = 2.0
    for _ in range(10):
        advance(rhythm, state, np.array([True]), inputs, INTERVAL)
    ahead = state.lead[0].copy()
    assert ahead[2] > 0.1
    assert not np.delete(ahead, 2).any()
    inputs.rate[:] = 1.0
    for _ in range(100):
        advance(rhythm, state, np.array([True]), inputs, INTERVAL)
    assert 0 < state.lead[0, 2] < 0.01 * ahead[2]

"""Commands to the servos: kinematics against MuJoCo, limits, and symmetries."""

import math
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from small_robots import FACING_Y, HEXAPOD, HUMANOID, QUADRUPED

from gaitsim.encoding import genome_space
from gaitsim_robot.chain import jacobian
from gaitsim_robot.encodings import SAMPLES, Encoding, cycle_angles
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.simulation import FRAME_RATE

ROBOTS = {"quadruped": QUADRUPED, "facing y": FACING_Y, "hexapod": HEXAPOD, "humanoid": HUMANOID}
KINDS = ("steps", "sine", "cpg")
SYMMETRIES = ("none", "alternating", "trot", "bound", "wave")
TOP_SPEED = 5.0  # rad/s


@cache
def encoding(robot, kind="steps", symmetry="none"):
    model = mujoco.MjModel.from_xml_string(ROBOTS[robot])
    anatomy = find_anatomy(model)
    return Encoding(model, anatomy, np.full(len(anatomy.joints), TOP_SPEED), kind, symmetry)


def genomes(coder, count, seed=0):
    space = genome_space(coder.groups)
    shares = np.random.default_rng(seed).random((count, len(space.lower)))
    return space.lower + shares * (space.upper - space.lower)


def genome(coder, **values):
    """Return a genome with these values; other genes are 0, or the nearest allowed value."""
    genes = [
        np.clip(np.full(len(group.parts), values.get(group.name, 0.0)), group.lower, group.upper)
        for group in coder.groups
    ]
    return np.concatenate(genes)[None]


def feet(coder, angles):
    """Return the feet at angles of the leg joints, computed by MuJoCo, (frames, legs, 3) m."""
    model, anatomy = coder.model, coder.anatomy
    data = mujoco.MjData(model)
    address = [model.joint(name).qposadr[0] for name in anatomy.joints]
    places = np.empty((len(angles), len(anatomy.legs), 3))
    for frame, pose in enumerate(angles):
        data.qpos[:] = anatomy.stance
        data.qpos[address] = pose
        mujoco.mj_kinematics(model, data)
        for at, leg in enumerate(anatomy.legs):
            body = data.body(leg.foot)
            places[frame, at] = body.xpos + body.xmat.reshape(3, 3) @ leg.point
    return places


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_fitted_gait_reproduces_sines(robot):
    coder = encoding(robot, "sine")
    rng, joints = np.random.default_rng(2), len(coder.anatomy.joints)
    amplitude, offset = rng.uniform(0.05, 0.2, joints), rng.uniform(-0.1, 0.1, joints)
    delay, frequency, rate = rng.uniform(-3, 3, joints), 1.3, 30.0
    turn = 2 * np.pi * frequency * np.arange(round(4 * rate / frequency))[:, None] / rate
    noise = 0.01 * np.sin(3 * turn)
    lower, upper = coder._limits
    sines = np.clip(coder._standing + offset, lower + 0.2, upper - 0.2)
    sines = sines + amplitude * np.sin(turn + delay)
    gait, angles = coder.fit(sines + noise, frequency, rate)
    assert np.abs(angles - sines).max() < 0.002
    # The tape of the genome is these sines, from the end of its start.
    tape, strides = coder.commands(gait[None], 100)
    assert strides[0] == frequency
    time = np.arange(50, 100)[:, None] / FRAME_RATE
    expected = sines.mean(axis=0) + amplitude * np.sin(2 * np.pi * frequency * time + delay)
    assert np.abs(tape[0, 50:] - expected).max() < 0.005


@pytest.mark.parametrize("robot", ROBOTS)
def test_forward_kinematics_agree_with_mujoco(robot):
    coder = encoding(robot)
    lower, upper = coder._limits
    angles = lower + np.random.default_rng(1).random((5, len(lower))) * (upper - lower)
    first = 0
    for at, chain in enumerate(coder.chains):
        own = angles[:, first : first + len(chain.zero)]
        assert chain.place(own) == pytest.approx(feet(coder, angles)[:, at], abs=1e-12)
        first += len(chain.zero)


def test_the_jacobian_is_the_derivative_of_the_kinematics():
    chain = encoding("humanoid").chains[0]
    angles = chain.zero + 0.1
    nudge = 1e-6 * np.eye(len(angles))
    slope = (chain.place(angles + nudge) - chain.place(angles - nudge)) / 2e-6
    tips, _, anchors, axes = chain._pose(angles - chain.zero)
    assert jacobian(tips, anchors, axes, chain.slides)[:3] == pytest.approx(slope.T, abs=1e-8)


@pytest.mark.parametrize("robot", ROBOTS)
def test_inverse_kinematics_reach_all_targets_within_reach(robot):
    coder = encoding(robot)
    for leg, chain in zip(coder.anatomy.legs, coder.chains, strict=True):
        near = np.random.default_rng(2).uniform(-0.2, 0.2, (50, SAMPLES, len(chain.zero)))
        targets = chain.place(np.clip(chain.zero + near, chain.lower, chain.upper))
        found = cycle_angles(chain, targets, level=False)
        error = np.linalg.norm(chain.place(found) - targets, axis=-1)
        assert error.max() < 1e-4, leg.name


def test_strides_have_the_heading():
    ahead = encoding("hexapod", symmetry="trot")
    stepping = genome(ahead, stride=0.03, lift=0.01, duty=0.5, frequency=0.5)
    swept = [
        np.ptp(feet(coder, coder.commands(stepping, 200)[0][0, 50:]), axis=0)
        for coder in (ahead, replace(ahead, heading=math.pi / 2))
    ]
    assert swept[1][:, 1] == pytest.approx(swept[0][:, 0], abs=1e-3)
    assert swept[0][:, 1].max() < 1e-3
    assert swept[1][:, 0].max() < 1e-3


def test_a_sole_stays_level():
    coder = encoding("humanoid")
    angles = coder.commands(genome(coder, stride=0.2, lift=0.1, frequency=0.5), 200)[0][0]
    data = mujoco.MjData(coder.model)
    data.qpos[:] = coder.anatomy.stance
    address = [coder.model.joint(name).qposadr[0] for name in coder.anatomy.joints]
    for pose in angles[25:]:
        data.qpos[address] = pose
        mujoco.mj_kinematics(coder.model, data)
        assert data.body("left_foot").xmat[8] > math.cos(0.05)


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(
    robot=st.sampled_from(tuple(ROBOTS)),
    kind=st.sampled_from(KINDS),
    symmetry=st.sampled_from(SYMMETRIES),
    seed=st.integers(0, 2**32 - 1),
    corners=st.booleans(),
)
def test_commands_of_any_genome_respect_the_limits_and_the_top_speed(
    robot, kind, symmetry, seed, corners
):
    coder = encoding(robot, kind, symmetry)
    space = genome_space(coder.groups)
    drawn = genomes(coder, 3, seed)
    if corners:
        drawn = np.where(drawn > (space.lower + space.upper) / 2, space.upper, space.lower)
    angles = coder.commands(drawn, 40)[0]
    lower, upper = np.array([coder.model.joint(name).range for name in coder.anatomy.joints]).T
    assert (angles >= lower - 1e-12).all()
    assert (angles <= upper + 1e-12).all()
    assert np.abs(np.diff(angles, axis=1)).max() <= TOP_SPEED / FRAME_RATE + 1e-12
    standing = [
        coder.anatomy.stance[coder.model.joint(name).qposadr[0]] for name in coder.anatomy.joints
    ]
    assert angles[:, 0] == pytest.approx(np.tile(standing, (3, 1)))


LAGS = {
    "alternating": [0, 0.5, 0.5, 0, 0, 0.5],
    "trot": [0, 0.5, 0.5, 0, 0, 0.5],
    "bound": [0, 0, 0.5, 0.5, 0, 0],
    "wave": [-0.5, 0, -0.25, 0.25, 0, 0.5],
}


@pytest.mark.parametrize(
    ("kind", "symmetry"),
    [*(("steps", one) for one in LAGS), ("sine", "alternating"), ("sine", "wave"), ("cpg", "wave")],
)
def test_mirrored_legs_make_the_same_steps_with_the_lags_of_the_symmetry(kind, symmetry):
    lags = LAGS[symmetry]
    coder = encoding("hexapod", kind, symmetry)
    step = {"stride": 0.03, "lift": 0.02, "duty": 0.6, "shift": 0.01}
    wave = {"amplitude": 0.2, "offset": 0.1, "delay": 0.3}
    drawn = genome(coder, frequency=0.5, lag=math.pi / 2, **step, **wave)
    path = feet(coder, coder.commands(drawn, 301)[0][0])  # 100 frames per cycle
    for leg in range(6):
        later = round(100 * (lags[leg] - lags[leg % 2])) % 100
        ahead = path[100 + later : 200 + later, leg % 2, 2]
        if kind == "steps":
            assert path[100:200, leg, 2] == pytest.approx(ahead, abs=1e-5)
    for left in (0, 2, 4):
        later = round(100 * (lags[left + 1] - lags[left])) % 100
        mirrored = path[100 + later : 200 + later, left] * [1, -1, 1]
        assert path[100:200, left + 1] == pytest.approx(mirrored, abs=1e-4)


def test_a_step_has_its_length_height_and_stance():
    coder = encoding("quadruped", symmetry="trot")
    size = np.mean([leg.length for leg in coder.anatomy.legs])
    lengths = {"stride": 0.1 / size, "lift": 0.05 / size, "height": -0.02 / size}
    step = {**lengths, "duty": 0.6, "frequency": 0.5}
    path = feet(coder, coder.commands(genome(coder, **step), 301)[0][0])[100:200]
    standing = feet(coder, coder.commands(genome(coder), 1)[0][0])[0]
    left = path[:, 0] - standing[0]
    assert left[:, 2].max() == pytest.approx(0.05 + 0.02, abs=1e-3)
    stance = left[:, 2] < 0.02 + 1e-3
    assert stance.mean() == pytest.approx(0.6, abs=0.06)
    assert np.ptp(left[stance, 0]) == pytest.approx(0.1, abs=5e-3)
    assert np.abs(left[:, 1]).max() < 1e-3


def test_symmetries_reduce_the_number_of_genes():
    coders = {name: encoding("quadruped", "steps", name) for name in SYMMETRIES}
    counts = {name: len(genome_space(coder.groups).lower) for name, coder in coders.items()}
    assert counts == {"none": 17, "alternating": 7, "trot": 7, "bound": 7, "wave": 8}

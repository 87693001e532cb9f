"""The steered fly."""

from typing import Any

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment
from gaitsim_fly.organism import Fly, trained_networks
from gaitsim_fly.steering import BLEND, NAMES, START


def fly(**options: Any) -> Fly:
    return Fly(wings="mirrored", hidden=(12,), **options)


def tilt(motion: Any) -> Any:
    """Return the angle between the body's back and the vertical, (frames,) degrees."""
    x, y = motion["rotation"][0, :, 0, 1], motion["rotation"][0, :, 0, 2]
    return np.degrees(np.arccos(np.clip(1 - 2 * (x * x + y * y), -1, 1)))


def test_controllers_fit_all_steering_presets() -> None:
    for name in ("fly-steer", *(f"fly-steer-{own}" for own in NAMES if own != "right")):
        organism = load_experiment(name).organism
        assert [command.name for command in organism.commands()] == list(NAMES)
        controllers = organism.controllers()
        assert {*controllers} == {*NAMES}
        assert all(len(genome) == organism.genome_space().genes for genome in controllers.values())
    assert not Fly().commands()
    assert not Fly(wings="asymmetric", hidden=(12,)).controllers()
    assert "fly-steer-climb" in trained_networks().experiments["climb"]


@pytest.mark.slow
def test_splitting_a_command_does_not_change_any_bit_and_control_passes_smoothly() -> None:
    own = fly()
    whole, cut = (own.steer(own.controllers()) for _ in range(2))
    whole.give("climb")
    cut.give("climb")
    first = whole.advance(30)
    parts = [cut.advance(frames) for frames in (1, 12, 17)]
    for name in (*own.channels, "shares"):
        joined = np.concatenate([part[name] for part in parts], axis=1)
        assert (joined == first[name]).all(), name
    shares = first["shares"][0]
    np.testing.assert_allclose(shares.sum(axis=1), 1, atol=1e-12)
    assert np.abs(np.diff(shares, axis=0)).max() <= own.control_step / BLEND + 1e-12
    assert shares[-1, NAMES.index("climb")] == 1
    assert own.skeleton(first, 0).path.shape == (30, 3)
    assert own.measures(first)["largest tilt"].values[0] < 90


@pytest.mark.slow
def test_a_steered_network_flies_a_course_as_in_move() -> None:
    own = fly(course="forward", duration=0.5)
    genome = own.controllers()["forward"]
    moved = own.move(genome[None])
    steered = own.steer(dict.fromkeys(NAMES, genome))
    steered._shares[:] = 0, 0, 0, 0, 1  # type: ignore[attr-defined]
    steered.give("forward")
    motion = steered.advance(50)
    np.testing.assert_allclose(
        motion["position"][0] - [0, 0, START], moved["position"][0, 1:], atol=1e-9
    )
    np.testing.assert_allclose(motion["course"][0, :, 0, 0], np.arange(1, 51) * 0.015)


def test_a_mirrored_network_turns_right_as_it_turns_left() -> None:
    left, right = (
        fly(course=course, duration=0.5).move(fly().controllers()["left"][None])["position"]
        for course in ("left", "right")
    )
    np.testing.assert_allclose(left, right * [1, -1, 1], atol=1e-9)


def test_invalid_bodies_controllers_and_commands_are_refused() -> None:
    own = fly()
    with pytest.raises(GaitsimError, match="symmetric"):
        Fly().steer({})
    with pytest.raises(GaitsimError, match="no controller for the command 'hover'"):
        own.steer({})
    with pytest.raises(GaitsimError, match="shape"):
        own.steer(dict.fromkeys(NAMES, np.zeros(3)))
    steered = own.steer(own.controllers())
    with pytest.raises(GaitsimError, match="dive"):
        steered.give("dive")
    with pytest.raises(GaitsimError, match="0 frames"):
        steered.advance(0)


@pytest.mark.parametrize(
    ("command", "speeds"),
    [
        ("hover", (0, 0, 0)),
        ("climb", (0, 0.5, 0)),
        ("left", (0, 0, 1.5)),
        ("right", (0, 0, -1.5)),
        ("forward", (1.5, 0, 0)),
    ],
)
def test_each_command_reaches_its_speeds(command: str, speeds: Any) -> None:
    own = fly()
    steered = own.steer(own.controllers())
    steered.give(command)
    motion = steered.advance(300)
    velocity = motion["velocity"][0, 100:, 0].mean(axis=0)
    yaw = motion["angular_velocity"][0, 100:, 0, 2].mean()
    np.testing.assert_allclose([velocity[0], velocity[2], yaw], speeds, atol=0.2)
    assert tilt(motion).max() < 65


def test_a_course_alternates_with_others() -> None:
    own = fly(course="forward", course_changes=0.5, duration=10.0, trials=3)
    courses = own.move(own.controllers()["hover"][None])["course"][0]
    moved = np.diff(courses, axis=0)
    ahead = np.hypot(moved[..., 0], moved[..., 1])
    own_part = np.isclose(ahead, own.course_speed * own.control_step, atol=1e-9)
    assert 0.4 < own_part.mean() < 0.9  # every second part, and parts that draw the same course
    assert own_part[:20].all()  # the first part
    changes = np.diff(np.round(moved, 9)[..., 2], axis=0) != 0
    assert changes.any(axis=0).all()  # each trial climbs in some parts


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_it_flies_for_a_minute_under_random_commands(seed: int) -> None:
    own = fly()
    steered = own.steer(own.controllers())
    rng = np.random.default_rng(seed)
    left = 6000
    while left:
        frames = min(left, int(rng.integers(30, 201)))  # 0.3 s to 2 s
        steered.give(NAMES[rng.integers(len(NAMES))])
        motion = steered.advance(frames)
        left -= frames
        assert not motion.failures
        assert own.skeleton(motion, 0).segments[..., 2].min() > 0.5
        assert tilt(motion).max() < 75
        away = np.linalg.norm((motion["position"] - motion["course"][..., :3])[0, :, 0], axis=-1)
        assert away.max() < 0.8

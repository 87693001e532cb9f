"""Synthetic motions of a robot, for its fitnesses."""

import numpy as np

from gaitsim.contracts import Motion

RATE, FRAMES = 50.0, 501  # 10 s
TIME = np.arange(FRAMES) / RATE
LENGTH, WEIGHT, STALL = 0.4, 20.0, 2.0


def motion(**changed):
    """Return the motion of a robot that stands still, with some channels replaced."""
    channels = {
        "torso": np.zeros((FRAMES, 3)),
        "orientation": np.zeros((FRAMES, 3)),
        "height": np.full(FRAMES, 0.2),
        "command": np.zeros((FRAMES, 4)),
        "joint_positions": np.zeros((FRAMES, 4)),
        "torque": np.zeros((FRAMES, 4)),
        "stall_torque": np.full(4, STALL),
        "energy": np.zeros(FRAMES),
        "slip": np.zeros(FRAMES),
        "lasted": np.array(10.0),
        "weight": np.array(WEIGHT),
        "length": np.array(LENGTH),
    }
    return Motion(RATE, {name: values[None] for name, values in (channels | changed).items()})


def straight(x, y=0.0):
    """Return the path of a torso that moves to a point at constant velocity."""
    return TIME[:, None] / TIME[-1] * np.array([x, y, 0.0])


def random_motion(individuals):
    """Return motions with random channels."""
    rng = np.random.default_rng(0)
    shapes = {name: values.shape[1:] for name, values in motion().items()}
    channels = {name: rng.random((individuals, *shape)) for name, shape in shapes.items()}
    # Bodies may return arrays with any memory layout.
    channels["torque"] = np.asfortranarray(channels["torque"])
    return Motion(RATE, channels)


def assert_independent_of_the_population(fitness):
    """Check that the terms of an individual have the same bits in any part of a population."""
    everyone = random_motion(9)
    whole = fitness.terms(everyone)
    for part in (slice(4, 5), slice(2, 9)):
        chosen = {name: values[part] for name, values in everyone.items()}
        for name, values in fitness.terms(Motion(RATE, chosen)).items():
            assert np.array_equal(values, whole[name][part]), name

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

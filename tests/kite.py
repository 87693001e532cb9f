"""A steerable puppet that rises by the first gene of the active controller."""

import numpy as np

from gaitsim.contracts import Command, Motion, Skeleton, Steered

RATE = 100.0
COMMANDS = (
    Command("stay", "down", "stay at the height"),
    Command("rise", "up", "rise"),
    Command("sink", "space", "sink"),
)
CONTROLLERS = {
    "stay": np.zeros(3), "rise": np.array([1.0, 0.0, 0.0]), "sink": np.array([-1.0, 0.0, 0.0])
}  # fmt: skip


class Kite(Steered):
    frame_rate = RATE

    def __init__(self, controllers):
        self.controllers, self.height = controllers, 1.0
        self.command = COMMANDS[0].name

    def give(self, command):
        self.command = command

    def advance(self, frames):
        speed = self.controllers[self.command][0]
        heights = self.height + speed / RATE * np.arange(1, frames + 1)
        self.height = float(heights[-1])
        shares = np.zeros((1, frames, len(COMMANDS)))
        shares[..., [one.name for one in COMMANDS].index(self.command)] = 1.0
        failures = {0: "the kite tore"} if self.height > 5 else {}
        return Motion(RATE, {"height": heights[None], "shares": shares}, failures=failures)


def fly_kites(monkeypatch, body):
    """Make a class of bodies steerable."""

    before = body.skeleton

    def skeleton(self, motion, individual):
        if "height" not in motion:
            return before(self, motion, individual)
        heights = motion["height"][individual]
        ends = np.zeros((len(heights), 2, 2, 3))
        ends[..., 2] = heights[:, None, None]
        ends[:, 0, 1, 0] = ends[:, 1, 1, 1] = 0.5
        return Skeleton(ends, ("nose", "wing"), RATE, centre=ends[:, 0, 0])

    for name, value in {
        "commands": lambda self: COMMANDS,
        "controllers": lambda self: dict(CONTROLLERS),
        "steer": lambda self, controllers: Kite(controllers),
        "skeleton": skeleton,
    }.items():
        monkeypatch.setattr(body, name, value)

"""A cart with two wheels that obeys commands, and repeats recorded drives."""

from typing import ClassVar

import numpy as np

from gaitsim.contracts import (
    Channel,
    Command,
    Fitness,
    Motion,
    Organism,
    RealSpace,
    Skeleton,
    Steered,
    option,
)
from gaitsim.errors import GaitsimError

RATE = 50.0
STEP, TURN = 0.1, 0.5  # m/s and rad/s per press
COMMANDS = (
    Command("stop", "space", "stop"),
    Command("faster", "up", "drive faster"),
    Command("slower", "down", "drive slower"),
    Command("left", "left", "turn left"),
    Command("right", "right", "turn right"),
    Command("push", "x", "push the cart"),
)


class Cart(Organism):
    """A cart whose only gene is its largest speed."""

    drive: list[dict[str, float]] = option([], "commands: speed and turn from a time on")
    duration: float = option(2.0, "length of a drive", unit="s", ge=0.02, le=600)
    slippery: bool = option(False, "whether the cart fails when it is driven")

    channels: ClassVar = {
        "place": Channel(("frames", "x y yaw"), "m", "place and heading"),
        "distance": Channel((), "m", "distance from the start"),
    }

    def genome_space(self):
        return RealSpace(np.full(1, 0.0), np.full(1, 1.0), ("largest speed",))

    def starts(self):
        return {"slow": np.array([0.3])}

    def move(self, genomes):
        frames = round(self.duration * RATE)
        places = np.array([self._walk(genes, frames) for genes in genomes])
        failures = dict.fromkeys(range(len(genomes)), "it slips") if self.slippery else {}
        return motion(places, failures)

    def _walk(self, genes, frames):
        cart, events = SteeredCart(genes), list(self.drive)
        for frame in range(frames):
            while events and round(events[0]["at"] * RATE) <= frame:
                event = events.pop(0)
                cart.wish = event["speed"], event["turn"]
            cart.step()
        return cart.places

    def skeleton(self, motion, individual):
        x, y, yaw = motion["place"][individual].T
        ends = np.zeros((len(x), 2, 2, 3))
        for segment, turned in enumerate((yaw, yaw + np.pi / 2)):
            for end, sign in enumerate((-1, 1)):
                ends[:, segment, end, 0] = x + sign * 0.2 * np.cos(turned)
                ends[:, segment, end, 1] = y + sign * 0.2 * np.sin(turned)
        ends[..., 2] = 0.1
        wheels = ends[:, 1].copy()
        wheels[..., 2] = 0.0
        touching = np.ones(wheels.shape[:2], bool)
        ground = np.array([[-1.0, 0.0], [1.0, 0.05]])
        return Skeleton(
            ends, ("body", "axle"), RATE, wheels, touching, ("left", "right"), ground=ground
        )

    def commands(self):
        return COMMANDS

    def controller_names(self):
        return ("gait",)

    def controllers(self):
        return {"gait": self.starts()["slow"]}

    def steer(self, controllers):
        return SteeredCart(controllers["gait"])


class SteeredCart(Steered):
    frame_rate = RATE

    def __init__(self, genes):
        self.limit = float(genes[0])
        self.wish = (0.0, 0.0)
        self.clipped = False
        self.at = np.zeros(3)
        self.places, self.events = [], []

    def give(self, command):
        speed, turn = self.wish
        if command == "stop":
            speed = turn = 0.0
        elif command in ("faster", "slower"):
            speed += STEP if command == "faster" else -STEP
        elif command in ("left", "right"):
            turn += TURN if command == "left" else -TURN
        elif command != "push":
            raise GaitsimError(f"unknown command {command!r}")
        self.clipped = abs(speed) > self.limit
        self.wish = float(np.clip(speed, -self.limit, self.limit)), turn
        at = len(self.places) / RATE
        self.events.append({"at": at, "speed": self.wish[0], "turn": self.wish[1]})

    def step(self):
        speed, turn = self.wish
        yaw = self.at[2]
        self.at = self.at + np.array([speed * np.cos(yaw), speed * np.sin(yaw), turn]) / RATE
        self.places.append(self.at)

    def advance(self, frames):
        for _ in range(frames):
            self.step()
        fallen = {0: "the cart fell off the table"} if self.at[0] > 2.0 else {}
        return motion(np.array(self.places[-frames:])[None], fallen)

    def facts(self):
        return {"wish": f"{self.wish[0]:.2f} m/s", "turn": f"{self.wish[1]:.1f} rad/s"}

    def notice(self):
        return f"The speed is clipped to {self.limit:g} m/s." if self.clipped else ""

    def drive(self):
        return {"drive": list(self.events), "duration": max(len(self.places), 1) / RATE}


def motion(places, failures):
    distance = np.hypot(*places[:, -1, :2].T)
    return Motion(RATE, {"place": places, "distance": distance}, failures=failures)


class Distance(Fitness):
    """Reward the distance from the start."""

    needs: ClassVar = ("distance",)

    def terms(self, motion):
        return {"distance": motion["distance"]}


CART = """
name = "cart"
[evolution]
population = 4
generations = 2
[organism]
plugin = "cart"
[fitness]
plugin = "cart-distance"
[search]
plugin = "cma-es"
"""

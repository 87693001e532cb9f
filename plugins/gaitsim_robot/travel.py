"""The fitness `travel`: distance in a direction, less prices for what a robot should not do."""

import math
from typing import ClassVar

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, option
from gaitsim_robot.anatomy import Floats
from gaitsim_robot.sums import mean, ratio, rms, total


class Travel(Fitness):
    """Metres travelled in the target direction, less prices in metres.

    Prices of what has no length of its own, such as a fall or a radian of yaw, are in body
    lengths, and work is divided by the weight of the body, so that the same weights suit a robot
    of 0.2 m and one of 1.5 m. A weight of 0 switches a term off.
    """

    direction: float = option(
        0.0,
        "target direction from x, to the left: 90 walks sideways to the left, 180 backward",
        unit="°",
        ge=-180,
        le=180,
    )
    target_speed: float = option(
        0.0, "speed up to which distance counts; 0 for as fast as possible", unit="m/s", ge=0
    )
    speed_weight: float = option(
        1.0, "price of each metre beyond what the target speed covers", ge=0
    )
    drift_weight: float = option(
        1.0, "price of a metre of mean distance from the target line", ge=0
    )
    turn_weight: float = option(
        2.0, "price of a radian of root mean square yaw, in body lengths", unit="1/rad", ge=0
    )
    fall_weight: float = option(
        20.0,
        "price of falling at the start, in body lengths; a fall at the end costs half of it",
        ge=0,
    )
    energy_weight: float = option(
        0.1, "price of each metre travelled at a cost of transport of 1", ge=0
    )
    torque_share: float = option(
        0.5, "share of the stall torque beyond which torque has a price", ge=0, le=1
    )
    torque_weight: float = option(
        10.0,
        "price of a root mean square torque beyond that share, in stall torques, in body lengths",
        ge=0,
    )
    rough_frequency: float = option(
        5.0, "frequency above which joints shake rather than walk", unit="Hz", ge=0.5, le=50
    )
    rough_weight: float = option(
        20.0,
        "price of a radian of root mean square joint motion above that, in body lengths",
        unit="1/rad",
        ge=0,
    )
    slip_weight: float = option(0.5, "price of a metre that the stance feet slide", ge=0)

    unit: ClassVar[str] = "m"
    needs: ClassVar[tuple[str, ...]] = (
        "torso",
        "orientation",
        "joint_positions",
        "torque",
        "stall_torque",
        "energy",
        "slip",
        "lasted",
        "weight",
        "length",
    )

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Forward, drift, turn, fall, energy, torque, roughness and slip, all in metres.

        With a target speed there is the term speed, too.
        Without a known stall torque a joint has no price for torque, without gravity a body has
        none for energy, and joints recorded too slowly to show `rough_frequency` none for
        roughness: these terms are then 0.
        """
        torso, length = motion["torso"], motion["length"]
        seconds = (torso.shape[1] - 1) / motion.frame_rate
        distance, aside = self._along(torso)
        goal = self.target_speed * seconds or math.inf
        yaw = motion["orientation"][..., 2]
        prices = {
            "drift": self.drift_weight * mean(np.abs(aside)),
            "turn": self.turn_weight * length * rms(yaw - yaw[:, :1]),
            "fall": self.fall_weight * length * _fallen(motion["lasted"], seconds),
            "energy": self.energy_weight * ratio(motion["energy"][:, -1], motion["weight"]),
            "torque": self.torque_weight * length * self._overload(motion),
            "roughness": self.rough_weight * length * self._roughness(motion),
            "slip": self.slip_weight * total(motion["slip"]),
        }
        if self.target_speed:
            prices["speed"] = self.speed_weight * np.maximum(distance - goal, 0.0)
        return {
            "forward": np.minimum(distance, goal),
            **{name: -price for name, price in prices.items()},
        }

    def _along(self, torso: Array) -> tuple[Floats, Floats]:
        """Return the distance in the target direction, and the way to the left of it by frame.

        Returns:
            (population,) and (population, frames), m.
        """
        # Exact for whole quarter turns, where cos(π/2) is not 0.
        quarters, rest = divmod(self.direction, 90)
        x, y = math.cos(math.radians(rest)), math.sin(math.radians(rest))
        for _ in range(int(quarters) % 4):
            x, y = -y, x
        moved = torso - torso[:, :1]
        distance: Floats = x * moved[:, -1, 0] + y * moved[:, -1, 1]
        return distance, x * moved[..., 1] - y * moved[..., 0]

    def _overload(self, motion: Motion) -> Floats:
        """Root mean square over frames and joints of torque beyond the share, in stall torques."""
        stall = motion["stall_torque"][:, None]
        beyond = ratio(motion["torque"], np.broadcast_to(stall, motion["torque"].shape))
        return rms(np.maximum(beyond - self.torque_share, 0.0))

    def _roughness(self, motion: Motion) -> Floats:
        """Root mean square of the joints' motion above `rough_frequency`, rad.

        A Butterworth high-pass of fourth order, at rest before the first frame.
        """
        if not self.rough_weight or self.rough_frequency >= motion.frame_rate / 2:
            return np.zeros(motion.population)
        from scipy.signal import butter, sosfilt

        angles = motion["joint_positions"]
        sections = butter(4, self.rough_frequency, "highpass", fs=motion.frame_rate, output="sos")
        return rms(sosfilt(sections, angles - angles[:, :1], axis=1))


def _fallen(lasted: Array, seconds: float) -> Floats:
    """From 1 for a fall at the start to 1/2 for one at the end; 0 without a fall."""
    share = np.minimum(lasted / seconds, 1.0)
    # A motion whose end was cut off ends before its fall.
    fallen: Floats = np.where(share < 1.0, 1.0 - share / 2, 0.0)
    return fallen

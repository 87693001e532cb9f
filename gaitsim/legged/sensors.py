"""Sensors of robots: models of inertial measurement units, with values from their data sheets."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, unknown
from gaitsim.legged.conditions import condition_rng
from gaitsim.portable import standard_normal

Floats = NDArray[np.float64]
FEET_AND_JOINTS = ("contacts", "load", "joints")
"""Sensors besides the IMU: contact switches, force sensors of feet, and reported joint angles."""


CALIBRATION = 1.0  # s, standstill before the start, whose mean rates are subtracted
WARMING = 0.1  # K, how much a sensor warms in the first minute, with random steps


@dataclass(frozen=True)
class Imu:
    """An inertial measurement unit whose gyroscope is calibrated at standstill before the start.

    Its heading is the integral of the yaw rate, as magnetometers are unusable beside motors. Roll
    and pitch do not drift, as the accelerometer corrects them.

    Attributes:
        name: name in experiment files.
        gyro_noise: noise density of the gyroscope, °/s/√Hz.
        temperature: change of the gyroscope's bias with temperature, °/s/K.
        scale: standard deviation of the error of the gyroscope's scale, as a share.
        tilt: standard deviation of roll and pitch, °.
        rate: measurements per second, Hz.
        delay: age of a measurement when it is read, s.
        source: source of the values.
    """

    name: str
    gyro_noise: float
    temperature: float
    scale: float
    tilt: float
    rate: float
    delay: float
    source: str

    def draw(self, world: Mapping[str, float], frames: int, interval: float) -> "ImuErrors":
        """Draw the errors in a world; they depend on its seed alone.

        Args:
            world: values of conditions by name, with an optional seed.
            frames: number of control steps.
            interval: duration of a control step, s.
        """
        rng = condition_rng(world, "sensors")
        scale, bias = standard_normal(rng, 1), standard_normal(rng, 3)
        # Errors of one step after another, so that a longer motion begins with the same errors.
        drawn = standard_normal(rng, (frames, 8))
        tilt = self.tilt * drawn[:, :2]
        wander = self.temperature * WARMING / math.sqrt(60 / interval)
        noise = self.gyro_noise / math.sqrt(max(interval, 1 / self.rate))
        rates = self.gyro_noise / math.sqrt(CALIBRATION) * bias
        rates = rates + np.cumsum(wander * drawn[:, 2:5], axis=0)
        rates += noise * drawn[:, 5:]
        yaw = np.cumsum(rates[:, 2:] * interval, axis=0)
        errors = np.concatenate([tilt, yaw, rates], axis=1)
        return ImuErrors(1 + self.scale * float(scale[0]), np.radians(errors))


@dataclass(frozen=True, eq=False)
class ImuErrors:
    """The errors of an IMU in one world, the same for all individuals.

    Attributes:
        scale: factor of yaw and rates.
        errors: errors of roll, pitch, yaw and the three rates in each control step, (frames, 6)
            rad and rad/s.
    """

    scale: float
    errors: Floats

    def measure(self, true: Floats, frame: int) -> Floats:
        """Return roll, pitch, yaw and rates, (population, 6), as measured in a control step."""
        measured = true.copy()
        measured[:, 2:] *= self.scale
        measured += self.errors[min(frame, len(self.errors) - 1)]
        return measured


IMUS: Mapping[str, Imu] = {
    imu.name: imu
    for imu in (
        Imu(
            "mpu6050",
            gyro_noise=0.005,
            temperature=0.16,
            scale=0.01,
            tilt=0.5,
            rate=200.0,
            delay=0.01,
            source="InvenSense, MPU-6000 and MPU-6050 Product Specification 3.4 (2013): noise "
            "0.005 °/s/√Hz, bias ±20 °/s from −40 to 85 °C, scale ±3 %",
        ),
        Imu(
            "bno055",
            gyro_noise=0.014,
            temperature=0.03,
            scale=0.01,
            tilt=0.5,
            rate=100.0,
            delay=0.02,
            source="Bosch Sensortec, BNO055 Data sheet 1.8 (2021): noise 0.014 °/s/√Hz, bias "
            "0.03 °/s/K, scale ±1 %, fusion without magnetometer at 100 Hz",
        ),
        Imu("ideal", 0.0, 0.0, 0.0, 0.0, math.inf, 0.0, "no errors and no delay"),
    )
}
"""Inertial measurement units by name."""


def check_sensors(names: Sequence[str]) -> None:
    """Validate the names of a robot's sensors: at most one IMU, and `FEET_AND_JOINTS`.

    Raises:
        GaitsimError: a name is unknown, or there are two IMUs.
    """
    known = (*IMUS, *FEET_AND_JOINTS)
    for name in names:
        if name not in known:
            raise unknown("sensor", name, known, key="sensors")
    if sum(name in IMUS for name in names) > 1:
        raise GaitsimError(
            f"a robot has one IMU, not {', '.join(name for name in names if name in IMUS)}",
            allowed=f"at most one of {', '.join(IMUS)}",
            key="sensors",
        )


def observed(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the observations that sensors make: see `OBSERVATIONS`."""
    found = ["orientation", "rates"] if any(name in IMUS for name in names) else []
    if "load" in names or "contacts" in names:
        found.append("contacts")
    return (*found, *(name for name in ("load", "joints") if name in names))

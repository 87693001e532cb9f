"""Inertial measurement units: their errors against closed forms."""

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.legged import IMUS, check_sensors, observed
from gaitsim.legged.sensors import CALIBRATION, WARMING

INTERVAL, FRAMES = 0.02, 3000  # a minute


def drawn(name, count=400):
    """Return the errors of many units, (count, FRAMES, 6) ° and °/s, and their scales."""
    units = [IMUS[name].draw({"seed": float(seed)}, FRAMES, INTERVAL) for seed in range(count)]
    return np.degrees([unit.errors for unit in units]), np.array([unit.scale for unit in units])


@pytest.mark.parametrize("name", ["mpu6050", "bno055"])
def test_heading_drifts_as_the_noise_of_a_gyroscope(name):
    imu, (errors, scale) = IMUS[name], drawn(name)
    seconds = FRAMES * INTERVAL
    bias = imu.gyro_noise / np.sqrt(CALIBRATION) * seconds
    white = imu.gyro_noise * np.sqrt(seconds)
    walk = imu.temperature * WARMING / np.sqrt(60) * np.sqrt(seconds**3 / 3)
    expected = np.sqrt(bias**2 + white**2 + walk**2)
    assert errors[:, -1, 2].std() == pytest.approx(expected, rel=0.12)
    assert np.abs(errors[:, -1, 2].mean()) < 0.2 * expected
    assert errors[..., :2].std() == pytest.approx(imu.tilt, rel=0.02)  # does not drift
    assert scale.std() == pytest.approx(imu.scale, rel=0.12)


def test_rates_are_noisy_and_yaw_is_their_integral():
    errors, _ = drawn("mpu6050", 5)
    np.testing.assert_allclose(np.diff(errors[..., 2], axis=1), errors[:, 1:, 5] * INTERVAL)
    assert np.diff(errors[..., 5]).std() == pytest.approx(
        0.005 / np.sqrt(INTERVAL) * 2**0.5, rel=0.05
    )


def test_an_ideal_unit_measures_the_truth():
    truth = np.random.default_rng(0).random((3, 6))
    unit = IMUS["ideal"].draw({}, 5, INTERVAL)
    np.testing.assert_array_equal(unit.measure(truth, 100), truth)


def test_a_scale_error_shows_in_turns():
    unit = IMUS["mpu6050"].draw({"seed": 4.0}, 5, INTERVAL)
    still, turned = (unit.measure(np.full((1, 6), value), 2)[0] for value in (0.0, 6.0))
    np.testing.assert_allclose((turned - still)[2:], 6 * unit.scale)
    np.testing.assert_allclose((turned - still)[:2], 6)


def test_sensors_are_checked():
    assert observed(["bno055", "load"]) == ("orientation", "rates", "contacts", "load")
    assert observed(["contacts"]) == ("contacts",)
    with pytest.raises(GaitsimError, match="mpu6500") as caught:
        check_sensors(["mpu6500"])
    assert "mpu6050" in caught.value.remedy
    with pytest.raises(GaitsimError, match="one IMU, not mpu6050, bno055"):
        check_sensors(["mpu6050", "bno055"])

"""Measures of a fly's flight."""

from collections.abc import Mapping

import numpy as np

from gaitsim.contracts import Array, Measure, Motion
from gaitsim.portable import arccos, norm


def measures(motion: Motion) -> Mapping[str, Measure]:
    """Return altitudes, horizontal distance, tilt and wing beats, as means over the trials."""
    position, rotation = motion["position"], motion["rotation"]
    seconds = (position.shape[1] - 1) / motion.frame_rate
    altitude = motion["altitude"] - motion["altitude"][:, :1]
    x, y = rotation[..., 1], rotation[..., 2]
    tilt = np.degrees(arccos(np.clip(1 - 2 * (x * x + y * y), -1, 1)))
    away = norm(position[..., :2] - position[:, :1, :, :2])
    return {
        "final altitude": Measure(
            altitude[:, -1].mean(axis=1), "m", f"altitude above the start after {seconds:g} s"
        ),
        "mean altitude": Measure(altitude.mean(axis=(1, 2)), "m", "mean altitude above the start"),
        "lowest": Measure(altitude.min(axis=(1, 2)), "m", "lowest altitude above the start"),
        "horizontal distance": Measure(
            away[:, -1].mean(axis=1), "m", "distance from the start at the end"
        ),
        "largest tilt": Measure(
            tilt.max(axis=(1, 2)), "°", "largest angle between the back and the vertical"
        ),
        "wing beats": Measure(
            _beats(motion["wing_angles"][..., 0]) / seconds,
            "Hz",
            "strokes of the left wing per second",
        ),
    }


def _beats(flap: Array) -> Array:
    """Return the strokes of a wing, half its turning points; mean over trials, (population,)."""
    direction = np.sign(np.diff(flap, axis=1))
    turned: Array = (direction[:, 1:] * direction[:, :-1] < 0).sum(axis=1) / 2
    return np.asarray(turned.mean(axis=1))

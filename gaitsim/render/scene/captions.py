"""What is written in a scene: names, time, distance, the markers' meaning."""

import numpy as np

from gaitsim.render.scene.clip import Pose, Take

SMALL = 0.25  # metres: a body that walks centimetres


def step(metres: float) -> str:
    """A grid's step, such as '5 cm'."""
    for unit, size in (("m", 1.0), ("cm", 0.01)):
        if metres >= size * 0.999:
            return f"{metres / size:g} {unit}"
    return f"{metres * 1000:g} mm"


def moment(take: Take, pose: Pose, seconds: float) -> str:
    """Time, distance and, of what flies, altitude, in words of constant width."""
    away = float(np.hypot(*(pose.middle - take.path[0])[:2]))
    return _moment(take, min(seconds, take.seconds), away, float(pose.middle[2]) + take.floor)


def longest_moment(take: Take) -> str:
    """A text about as wide as the widest of `moment`."""
    away = float(np.hypot(*(take.path - take.path[0])[:, :2].T).max())
    altitude = take.path[:, 2] + take.floor
    return _moment(take, take.seconds, away, float(altitude[np.abs(altitude).argmax()]))


def _moment(take: Take, seconds: float, away: float, altitude: float) -> str:
    # Digits are of one width, so nothing jumps as long as the unit stays.
    small = take.anatomy.span < SMALL
    lengths = [away, altitude] if take.flies else [away]
    said = [f"{100 * x:.1f} cm" if small else f"{x:.2f} m" for x in lengths]
    said = [x.replace("-", "−") for x in said]
    words = (f"{name} {x}" for name, x in zip(("distance", "altitude"), said, strict=False))
    return "   ".join([f"{seconds:.2f} s", *words])

"""The motion of flies, from the arrays that the flight records; its measures and skeleton."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Array, Measure, Motion, Skeleton
from gaitsim.plugin.toolkit import arccos, arctan2, matmul, norm
from gaitsim_fly import body


def flight_motion(
    frame_rate: float,
    states: Array,
    angles: Array,
    courses: Array,
    inertia: NDArray[np.float64],
    failures: Mapping[int, str],
    **extra: Array,
) -> Motion:
    """Return the motion of a population.

    Args:
        frame_rate: frames per second, Hz.
        states: states, (population, frames, trials, STATE); see `gaitsim_fly.flight`.
        angles: wing angles, (population, frames, trials, 6) rad.
        courses: courses of the trials, (frames, trials, COURSE); see `gaitsim_fly.course`.
        inertia: moments of inertia, (3,) kg·m².
        failures: reasons why flights failed, by individual.
        extra: additional channels by name.
    """
    from gaitsim_fly import course, flight

    position = states[..., flight.POSITION : flight.POSITION + 3]
    rotation = states[..., flight.ROTATION : flight.ROTATION + 4]

    def angular_velocity() -> dict[str, Array]:
        turn = body.rotation(rotation)[..., :3, :3]
        momentum = states[..., flight.MOMENTUM : flight.MOMENTUM + 3]
        spin = matmul(momentum[..., None, :], turn)[..., 0, :] / inertia
        return {"angular_velocity": matmul(turn, spin[..., None])[..., 0]}

    def followed_course() -> dict[str, Array]:
        heading = 2 * arctan2(courses[..., course.HALF_SIN], courses[..., course.HALF_COS])
        path = np.concatenate([courses[..., : course.Z + 1], heading[..., None]], axis=-1)
        return {"course": np.broadcast_to(path, (len(states), *path.shape))}

    return Motion(
        frame_rate,
        {
            "position": position,
            "altitude": position[..., 2],
            "rotation": rotation,
            "velocity": states[..., flight.VELOCITY : flight.VELOCITY + 3],
            "wing_angles": angles,
            **extra,
        },
        {("angular_velocity",): angular_velocity, ("course",): followed_course},
        failures=dict(failures),
    )


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


def skeleton(
    motion: Motion, individual: int, size: tuple[float, float, float], span: float, chord: float
) -> Skeleton:
    """Return body and wings in the world frame, in the first trial.

    Args:
        motion: motion of the population.
        individual: index of the individual to draw.
        size: length, width and height of the body, m.
        span: span of a wing, m.
        chord: chord of a wing, m.
    """
    position, rotation, angles = (
        motion[name][individual, :, 0] for name in ("position", "rotation", "wing_angles")
    )
    pose = matmul(body.translation(position), body.rotation(rotation))  # M = T · R
    edges = body.cuboid(*size)
    parts = [body.transform(pose, np.broadcast_to(edges.reshape(-1, 3), (len(pose), 24, 3)))]
    for side, own in ((1, angles[:, :3]), (-1, angles[:, 3:])):
        corners = body.wing_points(side, span, chord)
        outline = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1).reshape(-1, 3)
        hinged = matmul(pose, body.wing_matrix(own, side, size[1] / 2))
        parts.append(body.transform(hinged, np.broadcast_to(outline, (len(pose), 6, 3))))
    segments = np.concatenate(parts, axis=1).reshape(len(pose), -1, 2, 3)
    names = [f"body edge {number}" for number in range(1, 13)]
    names += [
        f"{side} wing {edge}"
        for side in ("left", "right")
        for edge in ("leading edge", "far edge", "trailing edge")
    ]
    return Skeleton(segments, tuple(names), motion.frame_rate, centre=position)

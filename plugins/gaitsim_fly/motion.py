"""The motion of flies, computed from the arrays that the compiled flight records."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Motion
from gaitsim.portable import arctan2, matmul
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

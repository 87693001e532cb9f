"""The course that a fly follows: a point and a heading that move on command; compiled code.

The inputs of a network are the fly's position, attitude, velocity and spin relative to its course,
in the frame of the course's heading. A controller that holds the fly at a fixed point therefore
receives familiar inputs on a moving course, as distances and turns do not accumulate in them.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gaitsim.plugin.toolkit import compiled, cos, sin
from gaitsim_fly.flight import _cos, _sin

# Rows of a course: its point, m; cosine and sine of half its heading, as in a quaternion's w and z;
# its speed along its heading and upwards, m/s; its turn rate to the left, rad/s.
X, Y, Z, HALF_COS, HALF_SIN, SPEED, CLIMB, TURN, COURSE = range(9)


@compiled.part
def heading_of(half_cos: Any, half_sin: Any) -> Any:
    """Return the cosine and sine of a heading, given those of half the heading."""
    return half_cos * half_cos - half_sin * half_sin, 2.0 * half_cos * half_sin


@njit(cache=True, error_model="numpy")
def advance(course: NDArray[np.float64], seconds: float) -> None:
    """Advance a course, (COURSE,), in place: move it, then rotate it by less than half a turn."""
    ahead_x, ahead_y = heading_of(course[HALF_COS], course[HALF_SIN])
    ahead = course[SPEED] * seconds
    course[X] += ahead * ahead_x
    course[Y] += ahead * ahead_y
    course[Z] += course[CLIMB] * seconds
    quarter = 0.5 * course[TURN] * seconds
    c, s = _cos(quarter), _sin(quarter)
    w = c * course[HALF_COS] - s * course[HALF_SIN]
    z = c * course[HALF_SIN] + s * course[HALF_COS]
    scale = 1.0 / np.sqrt(w * w + z * z)
    course[HALF_COS], course[HALF_SIN] = w * scale, z * scale


@njit(cache=True, error_model="numpy")
def paths(
    starts: NDArray[np.float64], speeds: NDArray[np.float64], seconds: float
) -> NDArray[np.float64]:
    """Return courses over time, (trials, frames, COURSE).

    Args:
        starts: courses in the first frame, (trials, COURSE).
        speeds: speeds forward and upwards, m/s, and turn to the left, rad/s, in each frame,
            (trials, frames, 3).
        seconds: time between frames, s.
    """
    trials, frames, _ = speeds.shape
    path = np.empty((trials, frames, COURSE))
    for trial in range(trials):
        course = starts[trial].copy()
        for frame in range(frames):
            for k in range(3):  # assignments of slices would take 3 s more to compile
                course[SPEED + k] = speeds[trial, frame, k]
            for k in range(COURSE):
                path[trial, frame, k] = course[k]
            advance(course, seconds)
    return path


def alternating_speeds(
    own: NDArray[np.float64],
    others: NDArray[np.float64],
    shape: tuple[int, int],
    mean: float,
    seed: int,
) -> NDArray[np.float64]:
    """Return the speeds of a course that alternates with randomly chosen ones, (trials, frames, 3).

    The number of frames between two changes is uniform between 0.5 and 1.5 times its mean.

    Args:
        own: speeds of the main course, with which each trial starts, (3,).
        others: speeds of the courses that alternate with it, (courses, 3).
        shape: numbers of trials and frames.
        mean: mean number of frames between two changes.
        seed: seed of the draws.
    """
    speeds = np.empty((*shape, 3))
    for trial in range(shape[0]):
        rng = np.random.default_rng([seed, 2, trial])
        frame, drawn = 0, False
        while frame < shape[1]:
            end = frame + max(1, round(mean * (0.5 + rng.random())))
            speeds[trial, frame:end] = others[rng.integers(len(others))] if drawn else own
            frame, drawn = end, not drawn
    return speeds


def initial_courses(
    headings: NDArray[np.float64], speeds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return courses that start at the origin, (trials, COURSE).

    Args:
        headings: headings of the trials, (trials,) rad.
        speeds: speeds forward and upwards, m/s, and turn to the left, rad/s, (3,).
    """
    courses = np.zeros((len(headings), COURSE))
    courses[:, HALF_COS], courses[:, HALF_SIN] = cos(headings / 2), sin(headings / 2)
    courses[:, SPEED:] = speeds
    return courses

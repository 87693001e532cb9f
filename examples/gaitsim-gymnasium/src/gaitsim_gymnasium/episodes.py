"""Episodes of a population in lock step."""

import math
from typing import Any

import numpy as np

from gaitsim.plugin import Array, GaitsimError, Motion
from gaitsim_gymnasium.environments import Limits, bodies_of, environments, places


class Failure(Exception):
    """An environment raised an error, or returned what it must not."""


def reset(robot: Any, env: str, limits: Limits, seed: int | None = None) -> Array:
    """Start an episode; return the first observation, (observations,).

    Raises:
        GaitsimError: the environment failed; no individual is to blame.
    """
    try:
        return _observation(robot.reset(seed=seed)[0], limits)
    except Exception as error:  # whatever code the environment runs
        raise GaitsimError(
            f"the environment {env!r} cannot start an episode: {type(error).__name__}: {error}",
            key="env",
            remedy="try it in Python: gymnasium.make(…).reset()",
        ) from None


def advance(robot: Any, action: Array, limits: Limits) -> tuple[Array, float, bool]:
    """Take a step; return the observation, the reward, and whether the episode has ended.

    Raises:
        Failure: the environment raised an error, or returned NaN or too few numbers.
    """
    try:
        seen, reward, terminated, truncated, _ = robot.step(limits.shaped(action))
        reward, ended = float(reward), bool(terminated or truncated)
    except Exception as error:  # whatever code the environment runs
        raise Failure(f"failed with {type(error).__name__}: {error}") from error
    if not math.isfinite(reward):
        raise Failure("returned a reward that is not finite")
    return _observation(seen, limits), reward, ended


def _observation(found: Any, limits: Limits) -> Array:
    seen = np.ravel(found).astype(np.float64)
    if len(seen) != limits.observations:
        raise Failure(f"returned {len(seen)} observations instead of {limits.observations}")
    if not np.isfinite(seen).all():
        raise Failure("returned an observation that is not finite")
    return seen


class Episodes:
    """Episodes of all individuals, which start from the same seed.

    Args:
        env: id of the environment.
        limits: limits of the environment.
        count: number of individuals.
        seed: seed of the episodes.

    Attributes:
        robots: the environment of each individual.
        step: number of steps that were taken.
        active: individuals whose episodes continue, (active,); replaced when one ends.
    """

    def __init__(self, env: str, limits: Limits, count: int, seed: int) -> None:
        self.env, self.limits = env, limits
        self.robots = environments(env, count)
        self.step = 0
        self.active = np.arange(count)
        frames = limits.steps + 1
        self._seen = np.zeros((count, frames, limits.observations))
        self._actions = np.zeros((count, frames, limits.actions))
        self._rewards = np.zeros((count, frames))
        self._bodies = np.zeros((count, frames, len(bodies_of(env)[0]), 3))
        self._lasted = np.zeros(count)
        self._failures: dict[int, str] = {}
        for row, robot in enumerate(self.robots):
            self._seen[row, 0] = reset(robot, env, limits, seed)
            self._bodies[row, 0] = places(env, robot)

    @property
    def observations(self) -> Array:
        """The last observation of each active individual, (active, observations)."""
        return np.asarray(self._seen[self.active, self.step])

    def advance(self, actions: Array) -> None:
        """Take a step with the action of each active individual, (active, actions)."""
        self.step += 1
        self._actions[self.active, self.step] = actions
        ended = np.full(len(self.active), self.step == self.limits.steps)
        for at, (row, action) in enumerate(zip(self.active, actions, strict=True)):
            ended[at] |= self._advance(int(row), action)
        rows = self.active[ended]
        if len(rows):
            self._lasted[rows] = self.step
            for channel in (self._seen, self._bodies):
                channel[rows, self.step :] = channel[rows, self.step, None]
            self.active = self.active[~ended]

    def _advance(self, row: int, action: Array) -> bool:
        """Take a step with one individual; return whether its episode has ended."""
        robot, step = self.robots[row], self.step
        try:
            seen, self._rewards[row, step], ended = advance(robot, action, self.limits)
        except Failure as failure:
            self._failures[row] = f"{self.env} {failure!s:.200} in step {step}"
            seen, ended = self._seen[row, step - 1], True
        self._seen[row, step] = seen
        self._bodies[row, step] = places(self.env, robot)
        return ended

    def motion(self) -> Motion:
        """Return the motion of all individuals."""
        channels = {
            "observation": self._seen,
            "action": self._actions,
            "reward": self._rewards,
            "return": self._rewards.sum(axis=1),
            "lasted": self._lasted / self.limits.frame_rate,
            "bodies": np.nan_to_num(self._bodies),
        }
        return Motion(self.limits.frame_rate, channels, failures=self._failures)

"""Environments by their ids: their sizes, their joints, and as many of them as are needed."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import gymnasium
import mujoco
import numpy as np

from gaitsim.plugin import Array, GaitsimError

_NAME = re.compile(r"(?:[\w-]+/)?[\w-]+-v\d+", re.ASCII)


def check_name(env: str) -> None:
    """Check the id of an environment; 'module:Name-v0' would import any module."""
    if not _NAME.fullmatch(env):
        raise GaitsimError(
            f"invalid id of an environment: {env!r:.80}",
            key="env",
            allowed="the id of an installed environment, such as Swimmer-v5 or package/Name-v0",
        )


def create(env: str, **options: Any) -> Any:
    """Return a new environment.

    Raises:
        GaitsimError: it is unknown, its package is missing, or it cannot be created.
    """
    check_name(env)
    try:
        with _quiet():
            return gymnasium.make(env, disable_env_checker=True, **options)
    except gymnasium.error.DependencyNotInstalled as error:
        raise GaitsimError(
            f"the environment {env!r} needs a package that is not installed: {error}",
            key="env",
            remedy="install what the message names; a different robot needs another package",
        ) from None
    except gymnasium.error.Error as error:
        raise GaitsimError(
            f"there is no environment {env!r}: {error!s:.200}",
            key="env",
            allowed="an environment in the list of python -c 'import gymnasium as g; "
            "g.pprint_registry()'",
            remedy="install the package that provides it",
        ) from None
    except Exception as error:
        raise GaitsimError(
            f"the environment {env!r} cannot be created: {type(error).__name__}: {error}",
            key="env",
            remedy="try it in Python: gymnasium.make(…)",
        ) from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep MuJoCo from printing a warning about each file of an environment, and logging it."""
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)


_pool: dict[str, list[Any]] = {}


def environments(env: str, count: int) -> list[Any]:
    """Return environments that this process keeps."""
    pool = _pool.setdefault(env, [])
    pool += [create(env) for _ in range(count - len(pool))]
    return pool[:count]


@dataclass(frozen=True, eq=False)
class Limits:
    """Sizes and bounds of an environment.

    Attributes:
        observations: number of values in an observation.
        low: lowest value of each action, (actions,).
        high: highest value of each action, (actions,).
        shape: shape of an action.
        dtype: data type of an action.
        steps: number of steps of an episode.
        frame_rate: steps per second, Hz.
    """

    observations: int
    low: Array
    high: Array
    shape: tuple[int, ...]
    dtype: Any
    steps: int
    frame_rate: float

    @property
    def actions(self) -> int:
        """Number of values in an action."""
        return len(self.low)

    @property
    def middle(self) -> Array:
        """Middle of the range of each action, (actions,)."""
        return np.asarray((self.low + self.high) / 2)

    @property
    def half(self) -> Array:
        """Half of the range of each action, (actions,)."""
        return np.asarray((self.high - self.low) / 2)

    def clip(self, actions: Array) -> Array:
        """Return actions within their bounds."""
        return np.clip(actions, self.low, self.high)

    def shaped(self, action: Array) -> Array:
        """Return an action, (actions,), as the environment takes it."""
        return np.asarray(action, self.dtype).reshape(self.shape)


@cache
def action_limits(env: str, steps: int | None) -> Limits:
    """Return the limits of an environment.

    Raises:
        GaitsimError: it cannot be created, or its spaces are not boxes.
    """
    [robot] = environments(env, 1)
    spaces = {"observation": robot.observation_space, "action": robot.action_space}
    for name, space in spaces.items():
        bounded = name == "observation" or getattr(space, "is_bounded", lambda: False)()
        if not isinstance(space, gymnasium.spaces.Box) or not bounded:
            raise GaitsimError(
                f"the {name} space of {env!r} is {space!s:.80}",
                key="env",
                allowed="an environment with a Box of observations and a bounded Box of actions, "
                "such as Swimmer-v5 or Pendulum-v1",
            )
    longest = steps or (robot.spec.max_episode_steps if robot.spec else None)
    if not longest:
        raise GaitsimError(
            f"the episodes of {env!r} have no end",
            key="steps",
            allowed="a number of steps",
            remedy="--set organism.steps=1000",
        )
    box = robot.action_space
    dt = getattr(robot.unwrapped, "dt", None) or 1 / robot.metadata.get("render_fps", 50)
    low, high = (np.ravel(one).astype(np.float64) for one in (box.low, box.high))
    seen = int(np.prod(robot.observation_space.shape))
    return Limits(seen, low, high, box.shape, box.dtype, int(longest), 1 / float(dt))


@dataclass(frozen=True, eq=False)
class Joints:
    """The joints that actions move, in MuJoCo's arrays.

    Attributes:
        qpos: index of the angle that each action moves, (actions,).
        qvel: index of its speed, (actions,).
    """

    qpos: Array
    qvel: Array


@cache
def joints_of(env: str) -> Joints | None:
    """Return the joints of a robot in MuJoCo; None for other environments."""
    [robot] = environments(env, 1)
    model: Any = getattr(robot.unwrapped, "model", None)
    if not hasattr(model, "actuator_trnid"):
        return None
    joints = model.actuator_trnid[:, 0]
    return Joints(model.jnt_qposadr[joints], model.jnt_dofadr[joints])


@cache
def bodies_of(env: str) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Return the names of the bodies of a robot in MuJoCo, and the parent of each, −1 for none.

    The world is not among them. Other environments have one body, at the origin.
    """
    if joints_of(env) is None:
        return ("robot",), (-1,)
    model = environments(env, 1)[0].unwrapped.model
    names = tuple(model.body(n).name or f"body {n}" for n in range(1, model.nbody))
    return names, tuple(int(parent) - 1 for parent in model.body_parentid[1:])


def places(env: str, robot: Any) -> Array:
    """Return the position of each body of a robot, (bodies, 3) m."""
    if joints_of(env) is None:
        return np.zeros((1, 3))
    return np.array(robot.unwrapped.data.xpos[1:])

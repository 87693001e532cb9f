"""Environments of Gymnasium as bodies of gaitsim: open-loop oscillators, and policies that see."""

from collections.abc import Callable, Mapping
from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from gaitsim.plugin import (
    WORLD_HELP,
    Array,
    Channel,
    Condition,
    Fitness,
    GaitsimError,
    Genomes,
    Measure,
    Motion,
    Organism,
    RealSpace,
    Skeleton,
    check_world,
    option,
)
from gaitsim.plugin.toolkit import Network, gene_count, gene_labels
from gaitsim_gymnasium.environments import (
    Limits,
    action_limits,
    bodies_of,
    environments,
    joints_of,
)
from gaitsim_gymnasium.episodes import Episodes, Failure, advance, reset
from gaitsim_gymnasium.oscillators import oscillations, oscillator_space

WARM_UP = 2_000  # steps in which the statistics of observations are measured
SPREAD = 0.1  # deviation of the first weights; large weights only ever saturate the actions


class Environment(Organism):
    """A robot in an environment of Gymnasium, moved by a policy for one episode."""

    env: str = option("HalfCheetah-v5", "id of the environment, such as Swimmer-v5")
    policy: Literal["oscillators", "linear", "network"] = option(
        "oscillators",
        "'oscillators' move each joint by a wave of its own, without observations (Raffin et al. "
        "2024); 'linear' and 'network' compute each action from the observation",
    )
    hidden: int = option(16, "neurons of the hidden layer of 'network'", ge=1, le=1_000)
    steps: int | None = option(
        None,
        "longest episode, in steps",
        unset="that of the environment",
        ge=1,
        le=100_000,
    )
    stiffness: float = option(
        1.0, "gain of the oscillators' position error, in actions per radian", ge=0, le=1e4
    )
    damping: float = option(
        0.05, "gain of the joints' speed against the oscillators", unit="s/rad", ge=0, le=1e4
    )
    mean: tuple[float, ...] = option(
        (), "mean of each observation; by default, it is measured with random actions"
    )
    deviation: tuple[float, ...] = option(
        (), "standard deviation of each observation, measured with the mean"
    )
    world: dict[str, float] = option({}, WORLD_HELP)

    channels: ClassVar[Mapping[str, Channel]] = {
        "observation": Channel(("frames", "observations"), "", "observation of the environment"),
        "action": Channel(("frames", "actions"), "", "action of the policy"),
        "reward": Channel(("frames",), "", "reward of the step before; 0 after the end"),
        "return": Channel((), "", "sum of the rewards"),
        "lasted": Channel((), "s", "time until the end of the episode"),
        "bodies": Channel(
            ("frames", "bodies", ("x", "y", "z")), "m", "position of each body of the robot"
        ),
    }
    dynamic: ClassVar[bool] = True

    @model_validator(mode="after")
    def _measure(self) -> Self:
        """Check the environment; measure the statistics that a policy needs."""
        limits = self.limits
        check_world(self.world, self.conditions())
        if self.policy == "oscillators":
            if joints_of(self.env) is None:
                raise GaitsimError(
                    f"the environment {self.env!r} has no joints that oscillators could move",
                    key="policy",
                    allowed="linear or network; oscillators for robots in MuJoCo",
                )
            return self
        given = len(self.mean), len(self.deviation)
        if given == (0, 0):
            mean, deviation = _statistics(self.env, limits)
            object.__setattr__(self, "mean", mean)  # the model is frozen
            object.__setattr__(self, "deviation", deviation)
        elif given != (limits.observations,) * 2 or min(self.deviation) <= 0:
            raise GaitsimError(
                f"{given[0]} means and {given[1]} deviations",
                key="mean",
                allowed=f"{limits.observations} of each, deviations above 0; or none",
            )
        return self

    @property
    def limits(self) -> Limits:
        """Sizes and bounds of observations and actions."""
        return action_limits(self.env, self.steps)

    def physics_engine(self) -> str:
        """Return 'mujoco' for its robots; other environments are not known to be portable."""
        return "mujoco" if joints_of(self.env) is not None else ""

    def genome_space(self) -> RealSpace:
        """Return the space of the oscillators' parameters, or of the policy's weights."""
        if self.policy == "oscillators":
            return oscillator_space(self.limits.actions)
        sizes = self._sizes
        ones = np.ones(gene_count(sizes))
        return RealSpace(-3 * ones, 3 * ones, gene_labels(sizes), initial_sigma=SPREAD * ones)

    def conditions(self) -> Mapping[str, Condition]:
        """Return noise on the actions; the key `seed` of a world is the seed of the episode."""
        return {
            "action_noise": Condition(
                "",
                0.0,
                0.0,
                0.1,
                0.0,
                1.0,
                "standard deviation of noise on each action, as a share of its range",
            )
        }

    @property
    def _sizes(self) -> tuple[int, ...]:
        limits = self.limits
        hidden = (self.hidden,) if self.policy == "network" else ()
        return (limits.observations, *hidden, limits.actions)

    def move(self, genomes: Genomes) -> Motion:
        """Run an episode for each individual, all in lock step, with the same seed."""
        limits, seed = self.limits, int(self.world.get("seed", 0))
        episodes = Episodes(self.env, limits, len(genomes), seed)
        policy = self._swinging if self.policy == "oscillators" else self._seeing
        act, noise = policy(genomes), self._noise(seed)
        while len(episodes.active):
            episodes.advance(limits.clip(act(episodes) + noise[episodes.step]))
        return episodes.motion()

    def _noise(self, seed: int) -> Array:
        """Return the noise on all actions in each step, (steps, actions)."""
        limits = self.limits
        share = self.world.get("action_noise", 0.0)
        if not share:
            return np.zeros((limits.steps, limits.actions))
        shape = limits.steps + 1, limits.actions  # the first frame has no action
        drawn = np.random.default_rng(seed).standard_normal(shape)[1:]
        return share * (limits.high - limits.low) * drawn

    def _swinging(self, genomes: Genomes) -> Callable[[Episodes], Array]:
        """Return the actions of oscillators as a function of the episodes, (active, actions)."""
        joints = joints_of(self.env)
        assert joints is not None, "checked by the validator"
        wanted = oscillations(genomes, self.limits)

        def swing(episodes: Episodes) -> Array:
            robots = [episodes.robots[row].unwrapped.data for row in episodes.active]
            angles = np.array([robot.qpos[joints.qpos] for robot in robots])
            speeds = np.array([robot.qvel[joints.qvel] for robot in robots])
            error = wanted[episodes.active, episodes.step] - angles
            return np.asarray(self.stiffness * error - self.damping * speeds)

        return swing

    def _seeing(self, genomes: Genomes) -> Callable[[Episodes], Array]:
        """Return the actions of networks as a function of the episodes, (active, actions)."""
        mean, deviation = np.array(self.mean), np.array(self.deviation)
        middle, half = self.limits.middle, self.limits.half
        output = "tanh" if self.policy == "network" else "linear"
        rows, network = None, Network.from_genes(self._sizes, genomes, output=output)

        def see(episodes: Episodes) -> Array:
            nonlocal rows, network
            if rows is not episodes.active:
                rows = episodes.active
                network = Network.from_genes(self._sizes, genomes[rows], output=output)
            inputs = (episodes.observations - mean) / deviation
            return middle + network.activate(inputs[..., None])[..., 0] * half

        return see

    def measures(self, motion: Motion) -> Mapping[str, Measure]:
        """Return the return, the duration and, for robots in MuJoCo, the distance forward."""
        found = {
            "return": Measure(motion["return"], "", "sum of the rewards"),
            "duration": Measure(motion["lasted"], "s", "time until the end of the episode"),
        }
        if joints_of(self.env) is not None:
            way = motion["bodies"][:, -1, 0, 0] - motion["bodies"][:, 0, 0, 0]
            found["forward"] = Measure(way, "m", "distance of the first body along x")
        return found

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Return a line from each body of the robot to its parent; a post without bodies."""
        names, parents = bodies_of(self.env)
        bodies = motion["bodies"][individual]
        lines = [(child, parent) for child, parent in enumerate(parents) if parent >= 0]
        if not lines:
            post = np.tile([[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]], (len(bodies), 1, 1, 1))
            return Skeleton(post, ("post",), motion.frame_rate)
        segments = np.stack([bodies[:, [*pair]] for pair in lines], axis=1)
        segment_names = tuple(names[child] for child, _ in lines)
        return Skeleton(segments, segment_names, motion.frame_rate, centre=bodies[:, 0])


def _statistics(env: str, limits: Limits) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return mean and standard deviation of observations with random actions.

    Mania, Guy and Recht 2018, "Simple random search provides a competitive approach to
    reinforcement learning", normalise observations by running statistics of all policies. Here
    they stay the same, as a score must depend on the genome alone.
    """
    [robot] = environments(env, 1)
    rng = np.random.default_rng(0)
    rows = [reset(robot, env, limits, seed=0)]
    for _ in range(WARM_UP):
        action = limits.low + (limits.high - limits.low) * rng.random(limits.actions)
        try:
            seen, _, ended = advance(robot, action, limits)
        except Failure:
            ended = True
        rows.append(reset(robot, env, limits) if ended else seen)
    found = np.array(rows)
    deviation = np.maximum(found.std(axis=0), 1e-3)
    return tuple(found.mean(axis=0).tolist()), tuple(deviation.tolist())


class Return(Fitness):
    """The return: the sum of the rewards of an episode."""

    needs: ClassVar[tuple[str, ...]] = ("return",)

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the return, (population,)."""
        return {"return": motion["return"]}

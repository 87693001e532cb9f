"""Tests of the package: its contract, its policies, and environments that fail."""

import subprocess
import sys
import time
from typing import ClassVar

import gymnasium
import numpy as np
import pytest
from gaitsim_gymnasium import Environment
from gaitsim_gymnasium.environments import action_limits
from gaitsim_gymnasium.oscillators import oscillations
from imageio.v3 import imiter

import gaitsim as gs
from gaitsim import evaluate, load_experiment
from gaitsim.errors import GaitsimError


class Broken(gymnasium.Env):
    """An environment that fails once its action is large, or in every episode."""

    observation_space = gymnasium.spaces.Box(-1, 1, (2,))
    action_space = gymnasium.spaces.Box(-1, 1, (1,))
    metadata: ClassVar = {"render_fps": 10}

    def __init__(self, how):
        self.how = how

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        if self.how == "unready":
            raise OSError("the simulator does not answer")
        return self.np_random.random(2), {}

    def step(self, action):
        reward = float(action[0])
        if reward > 0.5:
            if self.how == "raises":
                raise ZeroDivisionError("the engine has stopped")
            if self.how == "nan":
                reward = float("nan")
        seen = np.zeros(3 if self.how == "grows" else 2)
        return seen, reward, False, False, {}


for name in ("raises", "nan", "grows", "unready"):
    gymnasium.register(f"Broken{name}-v0", lambda name=name: Broken(name), max_episode_steps=20)


@pytest.mark.parametrize("policy", ["oscillators", "linear", "network"])
def test_the_return_is_that_of_the_same_actions_in_gymnasium(policy):
    body = Environment(env="Swimmer-v5", policy=policy, steps=60, world={"seed": 3})
    genomes = body.genome_space().random(3, np.random.default_rng(1))
    motion = body.move(genomes)
    robot = gymnasium.make("Swimmer-v5")
    for row in range(3):
        robot.reset(seed=3)
        actions = motion["action"][row, 1:].astype(np.float32)
        expected = sum(robot.step(action)[1] for action in actions)
        assert motion["return"][row] == pytest.approx(expected, rel=1e-12)
    assert np.array_equal(body.move(genomes[1:2])["return"], motion["return"][1:2])


def test_oscillators_swing_as_long_as_their_frequencies_say():
    limits = action_limits("Swimmer-v5", 1000)
    genome = np.array([[0.5, 0.2, 1.0, 0.0, 0.0, 0.5, np.pi / 2, 0.25]])
    first, second = oscillations(genome, limits)[0].T
    # Half a cycle at 0.5 Hz takes 1 s, half a cycle at 0.2 Hz 2.5 s.
    assert np.mean(first > 0) == pytest.approx(1 / 3.5, abs=0.03)
    assert (second.min(), second.max()) == pytest.approx((-0.25, 0.75), abs=0.01)


def test_worlds_are_seeds_of_episodes():
    body = Environment(env="Hopper-v5", policy="linear", steps=40)
    genomes = body.genome_space().random(2, np.random.default_rng(0))
    starts = [
        body.model_copy(update={"world": {"seed": seed}}).move(genomes)["observation"][:, 0]
        for seed in (1.0, 2.0)
    ]
    assert np.array_equal(*starts[0])
    assert not np.array_equal(*starts)


def test_statistics_are_part_of_the_experiment():
    experiment = load_experiment("gymnasium-linear", {"organism.steps": 20})
    again = load_experiment(
        "gymnasium-linear", {"organism.mean": [0.0] * 8, "organism.deviation": [1.0] * 8}
    )
    assert len(experiment.organism.mean) == 8
    assert again.organism.mean == (0.0,) * 8
    assert str(experiment.organism.mean[0]) in experiment.to_toml()


@pytest.mark.parametrize(
    ("how", "reason", "other"),
    [
        ("raises", "engine has stopped in step 1", 2.0),
        ("nan", "not finite in step 1", 2.0),
        ("grows", "returned 3 observations instead of 2 in step 1", -np.inf),
    ],
)
def test_an_environment_that_fails_fails_the_individual(how, reason, other):
    body = {"organism.env": f"Broken{how}-v0", "worlds.cases": []}
    experiment = load_experiment("gymnasium-linear", body)
    genomes = np.array([[0.0, 0.0, 0.9], [0.0, 0.0, 0.1]])
    found = evaluate(experiment, genomes)
    assert found.scores[0] == -np.inf
    assert reason in found.reasons[0]
    assert found.scores[1] == pytest.approx(other)


def test_an_environment_that_cannot_start_is_an_error():
    with pytest.raises(GaitsimError, match="cannot start an episode: OSError: the simulator"):
        Environment(env="Brokenunready-v0", policy="linear")


@pytest.mark.parametrize(
    ("preset", "env"), [("gymnasium", "Hopper-v5"), ("gymnasium-linear", "Pendulum-v1")]
)
def test_a_killed_run_continues_to_the_bits_of_one_that_was_not(preset, env, tmp_path):
    generations, options = 30, {"organism.env": env, "organism.steps": 60}
    sets = [one for name, value in options.items() for one in ("--set", f"{name}={value}")]
    size = ["--generations", str(generations), "--population", "8", "--workers", "2", "--json"]
    command = [sys.executable, "-m", "gaitsim", "run", preset, *sets, *size, "--out"]
    with subprocess.Popen([*command, tmp_path / "killed"], stdout=subprocess.PIPE) as process:
        for _ in range(3):
            process.stdout.readline()
        time.sleep(0.05)  # in the middle of a generation
        process.kill()
    killed = gs.load(tmp_path / "killed")
    assert 0 < killed.generation < generations
    size = {"generations": generations, "population": 8, "workers": 1}
    whole = gs.evolve(preset, **size, set=options, out=tmp_path / "whole")
    for search in (killed.resume(workers=1), whole):
        for _ in search:
            pass
    found, expected = gs.load(killed.path), gs.load(tmp_path / "whole")
    assert found.fingerprint() == expected.fingerprint()
    assert np.array_equal(found.champion.genome, expected.champion.genome)


def test_a_video_has_a_picture_for_each_step(tmp_path):
    size = {"generations": 1, "population": 4, "workers": 1}
    options = {"organism.env": "Swimmer-v5"}
    [_] = gs.evolve("gymnasium", **size, set=options, out=tmp_path / "run")
    run, path = gs.load(tmp_path / "run"), tmp_path / "swimmer.mp4"
    try:
        run.export(path, "gymnasium-video", seconds=0.12)
    except GaitsimError as error:
        if "cannot draw" not in str(error):
            raise
        pytest.skip(str(error))
    pictures = [*imiter(path, plugin="pyav")]
    assert len(pictures) == 4
    assert not np.array_equal(pictures[0], pictures[-1])
    with pytest.raises(GaitsimError, match="unknown extension"):
        run.export(tmp_path / "swimmer.gif", "gymnasium-video")


@pytest.mark.parametrize(
    ("env", "message"),
    [
        ("Nothing-v0", "there is no environment"),
        ("os:Nothing-v0", "invalid id"),
        ("CartPole-v1", "the action space"),
        ("Blackjack-v1", "the observation space"),
        ("Pendulum-v1", "no joints that oscillators could move"),
    ],
)
def test_other_environments_are_refused(env, message):
    with pytest.raises(GaitsimError, match=message):
        Environment(env=env)

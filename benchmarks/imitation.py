"""The network that imitates the default spider's champion: training time and distance walked.

The training time is compared with NumPy code that trains on one pair at a time.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from timing import medians, print_figure, print_machine, stopwatch, times

from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.playing import play
from gaitsim.evolution import evolve
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.individual import Individual
from gaitsim.network import Network
from gaitsim_imitation.imitating import TOLERANCE
from gaitsim_imitation.learning import SETTINGS, TrainingSettings, learn, prepare

EPOCHS, SAMPLE = 1000, 3  # epochs of the compiled training, and of the training in NumPy
SEEDS = range(5)
FACTOR = 10  # duration of the free run, as a multiple of the expert's


def champion(experiment: Experiment) -> NDArray[np.float64]:
    """Return the joint angles of the best individual of all generations, (frames, joints)."""
    best, score = None, -np.inf
    with Evaluator(experiment) as evaluator:
        for generation in evolve(experiment, evaluator.evaluate):
            index = int(np.argmax(generation.evaluation.scores))
            if generation.evaluation.scores[index] > score:
                score = generation.evaluation.scores[index]
                best = generation.genomes[index : index + 1].copy()
    assert best is not None
    angles: NDArray[np.float64] = experiment.organism.move(best)["joint_angles"][0]
    return angles.astype(np.float64)


def train_in_numpy(expert: NDArray[np.float64], epochs: int) -> None:
    """Train with `Network.gradients`, one pair at a time."""
    rng = np.random.default_rng(0)
    joints = expert.shape[1]
    network = Network.random((joints, 48, joints), rng, "leaky-relu")
    genes, sizes = network.genes.copy(), network.sizes
    for _ in range(epochs):
        for pair in rng.permutation(len(expert) - 1):
            network = Network.from_genes(sizes, genes, "leaky-relu")
            frame, following = expert[pair : pair + 1].T, expert[pair + 1 : pair + 2].T
            genes -= 0.008 * joints / 2 * network.gradients(frame, following)[1]


def compile_seconds() -> float:
    """Return the seconds of compilation in the first training, with an empty cache."""
    code = (
        "import time; from gaitsim_imitation.learning import prepare; "
        "s = time.perf_counter(); prepare(); print(time.perf_counter() - s)"
    )
    with tempfile.TemporaryDirectory() as cache:
        done = subprocess.run(
            [sys.executable, "-c", code],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, "NUMBA_CACHE_DIR": cache},
        )
    return float(done.stdout)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=0, help="seed of the spider's run")
    experiment = load_experiment("spider", {"seed": parser.parse_args().seed})
    print_machine()
    expert = champion(experiment)
    print_figure("compiling, first training only", f"{compile_seconds():.1f} s")
    prepare()
    seconds, slow = medians(
        lambda: learn(expert, TrainingSettings(epochs=EPOCHS // 10)),
        lambda: train_in_numpy(expert, SAMPLE),
        repeats=1,
    )
    seconds, slow = seconds * 10, slow * EPOCHS / SAMPLE
    pairs = len(expert) - 1
    print_figure(f"training, {pairs} pairs × {EPOCHS:,} epochs", f"{seconds:.2f} s", "at most 5 s")
    print_figure(
        f"- in NumPy, {SAMPLE} epochs scaled", f"{slow:.0f} s", f"{times(slow / seconds)} as long"
    )
    for name, settings in SETTINGS.items():
        print()
        whole = stopwatch(lambda settings=settings: learn(expert, settings))  # type: ignore[misc]
        print_figure(f"settings {name}: {settings.epochs:,} epochs", f"{whole:.1f} s")
        print_walks(experiment, expert, settings)


def print_walks(
    experiment: Experiment, expert: NDArray[np.float64], settings: TrainingSettings
) -> None:
    """Print how far the free-running network walks, relative to its expert, at first and later."""
    frames = len(expert)

    def play_angles(angles: NDArray[np.float64]) -> Individual:
        return Individual.of_motion(experiment, play(experiment, angles[None]))

    walked = play_angles(expert)
    whole = walked.measures["forward"]
    for seed in SEEDS:
        imitator, _ = learn(expert, replace(settings, seed=seed))
        commanded = imitator.free_run(expert[0], FACTOR * frames)
        first, last = play_angles(commanded[:frames]), play_angles(commanded[-frames:])
        assert first.joint_angles is not None
        beyond = np.count_nonzero(np.abs(first.joint_angles - commanded[:frames]) > TOLERANCE)
        forward, late = (gait.measures["forward"] / whole for gait in (first, last))
        print_figure(
            f"- seed {seed}: distance kept; {FACTOR - 1} durations later",
            f"{forward:.1%} {late:.1%}",
            f"score {first.score:.2f} of {walked.score:.2f}, "
            f"{beyond} of {commanded[:frames].size} limited",
        )


if __name__ == "__main__":
    main()

"""One generation of the presets spider-genetic, 200 × 300 frames, and spider-recurrence, 100 × 300.

Both are compared with the machine's peak arithmetic speed. spider-recurrence is also compared with
the published MATLAB run of the same scheme, with the same kernels called for one spider at a time,
and with a NumPy version that moves and scores one spider at a time.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from one_by_one import OneByOne
from timing import (
    medians,
    milliseconds,
    print_budget,
    print_figure,
    print_machine,
    stopwatch,
    times,
)

from gaitsim.contracts import Genomes, Results
from gaitsim.evaluation import Evaluation, Evaluator, evaluate
from gaitsim.evolution import ask, first_population
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.storage.creation import create_run
from gaitsim.storage.writer import RunWriter

PUBLISHED = 1.5 * 3600  # seconds for 1,000 generations in MATLAB on the author's machine
GENERATIONS, SAMPLE = 1000, 150

# Budgets: seconds of compiling; a whole run as a multiple of its evaluations, for the spider and
# for the quicker spider-recurrence; the gain by all cores, as a share of a bare kernel's gain
# by them; never slower with all cores; and an evaluation compared with the time of its arithmetic
# at the machine's peak speed.
COMPILING, RUN, QUICK_RUN, WORKERS, SLOWER, BOUND = 4.0, 1.25, 1.8, 0.95, 1.05, 2.5
RECURRENCE_BOUND = 4.0
DESIGNS = 1.1  # evaluation of spiders with bodies of their own, compared with one body

# float32 operations per spider, counted in the kernels' source. Additions, multiplications,
# divisions, roots, comparisons and sign changes count as one, sines and cosines as the operations
# of their polynomials. Selections between two values are not counted.
JOINTS, LEGS, FRAMES = 24, 8, 300
KINEMATICS = 109 * LEGS * FRAMES
RECURRENCE = 7 * JOINTS * FRAMES + KINEMATICS + (17 * LEGS + 8 + 3 * JOINTS) * FRAMES
TRIANGLES, CORNERS = 56 * 24, 8 * (6 * LEGS + 14) + 4 * LEGS  # resting plane, support polygon
INTERVAL = 12 * LEGS + TRIANGLES + 35 + 21 * LEGS + 25 + 29 * LEGS + 30 + CORNERS + 54
DEFAULT = 3 * JOINTS * FRAMES + KINEMATICS + INTERVAL * (FRAMES - 1) + 16 * JOINTS * FRAMES


def compile_seconds(preset: str) -> float:
    """Return the seconds of a preset's first evaluation with an empty cache, in a new process."""
    code = (
        "import time; from gaitsim.experiment import load_experiment; "
        "from gaitsim.evaluation import Evaluator; "
        "from gaitsim.evolution import first_population; "
        f"e = load_experiment('{preset}'); v = Evaluator(e, 1); s = time.perf_counter(); "
        "v.prepare(); v.evaluate(first_population(e)); print(time.perf_counter() - s)"
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


def run_seconds(experiment: Experiment, evaluator: Evaluator) -> tuple[float, float]:
    """Return the seconds of a whole run, recorded on the disk of the working folder.

    The second number is the part of them in which populations were evaluated.
    """
    evaluating = 0.0

    def evaluate(genomes: Genomes, generation: int) -> Evaluation:
        nonlocal evaluating
        start = time.perf_counter()
        found = evaluator.evaluate(genomes, generation)
        evaluating += time.perf_counter() - start
        return found

    with tempfile.TemporaryDirectory(prefix=".benchmark-", dir=Path.cwd()) as folder:
        path = create_run(experiment, Path(folder) / "run")

        def work() -> None:
            with RunWriter.open(path) as writer:
                for _ in writer.evolve(evaluate):
                    pass

        return stopwatch(work), evaluating


def print_run(experiment: Experiment, evaluator: Evaluator, budget: float) -> float:
    """Print the time of a whole run as a multiple of its evaluations; return its seconds."""
    whole, evaluating = min(run_seconds(experiment, evaluator) for _ in range(3))
    number = experiment.evolution.generations
    print_figure(f"a run of {number} generations", f"{whole:.2f} s", "best of three")
    print_budget("- compared with its evaluations", whole / evaluating, budget, times)
    return whole


def peak() -> tuple[float, float]:
    """Return the peak float32 operations per second of all cores together, and the gain by them.

    Measured with Horner's scheme of short polynomials, on numbers in the first-level cache: a load
    and a store for four products and sums in vector instructions, none of which waits for the next
    number's. They are not fused, as portable results exclude that. The second number is how many
    times as much all cores compute as one, which may be little more than 1 for two processors that
    are threads of one core.
    """
    from numba import njit

    @njit(nogil=True, error_model="numpy")
    def horner(values: Any, factor: Any, rounds: int) -> None:
        for _ in range(rounds):
            for n in range(values.size):
                x = values[n]
                y = x
                for _power in range(4):
                    y = y * x + factor
                values[n] = y

    size, rounds = 2048, 8000
    cores = os.cpu_count() or 1
    chunks = [np.full(size, 0.5, np.float32) for _ in range(cores)]

    def work(chunk: Any) -> None:
        horner(chunk, np.float32(0.1), rounds)

    work(chunks[0])
    with ThreadPoolExecutor(cores) as executor:
        works = (lambda: work(chunks[0])), (lambda: [*executor.map(work, chunks)])
        one, every = (min(stopwatch(each) for _ in range(20)) for each in works)
    return cores * size * rounds * 8 / every, cores * one / every


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", action="store_true", help="run 1,000 generations, not 150")
    full = parser.parse_args().full
    print_machine()
    speed, gain = peak()
    print_figure("peak speed of the machine", f"{speed / 1e9:.0f} G/s", "products, sums; cached")
    print_figure("gain by all cores at this speed", times(gain))
    print("\nspider-genetic: 200 spiders, eight terms")
    print_default(speed, gain)
    print("\nspider-recurrence: 100 spiders, seven terms")
    print_recurrence(full, speed)


def print_default(speed: float, gain: float) -> None:
    """Print the evaluation time of the preset spider-genetic, with all cores and with one."""
    experiment = load_experiment("spider-genetic", {"evolution.generations": 300})
    genomes = first_population(experiment)
    print_budget(
        "compiling, first run only", compile_seconds("spider-genetic"), COMPILING, milliseconds
    )
    with Evaluator(experiment) as all_cores, Evaluator(experiment, workers=1) as one_core:
        all_cores.prepare()
        whole, alone = medians(
            lambda: all_cores.evaluate(genomes), lambda: one_core.evaluate(genomes), repeats=20
        )
    rate = f"{len(genomes) / whole:,.0f} spiders per second"
    print_figure("evaluating a generation", milliseconds(whole), rate)
    print_figure("- the same with one worker", milliseconds(alone))
    print_budget("- compared with all cores", alone / whole, WORKERS * gain, times, least=True)
    evolving = load_experiment("spider-genetic", {"organism.evolve": ["femur", "tibia"]})
    own = np.hstack([genomes, np.linspace((0.7, 1.3), (1.3, 0.7), len(genomes))])
    fixed, designs = medians(
        lambda: evaluate(experiment, genomes), lambda: evaluate(evolving, own), repeats=20
    )
    print_budget("- with two dimensions that evolve", designs / fixed, DESIGNS, times)
    print_lower_bound(DEFAULT * len(genomes), speed, whole, BOUND)
    with Evaluator(experiment) as all_cores:
        print_run(experiment, all_cores, RUN)


def print_recurrence(full: bool, speed: float) -> None:
    """Print the evaluation time of spider-recurrence, whole runs, and the alternatives."""
    generations = GENERATIONS if full else SAMPLE
    experiment = load_experiment("spider-recurrence", {"evolution.generations": generations})
    space = experiment.space()
    genomes = first_population(experiment)
    compiling = compile_seconds("spider-recurrence")
    print_budget("compiling, first run only", compiling, COMPILING, milliseconds)

    with Evaluator(experiment) as evaluator:
        evaluator.prepare()
        scores = evaluator.evaluate(genomes).scores
        evaluating, breeding = medians(
            lambda: evaluator.evaluate(genomes),
            lambda: ask(experiment, space, {}, Results(genomes, scores), 2)[0],
            repeats=40,
        )
        whole = print_run(experiment, evaluator, QUICK_RUN)
    thousand = whole * GENERATIONS / generations
    print_figure("evaluating a generation", milliseconds(evaluating))
    print_figure("breeding a generation", milliseconds(breeding))
    print_figure("a generation of the whole run", milliseconds(whole / generations))
    print_figure(
        f"1,000 generations{'' if full else f', scaled from {generations}'}",
        f"{thousand:.2f} s",
        f"published MATLAB run {PUBLISHED:,.0f} s: {times(PUBLISHED / thousand)} as long",
    )

    print_lower_bound(RECURRENCE * len(genomes), speed, evaluating, RECURRENCE_BOUND)
    print_alternatives(experiment, genomes)


def print_alternatives(experiment: Experiment, genomes: NDArray[np.float64]) -> None:
    """Print the times of the same work on one core, and of one spider at a time."""
    numpy, few = OneByOne(experiment), genomes[:10]
    with Evaluator(experiment) as all_cores, Evaluator(experiment, workers=1) as one_core:
        whole, alone, single, loop = medians(
            lambda: all_cores.evaluate(genomes),
            lambda: one_core.evaluate(genomes),
            lambda: [evaluate(experiment, genome[None]) for genome in genomes],
            lambda: [numpy.score(genome) for genome in few],
            repeats=4,
        )
        scores = all_cores.evaluate(few).scores
    loop *= len(genomes) / len(few)
    worst = np.abs([numpy.score(genome) for genome in few] - scores).max()
    print_figure("evaluating a generation, in turns with", milliseconds(whole))
    print_budget("- compared with one worker", whole / alone, SLOWER, times)
    for what, seconds in (
        ("- the same with one worker", alone),
        ("- one core, spider by spider, same kernels", single),
        ("- one core, spider by spider, NumPy; 10 scaled to 100", loop),
    ):
        print_figure(what, milliseconds(seconds), f"{times(seconds / whole)} as long")
    print(f"(NumPy's scores differ by {worst:.1g} at most)")


def print_lower_bound(operations: int, speed: float, evaluating: float, budget: float) -> None:
    """Print the minimum time that the arithmetic takes, and the evaluation as a multiple of it."""
    floor = operations / speed
    print_figure("- its arithmetic", f"{operations / 1e6:.0f} M", "float32 operations")
    print_figure("- the resulting lower bound", milliseconds(floor))
    print_budget("- the evaluation, compared with it", evaluating / floor, budget, times)


if __name__ == "__main__":
    main()

"""Searches on the 24 noiseless functions of BBOB, compared with pycma, SciPy and random search.

    python benchmarks/bbob.py --dimensions 2 5 --instances 1 2 3 --searches cma-es pycma
    nice python benchmarks/bbob.py --out bbob.jsonl     # everything, some hours

Each search minimises each function in the box [-5, 5] with 1,000 evaluations per dimension (or
`--budget`), and stops once it reaches the last target. The figure of merit is COCO's area under the
empirical distribution (ECDF) of runtimes: the share of 51 targets, 10² to 10⁻⁸ above the optimum,
that are reached, averaged over the logarithm of the evaluations per dimension from 1 to the budget.
It is 1 if the first evaluation reaches all targets. Searches take turns on each problem, and each
result is saved immediately. If the `--out` file exists, only missing results are computed, so that
an interrupted benchmark continues and `--searches` can add searches. A file is for one budget.

Hansen, Auger, Ros, Mersmann, Tušar, Brockhoff 2021, "COCO: a platform for comparing continuous
optimizers in a black-box setting"; Hansen, Finck, Ros, Auger 2009 for the functions.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import chdir, suppress
from itertools import count, product
from pathlib import Path
from typing import Any

import bbob_table
import cma
import cocoex
import numpy as np
from scipy.optimize import differential_evolution

from gaitsim.contracts import RealSpace
from gaitsim.contracts.search import NO_STARTS, Context, Results, Search

TARGETS = np.logspace(2, -8, 51)
BUDGET = 1_000  # default number of evaluations per dimension
DIMENSIONS, INSTANCES, FUNCTIONS = (2, 5, 10, 20), range(1, 16), range(1, 25)


class Finished(Exception):
    """Raised when all targets are reached or the budget is spent."""


class Trial:
    """One minimisation of a problem, which counts evaluations and records the targets reached.

    Attributes:
        dimension: number of variables.
        seed: whole numbers for a random generator, different for each problem.
        hits: number of evaluations at which each target was reached so far, easiest target first.
    """

    def __init__(self, problem: Any, optimum: float, budget: int) -> None:
        self._problem, self._values = problem, optimum + TARGETS
        self._most = budget * problem.dimension
        self.dimension: int = problem.dimension
        self.seed = [int(part) for part in problem.id_triple]
        self.hits: list[int] = []
        self._evaluations = 0

    def __call__(self, x: np.ndarray) -> float:
        """Evaluate one point, (dimension,).

        Raises:
            Finished: all targets are reached, or the budget is spent.
        """
        value = float(self._problem(x))
        self._evaluations += 1
        while len(self.hits) < len(TARGETS) and value <= self._values[len(self.hits)]:
            self.hits.append(self._evaluations)
        if len(self.hits) == len(TARGETS) or self._evaluations >= self._most:
            raise Finished
        return value

    def start(self, attempt: int = 0) -> np.ndarray:
        """Return a random point in the box: equal for all searches, different for each attempt."""
        return np.random.default_rng([*self.seed, attempt]).uniform(-5, 5, self.dimension)


Minimise = Callable[[Trial], None]
"""Function that evaluates points until `Finished` is raised; returns earlier if it converges."""


def gaitsim_search(
    search: Search, population: Callable[[int], int], *, warm: bool = False
) -> Minimise:
    """Return a function that minimises with a bundled search.

    Args:
        search: search to test.
        population: number of genomes per generation, as a function of the dimension.
        warm: whether to start from the point from which the other programs start.
    """

    def minimise(trial: Trial) -> None:
        size, side = population(trial.dimension), np.full(trial.dimension, 5.0)
        space = RealSpace(-side, side, tuple(map(str, range(trial.dimension))))
        state, last = None, None
        for generation in count(1):
            initial, ask, tell = (
                Context(
                    space,
                    size,
                    generation,
                    np.random.default_rng([*trial.seed, generation, call]),
                    starts=trial.start()[None] if warm else NO_STARTS,
                )
                for call in range(3)
            )
            state = search.initial(initial) if state is None else state
            genomes, state = search.ask(state, last, ask)
            last = Results(genomes, -np.array([trial(genome) for genome in genomes]))
            state = search.tell(state, last, tell)

    return minimise


def pycma_search(*, bipop: bool = False) -> Minimise:
    """Return a function that minimises with pycma's active CMA-ES and its defaults.

    They transform variables at bounds, and restart as IPOP or as BIPOP does.
    """

    def minimise(trial: Trial) -> None:
        attempts = count()
        seed = int(f"{trial.seed[0]}{trial.seed[1]:02}{trial.seed[2]:02}")
        np.random.seed(seed)  # noqa: NPY002  # BIPOP's sizes are drawn from the global generator
        cma.fmin2(
            trial,
            lambda: trial.start(next(attempts)),
            2.0,
            {"bounds": [-5, 5], "seed": seed, "verbose": -9, "verb_log": 0},
            restarts=9,
            incpopsize=2,
            bipop=bipop,
        )

    return minimise


def scipy_search(**options: Any) -> Minimise:
    """Return a function that minimises with SciPy's differential evolution until convergence."""

    def minimise(trial: Trial) -> None:
        rng = np.random.default_rng([*trial.seed, trial._evaluations])
        bounds = [(-5, 5)] * trial.dimension
        differential_evolution(trial, bounds, rng=rng, maxiter=10**9, **options)

    return minimise


def minimise_at_random(trial: Trial) -> None:
    """Evaluate points drawn uniformly from the box."""
    rng = np.random.default_rng(trial.seed)
    while True:
        for x in rng.uniform(-5, 5, (1_000, trial.dimension)):
            trial(x)


def default_population(dimension: int) -> int:
    """Return the default population of CMA-ES: Hansen 2016, table 1."""
    return 4 + int(3 * np.log(dimension))


def searches() -> dict[str, Minimise]:
    """Return the searches to compare, by name."""
    from gaitsim_searches.cma_es import CmaEs
    from gaitsim_searches.differential_evolution import DifferentialEvolution

    return {
        "cma-es": gaitsim_search(CmaEs(start_step=0.2), default_population, warm=True),
        "cma-es, bipop": gaitsim_search(
            CmaEs(start_step=0.2, restarts="bipop"), default_population, warm=True
        ),
        "differential-evolution": gaitsim_search(
            DifferentialEvolution(), lambda dimension: round(6 * np.sqrt(dimension))
        ),
        "pycma": pycma_search(),
        "pycma, bipop": pycma_search(bipop=True),
        # Defaults, except for the final gradient descent with L-BFGS-B.
        "scipy-differential-evolution": scipy_search(polish=False, tol=0),
        # Fewer than the default 15 individuals per dimension, without and with that descent.
        "scipy-small": scipy_search(popsize=5, polish=False),
        "scipy-polish": scipy_search(popsize=5),
        "uniform": minimise_at_random,
    }


def run(trial: Trial, minimise: Minimise) -> None:
    """Minimise until the trial is finished; restart after each convergence."""
    with suppress(Finished):
        while True:
            minimise(trial)


def optimum(problem: Any) -> float:
    """Return the minimum of a problem.

    cocoex writes the coordinates of the minimum to a file in the working folder.
    """
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        problem._best_parameter("print")
        return float(problem(np.loadtxt("._bbob_problem_best_parameter.txt")))


def missing_results(arguments: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """Run all problems without a result in the file, and yield their results."""
    done = {bbob_table.key(row) for row in bbob_table.rows(arguments.out)}
    suite = cocoex.Suite("bbob", "instances: 1-15", "")
    chosen = {name: searches()[name] for name in arguments.searches}
    # Instances outermost, so that an interrupted benchmark compares fewer instances completely.
    for place in product(arguments.instances, arguments.dimensions, arguments.functions):
        instance, dimension, function = place
        for name, minimise in chosen.items():
            if (name, dimension, function, instance) in done:
                continue
            number = (function, dimension, instance)
            best = optimum(suite.get_problem_by_function_dimension_instance(*number))
            problem = suite.get_problem_by_function_dimension_instance(*number)
            trial = Trial(problem, best, arguments.budget)
            start = time.process_time()
            run(trial, minimise)
            yield {
                "search": name,
                "dimension": dimension,
                "function": function,
                "instance": instance,
                "seconds": round(time.process_time() - start, 3),
                "hits": trial.hits,
            }


def save_results(results: Iterable[dict[str, Any]], path: Path) -> None:
    """Append each result to the file as a line, and print the progress."""
    with path.open("a") as file:
        for row in results:
            file.write(json.dumps(row) + "\n")
            file.flush()
            place = f"dimension {row['dimension']}, function {row['function']:2}"
            print(f"\r{place}, instance {row['instance']:2}  {row['search']:32}", end="")
    print("\r" + 79 * " " + "\r", end="")


def main() -> None:
    """Run the missing problems and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dimensions", type=int, nargs="+", default=DIMENSIONS)
    parser.add_argument("--instances", type=int, nargs="+", default=INSTANCES)
    parser.add_argument("--functions", type=int, nargs="+", default=FUNCTIONS)
    parser.add_argument("--searches", nargs="+", choices=searches(), default=list(searches()))
    parser.add_argument("--budget", type=int, default=BUDGET, help="evaluations per dimension")
    parser.add_argument("--out", type=Path, help="file of results, continued if it exists")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        arguments.out = arguments.out or Path(folder) / "bbob.jsonl"
        save_results(missing_results(arguments), arguments.out)
        bbob_table.print_tables(arguments.out, arguments.budget, len(TARGETS))


if __name__ == "__main__":
    main()

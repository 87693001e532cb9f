"""Constrained problems with known optima: CMA-ES with penalties, here and in pycma.

The benchmark prints in how many runs, and after how many evaluations, the best feasible individual
reaches the optimum to a precision of 10⁻⁶, relative to 1 + |optimum|. Both use the same population,
first standard deviation and limit of evaluations; pycma's handler is `ConstrainedFitnessAL`.
Problems g06, g07 and g09: Michalewicz and Schoenauer 1996, "Evolutionary algorithms for constrained
parameter optimization problems".
"""

import warnings
from collections.abc import Callable
from typing import NamedTuple

import cma
import numpy as np
from numpy.typing import NDArray
from timing import print_machine

import gaitsim

SEEDS = range(1, 21)
PRECISION = 1e-6
EVALUATIONS = 10_000
STEP = 0.2  # first standard deviation, as a share of the range of a gene

Values = tuple[float, list[float]]


class Problem(NamedTuple):
    """A cost to minimise, under constraints that must not exceed 0."""

    values: Callable[[NDArray[np.float64]], Values]
    lower: list[float]
    upper: list[float]
    optimum: float


def sphere(x: NDArray[np.float64]) -> Values:
    """Return the squared distance from 0, where the first gene must be at least 1."""
    return float((x**2).sum()), [1 - x[0]]


def g06(x: NDArray[np.float64]) -> Values:
    """Return a cubic cost in a thin crescent of two circles."""
    a, b = x.tolist()
    cost = (a - 10) ** 3 + (b - 20) ** 3
    return cost, [100 - (a - 5) ** 2 - (b - 5) ** 2, (a - 6) ** 2 + (b - 5) ** 2 - 82.81]


def g07(x: NDArray[np.float64]) -> Values:
    """Return a quadratic cost of ten genes under eight constraints, six of which are active."""
    a, b, c, d, e, f, g, h, i, j = x.tolist()
    cost = a * a + b * b + a * b - 14 * a - 16 * b + (c - 10) ** 2 + 4 * (d - 5) ** 2
    cost += (e - 3) ** 2 + 2 * (f - 1) ** 2 + 5 * g * g + 7 * (h - 11) ** 2 + 2 * (i - 10) ** 2
    return cost + (j - 7) ** 2 + 45, [
        -105 + 4 * a + 5 * b - 3 * g + 9 * h,
        10 * a - 8 * b - 17 * g + 2 * h,
        -8 * a + 2 * b + 5 * i - 2 * j - 12,
        3 * (a - 2) ** 2 + 4 * (b - 3) ** 2 + 2 * c * c - 7 * d - 120,
        5 * a * a + 8 * b + (c - 6) ** 2 - 2 * d - 40,
        a * a + 2 * (b - 2) ** 2 - 2 * a * b + 14 * e - 6 * f,
        0.5 * (a - 8) ** 2 + 2 * (b - 4) ** 2 + 3 * e * e - f - 30,
        -3 * a + 6 * b + 12 * (i - 8) ** 2 - 7 * j,
    ]


def g09(x: NDArray[np.float64]) -> Values:
    """Return a polynomial cost of seven genes under four constraints, two of which are active."""
    a, b, c, d, e, f, g = x.tolist()
    cost = (a - 10) ** 2 + 5 * (b - 12) ** 2 + c**4 + 3 * (d - 11) ** 2 + 10 * e**6
    return cost + 7 * f * f + g**4 - 4 * f * g - 10 * f - 8 * g, [
        -127 + 2 * a * a + 3 * b**4 + c + 4 * d * d + 5 * e,
        -282 + 7 * a + 3 * b + 10 * c * c + d - e,
        -196 + 23 * a + b * b + 6 * f * f - 8 * g,
        4 * a * a + b * b - 3 * a * b + 2 * c * c + 5 * f - 11 * g,
    ]


PROBLEMS = {
    "sphere, 10 genes, 1 constraint": Problem(sphere, [-5.0] * 10, [5.0] * 10, 1.0),
    "g06, 2 genes, 2 constraints": Problem(g06, [13.0, 0.0], [100.0] * 2, -6961.8138755801),
    "g07, 10 genes, 8 constraints": Problem(g07, [-10.0] * 10, [10.0] * 10, 24.3062090681),
    "g09, 7 genes, 4 constraints": Problem(g09, [-10.0] * 7, [10.0] * 7, 680.6300573745),
}


class Counter:
    """Counts evaluations until the optimum is reached."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.evaluations, self.reached = problem, 0, np.inf

    def __call__(self, x: NDArray[np.float64]) -> Values:
        """Return the cost and the constraints of a genome."""
        self.evaluations += 1
        cost, constraints = self.problem.values(np.asarray(x))
        close = cost - self.problem.optimum <= PRECISION * (1 + abs(self.problem.optimum))
        if close and max(constraints) <= 0 and not np.isfinite(self.reached):
            self.reached = self.evaluations
        return cost, constraints


def ours(problem: Problem, seed: int) -> float:
    """Return the evaluations that gaitsim needs; infinite if it misses the optimum."""
    counter = Counter(problem)
    number = len(problem.values(np.array(problem.lower))[1])
    optimiser = gaitsim.Optimiser(
        gaitsim.RealSpace(np.array(problem.lower), np.array(problem.upper)),
        constraints={f"g{index}": 0.0 for index in range(number)},
        seed=seed,
        set={"evolution.max_evaluations": EVALUATIONS, "search.step": STEP},
    )
    while not optimiser.stop and not np.isfinite(counter.reached):
        found = [counter(genome) for genome in optimiser.ask()]
        terms = {f"g{index}": [one[1][index] for one in found] for index in range(number)}
        optimiser.tell({"score": [-cost for cost, _ in found], **terms})
    return counter.reached


def theirs(problem: Problem, seed: int) -> float:
    """Return the evaluations that pycma needs; infinite if it misses the optimum."""
    counter = Counter(problem)
    lower, upper = np.array(problem.lower), np.array(problem.upper)
    last: list[Values] = []

    def cost(x: NDArray[np.float64]) -> float:
        return last[0][0]

    def constraints(x: NDArray[np.float64]) -> list[float]:  # called before the cost
        last[:] = [counter(x)]
        return last[0][1]

    handler = cma.ConstrainedFitnessAL(cost, constraints, archives=False, logging=0)
    start = np.random.default_rng(seed).uniform(lower, upper)
    options = {
        "bounds": [lower.tolist(), upper.tolist()],
        "CMA_stds": (STEP * (upper - lower)).tolist(),
        "maxfevals": EVALUATIONS,
        "seed": seed,
        "tolstagnation": 0,
        "tolfun": 0,
        "tolfunhist": 0,
        "verbose": -9,
    }
    search = cma.CMAEvolutionStrategy(start, 1, options)
    while not search.stop() and not np.isfinite(counter.reached):
        genomes = search.ask()
        search.tell(genomes, [handler(genome) for genome in genomes])
        handler.update(search)
    return counter.reached


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")  # of pycma, about equal values
    print_machine()
    print(f"{'evaluations, median of runs that reach it':<42}{'gaitsim':>20}{'pycma':>20}")
    for name, problem in PROBLEMS.items():
        cells = []
        for run in (ours, theirs):
            found = np.array([run(problem, seed) for seed in SEEDS])
            reached = found[np.isfinite(found)]
            middle = f"{np.median(reached):,.0f}" if len(reached) else "—"
            cells.append(f"{middle} ({len(reached)} of {len(found)})")
        print(f"{name:<42}{cells[0]:>20}{cells[1]:>20}", flush=True)


if __name__ == "__main__":
    main()

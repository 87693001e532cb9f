"""`nsga-2` and pymoo's NSGA2: hypervolume on ZDT1-3 and DTLZ2, and the time of ask and tell.

Both run 250 generations of 100 individuals with their default options, as in Deb et al. 2002.
Figures are medians of 15 seeds; pymoo computes the hypervolume of both fronts. The times exclude
the evaluation of the problems.
"""

import statistics
import time

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.core.evaluator import Evaluator
from pymoo.core.problem import Problem
from pymoo.indicators.hv import HV
from pymoo.problems import get_problem
from pymoo.termination import get_termination
from timing import milliseconds, print_machine, times

from gaitsim.contracts import RealSpace
from gaitsim.contracts.search import Context, Results
from gaitsim_searches.nsga_2 import Nsga2

POPULATION, GENERATIONS, SEEDS = 100, 250, 15
REFERENCE = 1.1  # in each objective; the true fronts end at 1


def run_gaitsim(problem: Problem, seed: int) -> tuple[np.ndarray, float]:
    """Return the front that `nsga-2` finds, (members, objectives), and the seconds it takes."""
    labels = tuple(f"x{gene}" for gene in range(problem.n_var))
    space = RealSpace(problem.xl.astype(float), problem.xu.astype(float), labels)
    names = [f"f{number}" for number in range(problem.n_obj)]
    search = Nsga2(objectives=dict.fromkeys(names, "min"))

    def context(generation: int, purpose: int) -> Context:
        rng = np.random.default_rng([seed, generation, purpose])
        return Context(space, POPULATION, generation, rng)

    state, seconds = search.initial(context(0, 0)), 0.0
    for generation in range(1, GENERATIONS + 1):
        start = time.perf_counter()
        genomes, state = search.ask(state, None, context(generation, 1))
        seconds += time.perf_counter() - start
        values = problem.evaluate(genomes, return_values_of=["F"])
        start = time.perf_counter()
        results = Results(genomes, -values[:, 0], dict(zip(names, values.T, strict=True)))
        state = search.tell(state, results, context(generation, 2))
        seconds += time.perf_counter() - start
    members = search.members(state)
    assert members is not None
    return np.stack(list(members.values.values()), axis=1), seconds


def run_pymoo(problem: Problem, seed: int) -> tuple[np.ndarray, float]:
    """Return the front that pymoo finds, (members, objectives), and the seconds it takes."""
    algorithm = NSGA2(pop_size=POPULATION)
    termination = get_termination("n_gen", GENERATIONS)
    algorithm.setup(problem, termination=termination, seed=seed, verbose=False)
    seconds = 0.0
    while algorithm.has_next():
        start = time.perf_counter()
        asked = algorithm.ask()
        seconds += time.perf_counter() - start
        Evaluator().eval(problem, asked)
        start = time.perf_counter()
        algorithm.tell(infills=asked)
        seconds += time.perf_counter() - start
    return algorithm.opt.get("F"), seconds


def main() -> None:
    """Print the table."""
    print_machine()
    print(f"{POPULATION} × {GENERATIONS} evaluations, median (minimum–maximum) of {SEEDS} seeds\n")
    columns = "{:<8}{:>26}{:>26}{:>10}{:>16}{:>16}{:>8}"
    heads = "problem", "gaitsim", "pymoo", "ratio", "ask and tell", "pymoo", ""
    print(columns.format(*heads))
    for name in ("zdt1", "zdt2", "zdt3", "dtlz2"):
        problem = get_problem(name)
        measure = HV(ref_point=np.full(problem.n_obj, REFERENCE))
        volumes: list[list[float]] = [[], []]
        seconds: list[list[float]] = [[], []]
        for seed in range(SEEDS):  # in turns, so that other programs slow both alike
            for index, search in enumerate((run_gaitsim, run_pymoo)):
                front, taken = search(problem, seed)
                volumes[index].append(float(measure(front)))
                seconds[index].append(taken / GENERATIONS)
        middle = [statistics.median(found) for found in volumes]
        each = [statistics.median(found) for found in seconds]
        cells = [
            f"{m:.4f} ({min(v):.4f}–{max(v):.4f})" for m, v in zip(middle, volumes, strict=True)
        ]
        ratio = f"{middle[0] / middle[1]:.4f}"
        slower = times(each[1] / each[0])
        print(columns.format(name, *cells, ratio, *map(milliseconds, each), slower))


if __name__ == "__main__":
    main()

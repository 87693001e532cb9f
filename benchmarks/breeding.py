"""One breeding step of 100 individuals with 48 genes, compared with the same step in DEAP.

Both keep the best individual, breed the 16 best and 4 random others, cross each pair at one random
point, keep one child per pair, mutate every gene with a probability of 0.05, and clip children to
the bounds.
"""

import importlib.util
import random
from collections.abc import Callable

import numpy as np
from timing import medians, milliseconds, print_figure, print_machine, times

from gaitsim.contracts import RealSpace, Results
from gaitsim.evolution import ask, first_population
from gaitsim.experiment import load_experiment

REPEATS = 40  # in each of five rounds
OVERRIDES = {"crossover.point": "random", "mutation.sigma": 0.05, "mutation.rate": 0.05}


def gaitsim_step() -> tuple[Callable[[], object], RealSpace]:
    """Return gaitsim's breeding step and its genome space."""
    experiment = load_experiment("spider-recurrence", OVERRIDES)
    space = experiment.space()
    assert isinstance(space, RealSpace)
    genomes = first_population(experiment)
    scores = np.random.default_rng(0).standard_normal(len(genomes))
    return lambda: ask(experiment, space, {}, Results(genomes, scores), 2)[0], space


def deap_step(space: RealSpace, *, shallow: bool) -> Callable[[], object]:
    """Return the same step with DEAP's operators on lists.

    Args:
        space: genome space with the bounds of the genes.
        shallow: whether to copy parents as plain lists, which suffices here and is faster than
            DEAP's default, `copy.deepcopy`.
    """
    from deap import base, creator, tools

    if not hasattr(creator, "Individual"):
        creator.create("Score", base.Fitness, weights=(1.0,))
        creator.create("Individual", list, fitness=creator.Score)
    toolbox = base.Toolbox()
    if shallow:
        toolbox.register("clone", creator.Individual)
    lower, upper = space.lower.tolist(), space.upper.tolist()
    sigma = (0.05 * space.width).tolist()
    rng = random.Random(0)
    random.seed(0)  # DEAP's operators draw from the global generator
    population = []
    for _ in range(100):
        genes = [rng.uniform(low, high) for low, high in zip(lower, upper, strict=True)]
        individual = creator.Individual(genes)
        individual.fitness.values = (rng.gauss(0, 1),)
        population.append(individual)

    def step() -> list[object]:
        best = tools.selBest(population, len(population))
        survivors = best[:16] + random.sample(best[16:], 4)
        children = [toolbox.clone(best[0])]
        while len(children) < len(population):
            mother, father = map(toolbox.clone, random.sample(survivors, 2))
            child, _ = tools.cxOnePoint(mother, father)
            (child,) = tools.mutGaussian(child, 0.0, sigma, 0.05)
            child[:] = [
                min(max(gene, low), high)
                for gene, low, high in zip(child, lower, upper, strict=True)
            ]
            children.append(child)
        return children

    return step


def main() -> None:
    """Print the figures."""
    print_machine()
    step, space = gaitsim_step()
    names, works = ["gaitsim: one step, 100 × 48 genes"], [step]
    deap = importlib.util.find_spec("deap") is not None
    if deap:
        names += [
            "DEAP: parents cloned with deepcopy, its default",
            "DEAP: parents copied as lists",
        ]
        works += [deap_step(space, shallow=False), deap_step(space, shallow=True)]
    ours, *theirs = medians(*works, repeats=REPEATS)
    print_figure(names[0], milliseconds(ours))
    for name, seconds in zip(names[1:], theirs, strict=True):
        print_figure(name, milliseconds(seconds), f"{times(seconds / ours)} as long")
    if not deap:
        print("DEAP is not installed; to compare: pip install -e '.[benchmarks]'")


if __name__ == "__main__":
    main()

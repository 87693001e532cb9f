"""The full published millipede study, compared with DEAP, and a check of its claims.

gaitsim evolves five algorithms × 39 pool sizes × 80 generations × 100 repeats on all cores, as
`gaitsim study millipede-operators` does, without the pictures. DEAP evolves two repeats of each
algorithm at three pool sizes on one core; its time is scaled by the number of individuals bred.
Then each cell that the study reports is repeated 4,000 times with new seeds. The benchmark prints
whether the 95 % interval of the new mean overlaps the reported interval and reaches the target.
"""

import importlib.util
import math
import random
import tempfile
from pathlib import Path

from timing import print_figure, print_machine, stopwatch, times

from gaitsim.evaluation import Evaluator
from gaitsim.evolution.repeats import evolve_repeats
from gaitsim.experiment import load_experiment
from gaitsim_studies.confirmation import ReachedTarget, confirm
from gaitsim_studies.file import Study, cells, read_study
from gaitsim_studies.running import results, run_cells

POOLS, REPEATS = (9, 41, 73), 2  # the part evolved with DEAP
LEGS, BITS = 6, 6
CHECKED, SEED = 4000, 20_000_000  # repeats of each reported cell, and the first seed


def sweep(study: Study, folder: Path) -> float:
    """Evolve all cells of the study, and return the seconds."""

    def work() -> None:
        for _ in run_cells(folder, study, cells(study), None):
            pass

    return stopwatch(work)


def reported_cells(study: Study, folder: Path) -> list[ReachedTarget]:
    """Return the cells that the finished study reports."""
    return confirm(folder, study, results(folder, study, cells(study))[0], None)


def repeat_cell(cell: ReachedTarget, seed: int) -> tuple[float, float]:
    """Return the mean of new repeats of a reported cell, and its standard error."""
    size = {"population": cell.population, "generations": cell.generations}
    changes = {f"evolution.{name}": value for name, value in size.items()}
    experiment = load_experiment(cell.experiment, changes | {"seed": seed})
    with Evaluator(experiment, 1) as evaluator:
        *_, best = evolve_repeats(experiment, evaluator.evaluate, CHECKED)
    return float(best.mean()), float(best.std(ddof=1)) / math.sqrt(CHECKED)


def _degrees(individual: list[int]) -> list[int]:
    """Return the angles of the legs; clip magnitudes to 20, in the genome as well."""
    angles = []
    for start in range(0, LEGS * BITS, BITS):
        sign, *magnitude = individual[start : start + BITS]
        value = int("".join(map(str, magnitude)), 2)
        if value > 20:
            value = 20
            individual[start + 1 : start + BITS] = [1, 0, 1, 0, 0]
        angles.append(-value if sign else value)
    return angles


def _score(individual: list[int]) -> tuple[float]:
    reach = [math.sin(math.radians(angle)) for angle in _degrees(individual)]
    half = LEGS // 2
    left, right = sum(reach[:half]) / half, sum(reach[half:]) / half
    best = math.sin(math.radians(20))
    if left > 0 and right > 0:
        return (10 * min(left, right) / best,)
    if left < 0 and right < 0:
        return (10 * max(left, right) / best,)
    return (0.0,)


def deap_run(algorithm: str, pool: int, generations: int) -> None:
    """Evolve one repeat with DEAP: drop the worst, breed the rest, add a copy of the best."""
    from deap import base, creator, tools

    if not hasattr(creator, "Millipede"):
        creator.create("Reach", base.Fitness, weights=(1.0,))
        creator.create("Millipede", list, fitness=creator.Reach)
    toolbox = base.Toolbox()
    toolbox.register("bit", random.randint, 0, 1)
    toolbox.register("individual", tools.initRepeat, creator.Millipede, toolbox.bit, LEGS * BITS)
    toolbox.register("population", tools.initRepeat, list, toolbox.individual)
    population = toolbox.population(n=pool)

    def evaluate() -> None:
        for individual in population:
            if not individual.fitness.valid:
                individual.fitness.values = _score(individual)

    evaluate()
    for _ in range(generations - 1):
        population.remove(tools.selWorst(population, 1)[0])
        best = toolbox.clone(tools.selBest(population, 1)[0])
        random.shuffle(population)
        if algorithm == "millipede-random":
            population = toolbox.population(n=pool - 1)
        elif algorithm.endswith("crossover"):
            cross = tools.cxTwoPoint if "double" in algorithm else tools.cxOnePoint
            for mother, father in zip(population[::2], population[1::2], strict=True):
                cross(mother, father)
        else:
            for individual in population:
                for place in random.sample(range(LEGS * BITS), 2 if "double" in algorithm else 1):
                    individual[place] ^= 1
        for individual in population:
            del individual.fitness.values
        population.append(best)
        evaluate()


def deap_seconds(study: Study, generations: int) -> float:
    """Return the seconds of the whole study with DEAP, scaled from a part."""
    random.seed(0)  # DEAP uses the global generator

    def part() -> None:
        for algorithm in study.experiments:
            for pool in POOLS:
                for _ in range(REPEATS):
                    deap_run(algorithm, pool, generations)

    whole = sum(map(float, study.values("evolution.population"))) * study.repeats
    return stopwatch(part) * whole / (sum(POOLS) * REPEATS)


def main() -> None:
    """Print the figures."""
    print_machine()
    study, _ = read_study("millipede-operators")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        seconds = sweep(study, folder)
        print_figure("gaitsim: the whole published study", f"{seconds:.1f} s", "all cores")
        for number, cell in enumerate(reported_cells(study, folder)):
            mean, error = repeat_cell(cell, SEED + number)
            low, high = mean - 1.96 * error, mean + 1.96 * error
            met = low <= cell.high and cell.low <= high
            held = met and (high >= (study.target or 0) or not cell.reached)
            reported = f"{cell.mean:.3f} ({cell.low:.3f} to {cell.high:.3f})"
            print_figure(
                f"{cell.experiment} {cell.population} / {cell.generations}",
                reported,
                f"{mean:.3f} ± {1.96 * error:.3f} in {CHECKED:,} new repeats: "
                + ("holds" if held else "FAILS"),
            )
    if importlib.util.find_spec("deap") is None:
        print("DEAP is not installed; to compare: pip install -e '.[benchmarks]'")
        return
    theirs = deap_seconds(study, 80)
    beside = f"{times(theirs / seconds)} as long; one core, scaled from a part"
    print_figure("DEAP: the same work", f"{theirs:.0f} s", beside)


if __name__ == "__main__":
    main()

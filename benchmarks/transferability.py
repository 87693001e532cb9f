"""Gaits of the preset quadruped-transfer in reality, compared with gaits evolved for score only."""

import argparse
from functools import partial

import numpy as np

from gaitsim.contracts import Genomes
from gaitsim.evaluation import evaluate
from gaitsim.evaluation.worlds import in_reality
from gaitsim.evolution import Generation, evolve
from gaitsim.experiment import Experiment, load_experiment, with_overrides

SMALL = {"organism.duration": 5, "evolution.generations": 50}
ALONE = {"search.plugin": "nsga-2", "search.objectives": {"score": "max", "forward": "max"}}


def evolve_to_end(experiment: Experiment) -> tuple[Generation, Genomes]:
    """Return the last generation, and the genome with the best score of the run, (1, genes)."""
    best, score = np.empty(0), -np.inf
    for last in evolve(experiment, partial(evaluate, experiment)):
        if last.scores.max() > score:
            best, score = last.genomes[last.best][None], float(last.scores.max())
    return last, best


def print_row(name: str, seed: int, experiment: Experiment, genome: Genomes) -> None:
    """Print score and distance of a genome, (1, genes), in simulation and in reality."""
    found = [evaluate(one, genome) for one in (experiment, in_reality(experiment))]
    cells = [f"{one.scores[0]:6.2f} {one.terms['forward'][0]:6.2f} m" for one in found]
    print(f"seed {seed}  {name:18} simulation {cells[0]}  reality {cells[1]}", flush=True)


def main() -> None:
    """Evolve both kinds of gait for each seed, and print their rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    for seed in range(parser.parse_args().seeds):
        experiment = load_experiment("quadruped-transfer", {"seed": seed, **SMALL})
        last, _ = evolve_to_end(experiment)
        front = experiment.search.members(last.state)
        if front is None or not len(front.scores):
            continue
        expected = front.scores + front.values["transferability"]
        for name, at in (("best score", front.scores.argmax()), ("expected", expected.argmax())):
            print_row(name, seed, experiment, front.genomes[at][None])
        size = {"evolution.population": experiment.evolution.population}
        alone = with_overrides(
            load_experiment("quadruped"), {"seed": seed, **SMALL, **size, **ALONE}
        )
        print_row("the score alone", seed, experiment, evolve_to_end(alone)[1])


if __name__ == "__main__":
    main()

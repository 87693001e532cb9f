"""Walkers of the presets for 10 s, on one core and on all cores, and the physics engine alone.

The lower bound is `Space.step` in a loop: the same bodies, joints and ground, with a walker that
stands on four legs for 10 s, without commands and without reading or recording results.
"""

import numpy as np
from timing import medians, milliseconds, print_figure, print_machine, times

from gaitsim.evaluation import Evaluator, evaluate
from gaitsim.evolution import first_population
from gaitsim.experiment import load_experiment
from gaitsim_walker.machine import Machine
from gaitsim_walker.organism import Walker

TARGET = 60  # least multiple of real time, per core
COUNT = 20


def main() -> None:
    """Print the figures."""
    print_machine()
    for preset in ("walker", "walker-four"):
        print_speed(preset)
    print_lower_bound(Walker(legs=4))


def print_speed(preset: str) -> None:
    """Print the figures for walkers that do not fall, as a fall ends the simulation early."""
    experiment = load_experiment(preset)
    walker = experiment.organism
    assert isinstance(walker, Walker)
    genomes = first_population(experiment)
    lasting = genomes[walker.move(genomes)["lasted"] == walker.duration]
    whole = np.resize(lasting, (COUNT, genomes.shape[1]))
    seconds = COUNT * walker.duration
    with Evaluator(experiment) as all_cores:
        all_cores.prepare()
        alone, together = medians(
            lambda: evaluate(experiment, whole), lambda: all_cores.evaluate(whole), repeats=1
        )
    print_figure(f"{preset}, one core", times(seconds / alone), f"real time; at least {TARGET} ×")
    print_figure("all cores", times(seconds / together), "real time")
    print_figure("a walker of 10 s", milliseconds(alone / COUNT))


def print_lower_bound(walker: Walker) -> None:
    """Print the times of a standing walker, with `play` and with the physics engine alone."""
    commands = np.zeros((1, walker.frames, 2 * walker.legs))
    world = walker.surroundings(walker.frames)

    def bare() -> None:
        machine = Machine(world, commands[0, 0])
        for _ in range((walker.frames - 1) * world.steps):
            machine.space.step(world.step)

    stands, alone = medians(lambda: walker.play(commands), bare, repeats=5)
    print_figure("a walker standing on four legs for 10 s", milliseconds(stands))
    print_figure("the physics engine alone", milliseconds(alone), times(stands / alone))


if __name__ == "__main__":
    main()

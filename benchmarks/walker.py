"""Walkers of the preset, 10 s each, on one core and on all; beside them the physics engine alone.

The floor is `Space.step` in a loop, of the same bodies, joints and ground, while the walker stands:
no servo is told anything, nothing is read or recorded.
"""

import numpy as np
from timing import medians, milliseconds, print_figure, print_machine, times

from gaitsim.evaluation import Evaluator, judge
from gaitsim.evolution import first_population
from gaitsim.experiment import load_experiment
from gaitsim_walker.machine import STEP, STEPS, Machine
from gaitsim_walker.organism import Walker

LEAST = 60  # times real time a core
COUNT = 20


def main() -> None:
    """Print the figures."""
    print_machine()
    experiment = load_experiment("walker")
    walker = experiment.organism
    assert isinstance(walker, Walker)
    genomes = first_population(experiment, experiment.space())
    lasted = walker.move(genomes)["lasted"]
    # Walkers that do not fall: a fall would end their work early.
    whole = genomes[lasted == walker.duration][:COUNT]
    seconds = len(whole) * walker.duration
    commands = np.zeros((1, walker.frames, 2 * walker.legs))
    world, rest = walker.world(walker.frames), np.zeros(2 * walker.legs)

    def floor() -> None:
        machine = Machine(world, rest)
        for _ in range((walker.frames - 1) * STEPS):
            machine.space.step(STEP)

    with Evaluator(experiment) as every:
        every.prepare()
        alone, stands, bare = medians(
            lambda: judge(experiment, whole), lambda: walker.play(commands), floor, repeats=1
        )
        (together,) = medians(lambda: every.evaluate(whole), repeats=1)
    print_figure("one core", times(seconds / alone), f"real time; at least {LEAST} ×")
    print_figure("a walker of 10 s", milliseconds(alone / len(whole)))
    print_figure("one that stands", milliseconds(stands))
    print_figure("the physics engine alone", milliseconds(bare), f"{stands / bare:.1f} × as fast")
    print_figure("all cores", times(seconds / together), "real time")


if __name__ == "__main__":
    main()

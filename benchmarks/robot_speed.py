"""Robots of the presets for 10 s, on one core and on all cores, and the physics engine alone.

The floor is `mj_step` in the same simulation, with the same commands and initial state, one robot
at a time, and without reading or recording results. Only individuals of the first population that
do not fall are measured, as the simulation of a fallen robot ends early.
"""

import mujoco
import numpy as np
from timing import medians, milliseconds, print_figure, print_machine, times

from gaitsim.evaluation import Evaluator, evaluate
from gaitsim.evolution import first_population
from gaitsim.experiment import load_experiment
from gaitsim_robot.organism import Robot

TARGET = 0.85  # least share of the physics engine's speed, on each core
COUNT = 16
PRESETS = ("quadruped", "hexapod", "spider-physics")


def main() -> None:
    """Print the figures."""
    print_machine()
    for preset in PRESETS:
        print_speed(preset)


def print_speed(preset: str) -> None:
    """Print the figures for the individuals of the first population that do not fall."""
    experiment = load_experiment(preset)
    robot = experiment.organism
    assert isinstance(robot, Robot)
    genomes = first_population(experiment)
    lasting = genomes[robot.move(genomes)["lasted"] == robot.duration]
    whole = np.resize(lasting, (COUNT, genomes.shape[1]))
    commands = robot.move(whole)["joint_angles"]
    seconds = COUNT * robot.duration
    with Evaluator(experiment) as all_cores:
        all_cores.prepare()
        alone, together, floor = medians(
            lambda: evaluate(experiment, whole),
            lambda: all_cores.evaluate(whole),
            lambda: step_robots(robot, commands),
            repeats=1,
        )
    print_figure(f"{preset}, scores, one core", times(seconds / alone), "real time")
    print_figure("share of mj_step's speed", f"{floor / alone:.2f}", f"at least {TARGET}")
    print_figure("all cores", times(seconds / together), f"{alone / together:.2f} × one core")
    print_figure("mj_step alone, 10 s", milliseconds(floor / COUNT), times(seconds / floor))


def step_robots(robot: Robot, commands: np.ndarray) -> None:
    """Step each robot through its commands, each held for a frame."""
    simulation = robot.simulation
    data = mujoco.MjData(simulation.model)
    for frames in commands:
        mujoco.mj_setState(
            simulation.model, data, simulation.start, mujoco.mjtState.mjSTATE_FULLPHYSICS
        )
        data.ctrl[:] = simulation.rest
        for frame in frames[:-1]:
            data.ctrl[simulation.ctrl] = frame
            mujoco.mj_step(simulation.model, data, simulation.steps)


if __name__ == "__main__":
    main()

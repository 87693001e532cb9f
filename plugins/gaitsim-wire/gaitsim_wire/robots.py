"""The robot of an experiment, the calibration of its servos, and its emulator."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, Organism, load_reflexes
from gaitsim.plugin.runs import Experiment
from gaitsim.plugin.toolkit import observed
from gaitsim_hardware.calibration import Calibration, default_calibration
from gaitsim_hardware.calibration_file import read_calibration
from gaitsim_robot.feeling import Pilot
from gaitsim_robot.organism import Robot
from gaitsim_wire.body import ServoRobot
from gaitsim_wire.buses import Bus, ServoBus, SketchBus
from gaitsim_wire.emulator import EmulatedBus, Emulator, Noise, SketchBoard, parse_fault
from gaitsim_wire.tables import TABLES

Floats = NDArray[np.float64]

FORMATS = {"feetech": "feetech", "dynamixel": "dynamixel", "serial": "arduino"}
"""Format of the calibration by bus."""


def robot_of(experiment: Experiment) -> Robot:
    """Return the robot of an experiment.

    Raises:
        GaitsimError: the body is not a robot in MuJoCo, or has joints that slide.
    """
    organism: Organism = experiment.organism
    turns = not organism.sliding_joints()  # as servos do
    if isinstance(organism, Robot) and organism.engine == "mujoco" and turns:
        return organism
    raise GaitsimError(
        f"the body {experiment.entries['organism'].name!r} has no servos in MuJoCo, or slides",
        where=f"experiment {experiment.name}",
        allowed="a robot, such as those of the presets 'hexapod' and 'quadruped', or a robot file",
    )


def calibration_of(robot: Robot, bus: str, file: Path | None) -> Calibration:
    """Return the calibration in a file, or the default one.

    Raises:
        GaitsimError: the calibration is invalid, or has servos that do not speak the protocol.
    """
    joints, format = robot.joint_names(), FORMATS[bus]
    if file is None:
        found = default_calibration(format, joints, robot.standing_pose(), robot.servo)
    else:
        found = read_calibration(file, format, joints)
    for name, joint in found.joints.items() if bus in TABLES else ():
        if joint.servo not in TABLES[bus].models:
            raise GaitsimError(
                f"the servo {joint.servo!r} of {name} cannot be driven on the bus {bus!r}",
                where=str(file or "--bus"),
                allowed=", ".join(TABLES[bus].models),
            )
    return replace(found, ends=ends_of(robot))


def ends_of(robot: Robot) -> Floats:
    """Return both ends of each joint of a robot, (joints, 2) rad."""
    simulation = robot.simulation
    return np.array(simulation.model.actuator_ctrlrange[simulation.ctrl])


def bus_of(kind: str, port: Any, baud: int, calibration: Calibration, *, imu: bool) -> Bus:
    """Return the client of a wire; arguments as in `Bus` and `ServoBus`."""
    if kind == "serial":
        return SketchBus(port, baud, calibration)
    return ServoBus(kind, port, baud, calibration, imu=imu)


def pilot_of(robot: Robot, genome: Any, *, imu: bool) -> Pilot:
    """Return the controller of a gait, with the sensors of the real robot.

    Args:
        robot: robot of the gait.
        genome: genome of the gait, (genes,).
        imu: whether the robot has an IMU.

    Raises:
        GaitsimError: a reflex needs a sensor that the robot does not have.
    """
    sensors = [*(["ideal"] if imu else []), "joints"]
    for name, reflex in load_reflexes(robot.reflexes).items():
        missing = [need for need in reflex.needs if need not in observed(sensors)]
        if missing:
            an_imu = missing[0] in observed(["ideal"])
            raise GaitsimError(
                f"the reflex {name!r} needs {missing[0]}, which the robot does not report",
                where="--imu" if an_imu else "organism.reflexes",
                remedy="connect an IMU and add --imu, or play the simulated angles with --tape"
                if an_imu
                else "play the simulated angles with --tape, or evolve the gait without the reflex",
            )
    body, genes = robot.embody(genome)
    own = body.calibrated(genes)
    return own.model_copy(update={"sensors": tuple(sensors), "world": {}}).pilot(genes[None])


def create_emulator(
    experiment: Experiment,
    bus: str,
    file: Path | None,
    faults: tuple[str, ...],
    noise: Noise,
    *,
    imu: bool,
    hung: bool = False,
) -> Emulator:
    """Return a virtual robot with its servos off.

    Args:
        experiment: experiment of the robot, in its world.
        bus: 'feetech', 'dynamixel' or 'serial'.
        file: TOML file of the calibration; None for the default one.
        faults: faults, as `parse_fault` reads them.
        noise: losses on the wire.
        imu: whether an IMU answers on a servo bus.
        hung: whether the robot hangs in the air.
    """
    robot = robot_of(experiment)
    calibration = calibration_of(robot, bus, file)
    parsed = [parse_fault(text, robot.joint_names()) for text in faults]
    body = ServoRobot(robot.simulation, hung=hung)
    if bus == "serial":
        return SketchBoard(body, calibration, parsed, noise)
    return EmulatedBus(bus, body, calibration, parsed, noise, imu=imu)

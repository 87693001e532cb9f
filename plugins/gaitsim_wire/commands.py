"""`gaitsim robots emulate` and `gaitsim drive`."""

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from gaitsim.actions.action import RUN_OR_CODE, SET, Action, ChosenIndividual, argument
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.individual import Individual
    from gaitsim_hardware.calibration import Calibration
    from gaitsim_wire.driving import Player

Bus = Literal["feetech", "dynamixel", "serial"]
BAUD: int | None = option(
    None,
    "baud rate",
    unset="1000000; 115200 for serial",
    allowed="a usual baud rate, such as 57600, 115200, 500000 or 1000000",
)


class Emulate(Action):
    """Emulate a robot on a serial port: its servos and its body, in real time.

    The robot lies on the floor with its servos off until a program commands them through the
    pseudo-terminal whose path the command prints. Feetech servos (STS3215) speak their own
    protocol, Dynamixel servos (XL430) the protocol 2.0, and 'serial' is a board with the sketch
    of 'gaitsim export --format arduino --stream'. An IMU answers at the id 200 of a servo bus.

    [bold]Examples[/bold]

    gaitsim robots emulate hexapod --bus feetech

    gaitsim robots emulate hexapod --bus dynamixel --link robot.port

    gaitsim robots emulate hexapod --bus serial --world "joint_offset 2"

    gaitsim robots emulate quadruped --bus feetech --fault "L1 knee dead at 20"
    """

    model: str = argument(
        "name of a preset with a robot, or path of a TOML file or a robot file such as URDF",
        "MODEL",
        completion="preset_names",
    )
    bus: Bus = option("feetech", "kind of the wire")
    calibration: Path | None = option(
        None,
        "calibration file (TOML), which assigns a servo to each joint",
        unset="ids from 1, all servos at their centre in the standing pose",
        placeholder="FILE",
    )
    world: Names | None = option(
        None,
        "set a condition of the world, such as 'joint_offset 2' (errors of the servo horns in °), "
        "'latency 0.04', 'friction 0.5' or 'servo_torque 0.7'",
        placeholder="TEXT",
    )
    fault: Names | None = option(
        None,
        "let something fail: 'JOINT dead', 'JOINT weak SHARE', 'JOINT hot °C', 'JOINT twin' (a "
        "second servo with its id), 'JOINT reversed', 'battery VOLTS' or 'tipped'; with 'at "
        "SECONDS' for later",
        placeholder="TEXT",
    )
    drop: float = option(0.0, "share of frames that are lost, each way", ge=0, le=1)
    corrupt: float = option(0.0, "share of frames with a wrong byte, each way", ge=0, le=1)
    imu: bool = option(True, "let an IMU answer at the id 200 of a servo bus")
    seed: int = option(0, "seed of lost and wrong frames", ge=0)
    baud: int | None = BAUD
    link: Path | None = option(
        None, "create a symbolic link to the port, for a path that is known", placeholder="PATH"
    )
    seconds: float | None = option(None, "end after this time", unit="s", ge=0.1, unset="Ctrl-C")
    set_: Names | None = SET

    def do(self) -> None:
        """Run the virtual robot."""
        import numpy as np

        from gaitsim.console.interrupts import interruptible
        from gaitsim.console.printing import echo, notice, status
        from gaitsim.evaluation.worlds import parse_world
        from gaitsim.experiment import load_experiment, parse_assignments
        from gaitsim.gait.changed import put_in_world
        from gaitsim_wire.emulator import Noise
        from gaitsim_wire.ports import check_baud
        from gaitsim_wire.pseudo_terminal import serve
        from gaitsim_wire.robots import create_emulator

        baud = check_baud(self.baud or default_baud(self.bus))
        with status("Preparing the robot …"):
            experiment = load_experiment(self.model, parse_assignments(self.set_ or ()))
            if conditions := parse_world(self.world or (), "--world"):
                experiment = put_in_world(experiment, conditions)
            noise = Noise(self.drop, self.corrupt, np.random.default_rng(self.seed))
            faults, file = self.fault or (), self.calibration
            emulator = create_emulator(experiment, self.bus, file, faults, noise, imu=self.imu)
        joints = len(emulator.body.on)

        def begin(port: str) -> None:
            echo(f"{port}: {experiment.name}, {self.bus}, {joints} servos, {baud} baud")
            if self.seconds is None:
                echo("Ctrl-C ends it.")

        told = False

        def report(seconds: float) -> None:
            nonlocal told
            if emulator.tripped and not told:
                told = True
                notice(f"{seconds:.1f} s: the watchdog has stopped the servos.")

        start = emulator.body.place
        try:
            with interruptible():
                serve(emulator, baud, self.seconds or math.inf, self.link, begin, report)
        except KeyboardInterrupt:
            pass
        moved = emulator.body.place - start
        echo(f"The robot moved {moved[0]:+.2f} m forward and {moved[1]:+.2f} m to the left.")


class Drive(ChosenIndividual):
    """Drive a real robot with the keyboard: stream a gait to its servos, 50 times a second.

    The robot rises from where it lies, follows the keys as in 'gaitsim steer', and lies down at
    the end. Space switches the servos off at once, and so do a lost terminal, tipping, heat, a low
    voltage and a servo that does not answer. Hang the robot up for the first time.

    The telemetry is saved as a gait file, which 'gaitsim analyse --gait' compares with the run.

    [bold]Examples[/bold]

    gaitsim drive hexapod --port /dev/ttyUSB0 --calibration robot.toml

    gaitsim drive hexapod --port /dev/ttyUSB0 --calibration robot.toml --tape

    gaitsim drive hexapod-steady --port robot.port --calibration robot.toml --imu
    """

    run: str = argument(RUN_OR_CODE, "RUN|CODE")
    port: str = option(..., "serial port, such as /dev/ttyUSB0", placeholder="PATH")
    calibration: Path = option(
        ..., "calibration file (TOML), which assigns a servo to each joint", placeholder="FILE"
    )
    bus: Bus = option("feetech", "kind of the wire")
    baud: int | None = BAUD
    imu: bool = option(False, "read an IMU at the id 200 of a servo bus")
    tape: bool = option(
        False, "play the joint angles of the simulation, instead of following commands"
    )
    speed: float | None = option(
        None,
        "playback speed of --tape; 0.5 is half as fast as simulated",
        ge=0.01,
        le=10,
        unset="1",
    )
    walk: bool = option(False, "walk at the gait's own speed, instead of waiting for keys")
    seconds: float | None = option(
        None, "lie down after this time", unit="s", ge=0.1, unset="the key q"
    )
    max_temperature: float = option(
        65.0, "temperature of a servo above which the robot is stopped", unit="°C", ge=30, le=90
    )
    min_voltage: float | None = option(
        None,
        "voltage below which the robot is stopped",
        unit="V",
        ge=0,
        le=30,
        unset="6.0; 6.5 for dynamixel, 4.5 for serial",
    )
    record: Path | None = option(
        None,
        "gait file (.npz) for the telemetry",
        unset="robot-N.npz in the exports of the run",
        placeholder="FILE.npz",
    )

    def do(self) -> None:
        """Check the robot, drive it, and save the telemetry."""
        from gaitsim.console import INTERRUPTED
        from gaitsim.console.codes import read_individual
        from gaitsim.console.interrupts import interruptible
        from gaitsim.console.printing import notice, status
        from gaitsim.gait.gait_files import check_folder
        from gaitsim.storage.files.folder import command
        from gaitsim_wire.driving import LEAST_VOLTS, Limits, Session, Stopped
        from gaitsim_wire.ports import check_baud, open_port
        from gaitsim_wire.robots import bus_of
        from gaitsim_wire.terminal import deadman, poller, raw_keys, say

        baud = check_baud(self.baud or default_baud(self.bus))
        if not sys.stdin.isatty() and self.seconds is None:
            raise GaitsimError(
                "the keyboard is not a terminal, so nothing could stop the robot",
                where="--seconds",
                remedy="add --seconds, or start the command in a terminal",
            )
        with status("Preparing the gait …"):
            individual = read_individual(self.run, self.choice)
            player, calibration = self._player(individual)
        path = self.record or _next_recording(individual)
        check_folder(path)
        volts = LEAST_VOLTS[self.bus] if self.min_voltage is None else self.min_voltage
        session: Session | None = None
        ended, code = "The robot has lain down; its servos are off.", 0
        try:
            with interruptible(), open_port(self.port, baud) as port:
                bus = bus_of(self.bus, port, baud, calibration, imu=self.imu)
                bus.off()
                with status("Checking the servos …"):
                    bus.check()
                if self.bus != "serial" and not self.imu:
                    notice("Without --imu, tipping over is not noticed.")
                session = Session(bus, player, calibration, Limits(self.max_temperature, volts))
                names = tuple(calibration.joints)
                with deadman(port.fileno(), bus.off_frame()), raw_keys() as keys:
                    session.run(poller(player, keys, names, self.seconds or math.inf))
        except KeyboardInterrupt:
            ended, code = "Stopped; the servos are off.", INTERRUPTED
        except Stopped as stop:
            ended, code = f"Stopped: {stop}. The servos are off.", 1
        say(ended)
        if session and len(session.recording):
            session.recording.write(path, tuple(calibration.joints))
            found = session.status
            say(
                f"{path}: {found.seconds:.1f} s, {found.late} of {found.frames} frames late, round "
                f"trip {1000 * found.round_trip:.1f} ms. Compare it with the simulation: "
                + command("analyse", self.run, "--gait", path)
            )
        if code:
            sys.exit(code)

    def _player(self, individual: "Individual") -> "tuple[Player, Calibration]":
        """Return the source of the angles, and the calibration.

        Raises:
            GaitsimError: the gait cannot follow commands, or needs a sensor that no bus has.
        """
        from gaitsim.console.printing import notice
        from gaitsim.gait.gait_files import gait_of
        from gaitsim_hardware.c_code import with_rhythm
        from gaitsim_hardware.calibration_file import read_calibration
        from gaitsim_hardware.keyframes import find_loop, keyframes_of
        from gaitsim_wire.driving import Tape, Walker
        from gaitsim_wire.robots import (
            FORMATS,
            calibration_of,
            pilot_of,
            robot_of,
        )

        if self.tape:
            if self.walk:
                raise GaitsimError("--tape and --walk cannot be combined", where="--tape, --walk")
            gait = gait_of(individual)
            calibration = read_calibration(self.calibration, FORMATS[self.bus], gait.joint_names)
            loop, speed = find_loop(gait.angles, gait.frame_rate), self.speed or 1.0
            keyframes = keyframes_of(gait, calibration, 20, speed=speed, loop=loop)
            return Tape(keyframes, calibration), calibration
        if self.speed is not None:
            raise GaitsimError("--speed is for --tape", where="--speed", remedy="add --tape")
        individual, notices = with_rhythm(individual)
        for text in notices:
            notice(text)
        robot = robot_of(individual.experiment)
        calibration = calibration_of(robot, self.bus, self.calibration)
        imu = self.imu or self.bus == "serial"
        pilot = pilot_of(robot, individual.genome, imu=imu)
        return Walker(pilot, imu=imu, walk=self.walk), calibration


def _next_recording(individual: "Individual") -> Path:
    """Return a new file in the exports of the individual's run, or in the current folder."""
    from gaitsim.storage.files.folder import exports_folder

    source = individual.source
    folder = exports_folder(source) if source is not None and source.is_dir() else Path()
    number = 1
    while (path := folder / f"robot-{number}.npz").exists():
        number += 1
    return path


def default_baud(bus: str) -> int:
    """Return the usual baud rate of a bus."""
    return 115_200 if bus == "serial" else 1_000_000

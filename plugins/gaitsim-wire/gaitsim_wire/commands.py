"""`gaitsim robots emulate` and `gaitsim drive`."""

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import GaitsimError, Names, option
from gaitsim.plugin.commands import RUN_OR_CODE, SET, Action, ChosenIndividual, argument
from gaitsim_wire.wire import BAUD, BUS, Bus, WireOptions, baud_of

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Individual
    from gaitsim_hardware.calibration import Calibration
    from gaitsim_wire.driving import Player


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
    bus: Bus = BUS
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
    hang: bool = option(False, "hang the robot up in the air, as for calibrating it")
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

        from gaitsim.plugin.commands import echo, interruptible, notice, status
        from gaitsim.plugin.gait import put_in_world
        from gaitsim.plugin.runs import load_experiment, parse_assignments, parse_world
        from gaitsim_wire.emulator import Noise
        from gaitsim_wire.pseudo_terminal import serve
        from gaitsim_wire.robots import create_emulator

        baud = baud_of(self.bus, self.baud)
        with status("Preparing the robot …"):
            experiment = load_experiment(self.model, parse_assignments(self.set_ or ()))
            if conditions := parse_world(self.world or (), "--world"):
                experiment = put_in_world(experiment, conditions)
            noise = Noise(self.drop, self.corrupt, np.random.default_rng(self.seed))
            faults, file = self.fault or (), self.calibration
            emulator = create_emulator(
                experiment, self.bus, file, faults, noise, imu=self.imu, hung=self.hang
            )
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


class Drive(ChosenIndividual, WireOptions):
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

    title: ClassVar[str] = "Drive the robot"
    menu: ClassVar[str] = "Robot"
    remembered: ClassVar[tuple[str, ...]] = ("port", "calibration", "bus", "baud", "imu")
    terminal: ClassVar[bool] = True

    run: str = argument(RUN_OR_CODE, "RUN|CODE")
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
    excite: bool = option(
        False,
        "walk for a minute in all directions, within two metres, for 'gaitsim robots identify'",
    )
    seconds: float | None = option(
        None, "lie down after this time", unit="s", ge=0.1, unset="the key q"
    )
    record: Path | None = option(
        None,
        "gait file (.npz) for the telemetry",
        unset="robot-N.npz in the exports of the run",
        placeholder="FILE.npz",
    )

    @classmethod
    def check(cls, individual: "Individual") -> None:
        """Check that the individual is a gait of a robot in MuJoCo."""
        from gaitsim_wire.robots import robot_of

        robot_of(individual.experiment)

    def do(self) -> None:
        """Check the robot, drive it, and save the telemetry."""
        from gaitsim.plugin.commands import INTERRUPTED, read_individual, status
        from gaitsim.plugin.gait import check_folder
        from gaitsim.plugin.runs import command
        from gaitsim_wire.driving import Session
        from gaitsim_wire.terminal import say

        self.check_wire()
        if not sys.stdin.isatty() and self.seconds is None and not self.excite:
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

        def save(session: Session) -> None:
            session.recording.write(path, tuple(calibration.joints))
            found = session.status
            say(
                f"{path}: {found.seconds:.1f} s, {found.late} of {found.frames} frames late, round "
                f"trip {1000 * found.round_trip:.1f} ms. Compare it with the simulation: "
                + command("analyse", self.run, "--gait", path)
            )

        try:
            stopped = self.drive(player, calibration, self.seconds or math.inf, save)
        except KeyboardInterrupt:
            sys.exit(INTERRUPTED)
        if stopped:
            sys.exit(1)

    def _player(self, individual: "Individual") -> "tuple[Player, Calibration]":
        """Return the source of the angles, and the calibration.

        Raises:
            GaitsimError: the gait cannot follow commands, or needs a sensor that no bus has.
        """
        from gaitsim.plugin.commands import notice
        from gaitsim.plugin.gait import gait_of
        from gaitsim_hardware.c_code import with_rhythm
        from gaitsim_wire.driving import GaitPlayer, excitation
        from gaitsim_wire.robots import calibration_of, pilot_of, robot_of

        if self.tape:
            if other := self.flags_of("walk", "excite"):
                flags = f"--tape and {other[0]}"
                raise GaitsimError(f"{flags} cannot be combined", where=flags.replace(" and", ","))
            return self.tape_of(gait_of(individual), self.speed or 1.0, repeat=True)
        if self.speed is not None:
            raise GaitsimError("--speed is for --tape", where="--speed", remedy="add --tape")
        individual, notices = with_rhythm(individual.embodied)
        for text in notices:
            notice(text)
        robot = robot_of(individual.experiment)
        calibration = calibration_of(robot, self.bus, self.calibration)
        imu = self.imu or self.bus == "serial"
        pilot = pilot_of(robot, individual.genome, imu=imu)
        script = excitation() if self.excite else ()
        return GaitPlayer(pilot, imu=imu, walk=self.walk, script=script), calibration


def _next_recording(individual: "Individual") -> Path:
    """Return a new file in the exports of the individual's run, or in the current folder."""
    from gaitsim.plugin.runs import exports_folder

    source = individual.source
    folder = exports_folder(source) if source is not None and source.is_dir() else Path()
    number = 1
    while (path := folder / f"robot-{number}.npz").exists():
        number += 1
    return path

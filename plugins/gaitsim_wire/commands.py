"""`gaitsim robots emulate` and `gaitsim drive`."""

import math
from pathlib import Path
from typing import Literal

from gaitsim.actions.action import SET, Action, argument
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names

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


def default_baud(bus: str) -> int:
    """Return the usual baud rate of a bus."""
    return 115_200 if bus == "serial" else 1_000_000

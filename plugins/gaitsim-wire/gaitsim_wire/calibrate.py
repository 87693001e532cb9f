"""`gaitsim robots calibrate`."""

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import GaitsimError, option
from gaitsim.plugin.commands import Action, argument
from gaitsim_wire.commands import Drive
from gaitsim_wire.wire import BAUD, BUS, PORT, Bus, baud_of

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Individual


class Calibrate(Action):
    """Calibrate a real robot by hand: find direction, zero and limits of each servo.

    On a screen, a picture of the robot shows what each joint should do, while you turn its servo
    with the arrow keys. Torque is on for this servo only; Space switches it off. Each finished
    joint is saved at once, so you can quit and continue later. At the end, the robot stands and
    sways each joint a little. Hang the robot up.

    The ids of the servos are found, too. Hobby servos (--bus serial) do not report their angles,
    so they are calibrated by editing a template: see 'From simulation to your robot' in the docs.

    [bold]Examples[/bold]

    gaitsim robots calibrate hexapod --port /dev/ttyUSB0 --calibration robot.toml

    gaitsim robots calibrate hexapod --port /dev/ttyUSB0 --joint "L1 femur"

    gaitsim robots calibrate my_robot.urdf --bus dynamixel --port /dev/ttyUSB0
    """

    title: ClassVar[str] = "Calibrate the robot"
    menu: ClassVar[str] = "Robot"
    remembered: ClassVar[tuple[str, ...]] = ("port", "calibration", "bus", "baud", "imu")
    terminal: ClassVar[bool] = True

    model: str = argument(
        "name of a preset with a robot, path of a TOML file or a robot file such as URDF, or "
        "folder of a run",
        "MODEL",
        completion="preset_names",
    )
    port: str = PORT
    calibration: Path = option(
        Path("robot.toml"),
        "calibration file (TOML) to write or continue; joints in it are done",
        placeholder="FILE",
    )
    bus: Bus = BUS
    baud: int | None = BAUD
    joint: str | None = option(None, "begin with this joint, again if it is done")
    again: bool = option(False, "calibrate the joints in the file again")

    @classmethod
    def check(cls, individual: "Individual") -> None:
        """Check that the individual is a gait of a robot in MuJoCo."""
        Drive.check(individual)

    def do(self) -> None:
        """Check the servos, and open the screen."""
        import sys
        from threading import Thread

        from gaitsim.plugin.commands import check_terminal, echo, run_app, status
        from gaitsim.plugin.runs import EXPERIMENT, command, load_experiment
        from gaitsim_wire.calibrating import Calibrator
        from gaitsim_wire.ports import open_port
        from gaitsim_wire.robots import robot_of
        from gaitsim_wire.terminal import deadman

        if self.bus == "serial":
            raise GaitsimError(
                "hobby servos do not report their angles, so they cannot be calibrated by hand",
                where="--bus",
                allowed="feetech, dynamixel",
                remedy="write a template with 'gaitsim export RUN --format arduino "
                "--calibration-template FILE', and complete it",
            )
        baud = baud_of(self.bus, self.baud)
        check_terminal("start the command in a terminal, or complete a calibration template")
        from gaitsim.screen import GaitsimApp, config_path, read_config
        from gaitsim_wire.calibration_screen import CalibrationScreen

        with status("Preparing the robot …"):
            run = Path(self.model) / EXPERIMENT
            robot = robot_of(load_experiment(str(run) if run.is_file() else self.model))
        with closing(open_port(self.port, baud)) as port:
            with status("Looking for the servos …"):
                calibrator = Calibrator(
                    robot, self.bus, port, baud, self.calibration, again=self.again
                )
            if self.joint is not None:
                calibrator.choose(self.joint)
            wire = ["--port", self.port, "--bus", self.bus, "--calibration", self.calibration]
            wire += ["--baud", baud] if self.baud else []
            line = command("robots", "calibrate", self.model, *wire)
            after = command("drive", "RUN", *wire)
            app = GaitsimApp(
                config=read_config(config_path()),
                first=lambda: CalibrationScreen(calibrator, line, after),
            )
            thread = Thread(target=calibrator.run)
            sys.setswitchinterval(0.0005)  # s; drawing must not delay the wire
            with deadman(port.fileno(), calibrator.off_frame()):
                thread.start()
                try:
                    run_app(app)
                finally:
                    calibrator.closed = True
                    thread.join()
        done = len(calibrator.done)
        echo(f"{self.calibration}: {done} of {len(calibrator.names)} joints are calibrated.")

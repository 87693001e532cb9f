"""A real robot on a serial port: the options that describe it, and a drive of it."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from pydantic import BaseModel

from gaitsim.plugin import GaitsimError, option

if TYPE_CHECKING:
    from gaitsim.plugin.gait import Gait
    from gaitsim_hardware.calibration import Calibration
    from gaitsim_wire.driving import Player, Session, Tape

Bus = Literal["feetech", "dynamixel", "serial"]
PORT: str = option(..., "serial port, such as /dev/ttyUSB0", placeholder="PATH")
BUS: Bus = option("feetech", "kind of the wire")
BAUD: int | None = option(
    None,
    "baud rate",
    unset="1000000; 115200 for serial",
    allowed="a usual baud rate, such as 57600, 115200, 500000 or 1000000",
)


def baud_of(bus: Bus, baud: int | None) -> int:
    """Return a baud rate, or the usual one of a bus for None.

    Raises:
        GaitsimError: no bus has this rate.
    """
    from gaitsim_wire.ports import check_baud

    return check_baud(baud or (115_200 if bus == "serial" else 1_000_000))


class WireOptions(BaseModel):
    """The options of a robot on a serial port."""

    port: str = PORT
    calibration: Path = option(
        ..., "calibration file (TOML), which assigns a servo to each joint", placeholder="FILE"
    )
    bus: Bus = BUS
    baud: int | None = BAUD
    imu: bool = option(False, "read an IMU at the id 200 of a servo bus")
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

    def check_wire(self) -> int:
        """Return the baud rate.

        Raises:
            GaitsimError: it is not a usual one.
        """
        return baud_of(self.bus, self.baud)

    def tape_of(
        self, gait: "Gait", speed: float = 1.0, *, repeat: bool = False
    ) -> "tuple[Tape, Calibration]":
        """Return a gait as a source of joint angles, and the calibration of its joints.

        Args:
            gait: gait to play.
            speed: playback speed.
            repeat: whether to repeat a gait that has cycles.

        Raises:
            GaitsimError: the calibration is invalid, or a servo cannot follow the gait.
        """
        from gaitsim_hardware.calibration_file import read_calibration
        from gaitsim_hardware.keyframes import find_loop, keyframes_of
        from gaitsim_wire.driving import Tape
        from gaitsim_wire.robots import FORMATS

        calibration = read_calibration(self.calibration, FORMATS[self.bus], gait.joint_names)
        loop = find_loop(gait.angles, gait.frame_rate) if repeat else None
        return Tape(keyframes_of(gait, calibration, 20, speed=speed, loop=loop), calibration), (
            calibration
        )

    def drive(
        self,
        player: "Player",
        calibration: "Calibration",
        seconds: float = math.inf,
        save: "Callable[[Session], None]" = lambda session: None,
    ) -> str:
        """Check the robot on the wire, and drive it in the terminal.

        Args:
            player: source of the joint angles.
            calibration: calibration of its joints.
            seconds: time after which the robot lies down, s.
            save: function that saves the telemetry, called when the servos are off.

        Returns:
            Why the robot was stopped, a clause; '' if it has lain down.

        Raises:
            GaitsimError: the robot is not the one of the calibration, or cannot be reached.
            KeyboardInterrupt: the user stopped the robot.
        """
        from gaitsim.plugin.commands import interruptible, notice, status
        from gaitsim_wire.driving import LEAST_VOLTS, SafetyLimits, Session, Stopped
        from gaitsim_wire.ports import open_port
        from gaitsim_wire.robots import bus_of
        from gaitsim_wire.terminal import deadman, poller, raw_keys, say

        baud, names = self.check_wire(), tuple(calibration.joints)
        volts = LEAST_VOLTS[self.bus] if self.min_voltage is None else self.min_voltage
        session: Session | None = None
        stopped = ""
        try:
            with interruptible(), open_port(self.port, baud) as port:
                bus = bus_of(self.bus, port, baud, calibration, imu=self.imu)
                bus.off()
                with status("Checking the servos …"):
                    bus.check()
                if self.bus != "serial" and not self.imu:
                    notice("Without --imu, tipping over is not noticed.")
                session = Session(
                    bus, player, calibration, SafetyLimits(self.max_temperature, volts)
                )
                with deadman(port.fileno(), bus.off_frame()), raw_keys() as keys:
                    session.run(poller(player, keys, names, seconds))
            say("The robot has lain down; its servos are off.")
        except Stopped as stop:
            stopped = str(stop)
            say(f"Stopped: {stopped}. The servos are off.")
        except KeyboardInterrupt:
            say("Stopped; the servos are off.")
            raise
        except OSError as error:
            raise GaitsimError(f"the port was lost ({error})", where="--port") from None
        finally:
            if session is not None and len(session.recording):
                save(session)
        return stopped

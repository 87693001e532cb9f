"""Gaits for real robots: servo tables, C code, Arduino sketches, bus servos and ROS 2."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import Exported, Exporter, GaitsimError, Subject, option

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Individual
    from gaitsim_hardware.calibration import Calibration


class JointExporter(Exporter):
    """A file with which a robot plays the joint angles of a gait."""

    group: ClassVar[str] = "Files for robots"
    format: ClassVar[str]
    keyframe_ms: int | None = option(
        None, "milliseconds between keyframes", ge=1, le=60_000, unset="every frame"
    )
    speed: float = option(1.0, "playback speed; 0.5 is half as fast as simulated", ge=0.01, le=100)

    def check(self, individual: "Individual") -> None:
        """Check that the body has joint angles."""
        from gaitsim.plugin.gait import gait_of

        gait_of(individual)


class Ros2(JointExporter):
    """A gait as the goal of a ROS 2 action, as YAML."""

    title: ClassVar[str] = "ROS 2 trajectory"
    note: ClassVar[str] = "action goal as YAML"
    suffix: ClassVar[str] = ".yaml"

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the goal."""
        from gaitsim_hardware.ros import export_goal

        return export_goal(subject.individual, path, self.keyframe_ms, self.speed)


class CalibratedExporter(JointExporter):
    """A file with angles or positions of servos."""

    calibration: Path | None = option(
        None,
        "calibration file (TOML), which assigns a servo to each joint",
        unset="all servos at their centre in the standing pose",
        placeholder="FILE",
    )
    clip: bool = option(
        False, "clip angles to the range of the servos instead of reporting an error"
    )

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file or folder."""
        from gaitsim_hardware.exporting import export_keyframes

        servos, timing = self.servos(subject), (self.keyframe_ms, self.speed)
        return export_keyframes(
            subject.individual, self.format, path, servos, *timing, clip=self.clip
        )

    def servos(self, subject: Subject) -> "Calibration | Path | None":
        """Return the calibration of the servos, its file, or None for centred servos."""
        return self.calibration


class BusExporter(CalibratedExporter):
    """A file for servos whose calibration can be filled in from a template."""

    calibration_template: Path | None = option(
        None,
        "write a template of a calibration file, to be filled in, and export nothing",
        placeholder="FILE",
        written=True,
    )

    @property
    def other_file(self) -> Path | None:
        """The calibration template, if one is asked for."""
        return self.calibration_template

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file or folder, or the calibration template."""
        from gaitsim_hardware.exporting import export_template

        if self.calibration_template is None:
            return super().write(subject, path)
        if self.model_dump(exclude_unset=True).keys() - {"calibration_template"}:
            raise GaitsimError(
                "--calibration-template cannot be combined with options for robots",
                where="--calibration-template",
                allowed="--generation or --member",
            )
        return export_template(subject.individual, self.format, path)


class Arduino(BusExporter):
    """A sketch for Arduino boards with PCA9685 servo drivers."""

    title: ClassVar[str] = "Arduino sketch"
    note: ClassVar[str] = "sketch for PCA9685 boards"
    suffix: ClassVar[str] = ""
    format: ClassVar[str] = "arduino"
    stream: bool = option(
        False,
        "write a sketch that plays what 'gaitsim drive --bus serial' sends, instead of a gait",
    )

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the folder, or the calibration template."""
        from gaitsim_hardware.exporting import export_controller, export_receiver, feels

        if self.stream and self.calibration_template is None:
            if unused := self.model_dump(exclude_unset=True).keys() - {"stream", "calibration"}:
                flags = " or ".join(f"--{name.replace('_', '-')}" for name in sorted(unused))
                raise GaitsimError(f"--stream cannot be combined with {flags}", where="--stream")
            return export_receiver(subject.individual, path, self.calibration)
        if self.calibration_template is not None or not feels(subject.individual):
            return super().write(subject, path)
        if unused := {"keyframe_ms", "speed"} & self.model_dump(exclude_unset=True).keys():
            raise GaitsimError(
                f"a gait with reflexes or a drive has no {' or '.join(sorted(unused))}",
                where="--format arduino",
                remedy="omit it: the sketch computes the gait from commands",
            )
        return export_controller(subject.individual, path, self.calibration, clip=self.clip)

    def file_name(self, subject: Subject) -> str:
        """Return the default name of the folder, which is also the name of the sketch."""
        from gaitsim_hardware.arduino import MAX_NAME

        return re.sub(r"[^0-9A-Za-z]+", "_", super().file_name(subject))[:MAX_NAME]


class ControllerExporter(Exporter):
    """Files with which a robot's gait feels and follows commands.

    A gait of the spider becomes one of its twin in physics, with the reflex `heading`.
    """

    group: ClassVar[str] = "Files for robots"
    suffix: ClassVar[str] = ""

    def check(self, individual: "Individual") -> None:
        """Check that gaits of the body follow commands."""
        from gaitsim_hardware.c_code import check_controller

        check_controller(individual)


class C99(ControllerExporter):
    """A gait with its reflexes as C99, which follows commands on a microcontroller."""

    title: ClassVar[str] = "C code"
    note: ClassVar[str] = "C99, for gaits with reflexes"

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the folder with gait.h and gait.c."""
        from gaitsim_hardware.c_code import export_c

        return export_c(subject.individual, path)


class Ros2Package(ControllerExporter):
    """A gait with its reflexes as a ROS 2 package, which follows `cmd_vel`."""

    title: ClassVar[str] = "ROS 2 package"
    note: ClassVar[str] = "node for gaits with reflexes, and URDF"

    def file_name(self, subject: Subject) -> str:
        """Return the default name of the folder, which is also the name of the package."""
        return re.sub(r"[^0-9a-z]+", "_", super().file_name(subject).lower()).strip("_")

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the folder."""
        from gaitsim_hardware.ros2_package import export_package

        return export_package(subject.individual, path)


class RobotFile(Exporter):
    """The robot itself, with the dimensions of the individual."""

    group: ClassVar[str] = "Robots"
    stem: ClassVar[str] = "robot"
    format: ClassVar[str]

    def check(self, individual: "Individual") -> None:
        """Check that the body has a description."""
        from gaitsim_hardware.robot_files import check_robot

        check_robot(individual, self.format)

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the file."""
        from gaitsim_hardware.robot_files import export_robot

        return export_robot(subject.individual, self.format, path)


class Mjcf(RobotFile):
    """The robot as MJCF, for MuJoCo and for `gaitsim run`, which plays the same motion."""

    title: ClassVar[str] = "Robot as MJCF"
    note: ClassVar[str] = "for MuJoCo and gaitsim run"
    suffix: ClassVar[str] = ".xml"
    format: ClassVar[str] = "mjcf"


class Urdf(RobotFile):
    """The robot as URDF, with its meshes in metres, for CAD, ROS and simulators."""

    title: ClassVar[str] = "Robot as URDF"
    note: ClassVar[str] = "for ROS and simulators"
    suffix: ClassVar[str] = ".urdf"
    format: ClassVar[str] = "urdf"


class Dynamixel(BusExporter):
    """Goal positions of Dynamixel servos, as CSV."""

    title: ClassVar[str] = "Dynamixel positions"
    note: ClassVar[str] = "CSV with goal positions"
    suffix: ClassVar[str] = ".dynamixel.csv"
    format: ClassVar[str] = "dynamixel"


class Feetech(BusExporter):
    """Goal positions of Feetech servos, as CSV."""

    title: ClassVar[str] = "Feetech positions"
    note: ClassVar[str] = "CSV with goal positions"
    suffix: ClassVar[str] = ".feetech.csv"
    format: ClassVar[str] = "feetech"


class ServoTable(CalibratedExporter):
    """Angles of servos, as CSV."""

    title: ClassVar[str] = "Servo keyframes"
    note: ClassVar[str] = "CSV in degrees"
    suffix: ClassVar[str] = ".servo.csv"
    format: ClassVar[str] = "servo"
    centre: float = option(  # controllers count from any angle; the bounds only stop typing errors
        0.0, "servo angle when the joint is at zero", unit="°", ge=-36_000, le=36_000
    )
    min: float | None = option(None, "minimum servo angle", unit="°", unset="centre − 90")
    max: float | None = option(None, "maximum servo angle", unit="°", unset="centre + 90")

    def servos(self, subject: Subject) -> "Calibration | Path | None":
        """Return the calibration of the servos, or its file."""
        from gaitsim.plugin.gait import gait_of
        from gaitsim_hardware.calibration import HALF_RANGE, uniform_calibration

        uniform = [
            f"--{name}"
            for name in self.model_dump(exclude_unset=True)
            if name in ("centre", "min", "max")
        ]
        if self.calibration is not None and uniform:
            raise GaitsimError(
                f"--calibration sets the ranges of the servos, so it cannot be combined with "
                f"{' and '.join(uniform)}",
                remedy=f"set the ranges in the calibration, and omit {' and '.join(uniform)}",
            )
        if self.calibration is not None:
            return self.calibration
        low = self.centre - HALF_RANGE if self.min is None else self.min
        high = self.centre + HALF_RANGE if self.max is None else self.max
        names = gait_of(subject.individual).joint_names
        return uniform_calibration(names, self.centre, low, high)

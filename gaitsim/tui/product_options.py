"""Options of the commands that export files from a run.

They are declared like options of plugins, so the same forms show them.
"""

from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from gaitsim.choices import (
    Axis,
    CalibratedFormat,
    GaitFormat,
    PlotFormat,
    Quantity,
    Theme,
    VideoFormat,
    VideoView,
)
from gaitsim.runs.files.folder import EXPORTS

Generation = Annotated[
    int | None, Field(ge=1, description="Its best individual. None: the champion.")
]
Member = Annotated[
    int | None, Field(ge=1, description="Member of a front or archive, as in gaitsim members.")
]
Damage = Annotated[
    str | None, Field(description="Damage to the body, such as L2 lost, R1 femur stuck 20.")
]
World = Annotated[
    str | None, Field(description="Conditions of the world, such as friction 0.4, slope 2.")
]
Engine = Annotated[
    str | None, Field(description="Physics engine of a robot, such as bullet. None: its own.")
]
Generations = Annotated[
    str | None, Field(description="Best individuals of generations, such as 1,50,300.")
]


class Settings(BaseModel):
    """The options of a command; those that differ from the defaults become arguments."""

    model_config = ConfigDict(extra="forbid", coerce_numbers_to_str=True)

    def subject(self, run: Path) -> Path:
        """Return the command's subject: the run, unless an option names another."""
        return run

    def words(self, run: Path) -> list[str]:
        """Return the options as arguments of the command line."""
        return self._flags()

    def _flags(self, *without: str) -> list[str]:
        """Return the options as flags, without some."""
        found = []
        for name, value in self.model_dump(exclude=set(without), exclude_defaults=True).items():
            flag = name.replace("_", "-")
            if name in ("damage", "world"):
                found += [f"--{flag}={one}" for one in split_names(value)]
            elif isinstance(value, bool):
                found.append(f"--{flag}" if value else f"--no-{flag}")
            elif value is not None:
                found += [f"--{flag}", str(value)]
        return found


class GaitFile(Settings):
    format: Annotated[GaitFormat, Field(description="MATLAB and Octave, CSV or NumPy.")] = "mat"
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None


class ForRobot(Settings):
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    keyframe_ms: Annotated[
        int | None,
        Field(
            ge=1,
            le=60_000,
            description="Time between two keyframes. None: every frame.",
            json_schema_extra={"unit": "ms"},
        ),
    ] = None
    speed: Annotated[
        float | None,
        Field(ge=0.01, le=100, description="0.5 is half speed. None: as simulated."),
    ] = None


class Bag(ForRobot):
    pass


class Body(Settings):
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    engine: Engine = None


class Events(Settings):
    pass


class Page(Body):
    generations: Annotated[
        str | None, Field(description="Best individuals side by side, such as 1,50,300.")
    ] = None


class Archive(Settings):
    """A page of a whole archive has no options."""


class Calibrated(ForRobot):
    calibration: Annotated[
        str | None,
        Field(description="File with the servo of each joint. None: centred when standing."),
    ] = None
    clip: Annotated[bool, Field(description="Clip angles to the range.")] = False


class Servo(Calibrated):
    centre: Annotated[float | None, Field(description="Degrees of a joint at zero.")] = None
    min: Annotated[float | None, Field(description="Minimum degrees of the servos.")] = None
    max: Annotated[float | None, Field(description="Maximum degrees of the servos.")] = None


class Template(Settings):
    format: Annotated[
        CalibratedFormat, Field(description="PCA9685 boards, or the family of a servo bus.")
    ] = "arduino"
    calibration_template: Annotated[
        str | None, Field(description="File to create. None: in the run's exports folder.")
    ] = None
    generation: Generation = None
    member: Member = None

    def words(self, run: Path) -> list[str]:
        """Return the options, with the format and the file."""
        file = self.calibration_template or str(run / EXPORTS / f"calibration-{self.format}.toml")
        given = self._flags("format", "calibration_template")
        return [*given, "--format", self.format, "--calibration-template", file]


class Plot(Settings):
    theme: Annotated[Theme, Field(description="Colours.")] = "light"
    format: Annotated[PlotFormat, Field(description="PNG at 300 dpi, or vector formats.")] = "png"
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    generations: Generations = None
    window: Annotated[
        str | None, Field(description="Part of the motion in seconds, such as 2:5.")
    ] = None
    channel: Annotated[
        str | None, Field(description="Channel of the motion; an invalid name lists all.")
    ] = None
    component: Annotated[
        str | None, Field(description="Components, such as z or 'L1 coxa, R1 coxa'. None: all.")
    ] = None

    axes: Annotated[
        str | None,
        Field(
            description="Two axes of the archive, such as forward, yaw. None: all pairs.",
            pattern=r"^[^,]*[^, ][^,]*,[^,]*[^, ][^,]*$",
        ),
    ] = None
    beside: Annotated[
        str | None, Field(description="Other runs, each with its repeats, separated by spaces.")
    ] = None

    def words(self, run: Path) -> list[str]:
        """Return the options, with one flag per component and run."""
        return [
            *self._flags("component", "beside", "axes"),
            *(["--axes", *split_names(self.axes)] if self.axes else []),
            *(f"--component={name}" for name in split_names(self.component)),
            *(f"--beside={other}" for other in split_words(self.beside or "")),
        ]


class Video(Settings):
    format: Annotated[VideoFormat, Field(description="H.264, or GIF for slides.")] = "mp4"
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    engine: Engine = None
    generations: Annotated[
        str | None, Field(description="Best individuals in a race, such as 1,50,300.")
    ] = None
    view: Annotated[VideoView, Field(description="Direction of the camera.")] = "iso"
    theme: Annotated[Theme, Field(description="Colours.")] = "light"
    speed: Annotated[
        float | None,
        Field(gt=0, description="0.25 is slow motion. None: real time, or slow for wing beats."),
    ] = None
    intro: Annotated[bool, Field(description="Start with the fitness curve.")] = True
    size: Annotated[str | None, Field(description="Pixels, such as 1280x720.")] = None
    fps: Annotated[float | None, Field(gt=0, description="Frames per second.")] = None


class Analysis(Settings):
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    engine: Engine = None
    perturb: Annotated[bool, Field(description="Repeat it with delayed and inexact servos.")] = (
        False
    )
    physics: Annotated[bool, Field(description="Also play it on the body's twin in physics.")] = (
        False
    )
    worlds: Annotated[
        int | None,
        Field(ge=1, le=10_000, description="Number of unseen worlds to play it in."),
    ] = None
    world_seed: Annotated[int | None, Field(ge=0, description="Seed of these worlds.")] = None
    workers: Annotated[
        int | None, Field(ge=1, le=1024, description="Number of worlds played in parallel.")
    ] = None
    figure: Annotated[
        PlotFormat | None,
        Field(description="Format of a figure of footfalls, phases and stability."),
    ] = None
    gait: Annotated[
        str | None, Field(description="File of joint angles to play instead: .npz, .csv or .mat.")
    ] = None

    def words(self, run: Path) -> list[str]:
        """Return the options, with the file of the figure."""
        found = self._flags("figure")
        if self.figure:
            which = f"-generation-{self.generation}" if self.generation else ""
            which = f"-member-{self.member}" if self.member else which
            found += ["--figure", str(run / EXPORTS / f"analysis{which}.{self.figure}")]
        return found


class Differences(Settings):
    runs: Annotated[
        str, Field(min_length=1, description="The other runs, such as spider-2 spider-3.")
    ] = ""
    quantity: Annotated[Quantity, Field(description="Quantity to plot.")] = "best"
    by: Annotated[Axis, Field(description="Horizontal axis.")] = "generation"
    theme: Annotated[Theme, Field(description="Colours.")] = "light"
    format: Annotated[PlotFormat, Field(description="File format of the figure.")] = "png"

    def words(self, run: Path) -> list[str]:
        """Return the other runs, the options, and the file of the figure."""
        figure = run / EXPORTS / f"differences.{self.format}"
        return [*split_words(self.runs), *self._flags("runs", "format"), "--plot", str(figure)]


def split_names(text: str | None) -> list[str]:
    """Return the comma-separated names in a text; names may contain spaces."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]


def split_words(text: str) -> list[str]:
    """Return the words of a text; quoted words may contain spaces."""
    import shlex

    try:
        return shlex.split(text)
    except ValueError:  # a missing quotation mark
        return [text]

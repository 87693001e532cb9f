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
    int | None,
    Field(ge=1, description="generation whose best individual is used; none: the champion"),
]
Member = Annotated[
    int | None,
    Field(
        ge=1,
        description="member of the front or archive, as listed by 'gaitsim members'; "
        "none: the champion",
    ),
]
Damage = Annotated[
    str | None, Field(description="damage to the body, such as 'L2 lost, R1 femur stuck 20'")
]
World = Annotated[
    str | None, Field(description="conditions of the world, such as 'friction 0.4, slope 2'")
]
Engine = Annotated[
    str | None,
    Field(description="physics engine for a robot, such as 'bullet'; none: the robot's own"),
]
Generations = Annotated[
    str | None,
    Field(description="generations whose best individuals are plotted, such as 1,50,300"),
]


class Settings(BaseModel):
    """The options of a command; those that differ from the defaults become arguments."""

    model_config = ConfigDict(extra="forbid", coerce_numbers_to_str=True)

    def subject(self, run: Path) -> Path:
        """Return the path that the command reads: the run, unless an option names a file."""
        return run

    def arguments(self, run: Path) -> list[str]:
        """Return the options as arguments of the command line."""
        return self._flags()

    def _flags(self, *excluded: str) -> list[str]:
        """Return the options as flags, except the excluded ones."""
        found = []
        for name, value in self.model_dump(exclude=set(excluded), exclude_defaults=True).items():
            flag = name.replace("_", "-")
            if name in ("damage", "world"):
                found += [f"--{flag}={one}" for one in split_names(value)]
            elif isinstance(value, bool):
                found.append(f"--{flag}" if value else f"--no-{flag}")
            elif value is not None:
                found += [f"--{flag}", str(value)]
        return found


class GaitFile(Settings):
    format: Annotated[
        GaitFormat, Field(description="'mat' for MATLAB and Octave, 'csv', or 'npz' for NumPy")
    ] = "mat"
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None


class RobotFile(Settings):
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    keyframe_ms: Annotated[
        int | None,
        Field(
            ge=1,
            le=60_000,
            description="time between two keyframes; none: every frame",
            json_schema_extra={"unit": "ms"},
        ),
    ] = None
    speed: Annotated[
        float | None,
        Field(
            ge=0.01, le=100, description="playback speed; 0.5 is half as fast as simulated; none: 1"
        ),
    ] = None


class Bag(RobotFile):
    pass


class BodyFile(Settings):
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    engine: Engine = None


class Events(Settings):
    pass


class Page(BodyFile):
    generations: Annotated[
        str | None,
        Field(
            description="generations whose best individuals are shown side by side, "
            "such as 1,50,300"
        ),
    ] = None


class Archive(Settings):
    """A page of a whole archive has no options."""


class CalibratedFile(RobotFile):
    calibration: Annotated[
        str | None,
        Field(
            description="calibration file, which assigns a servo to each joint; none: all servos "
            "centred in the standing pose"
        ),
    ] = None
    clip: Annotated[
        bool, Field(description="whether to clip angles to the range of the servos")
    ] = False


class Servo(CalibratedFile):
    centre: Annotated[
        float | None,
        Field(description="servo angle, in degrees, when the joint is at zero; none: 0"),
    ] = None
    min: Annotated[
        float | None, Field(description="minimum servo angle in degrees; none: centre − 90")
    ] = None
    max: Annotated[
        float | None, Field(description="maximum servo angle in degrees; none: centre + 90")
    ] = None


class Template(Settings):
    format: Annotated[
        CalibratedFormat, Field(description="hardware: PCA9685 boards, or a family of bus servos")
    ] = "arduino"
    calibration_template: Annotated[
        str | None, Field(description="file to create; none: in the run's exports folder")
    ] = None
    generation: Generation = None
    member: Member = None

    def arguments(self, run: Path) -> list[str]:
        """Return the options, with the format and the file."""
        file = self.calibration_template or str(run / EXPORTS / f"calibration-{self.format}.toml")
        given = self._flags("format", "calibration_template")
        return [*given, "--format", self.format, "--calibration-template", file]


class Plot(Settings):
    theme: Annotated[Theme, Field(description="colour theme")] = "light"
    format: Annotated[PlotFormat, Field(description="'png' at 300 dpi, or a vector format")] = "png"
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    generations: Generations = None
    window: Annotated[
        str | None, Field(description="part of the motion, START:END in seconds, such as 2:5")
    ] = None
    channel: Annotated[
        str | None, Field(description="channel of the motion; an unknown name lists all channels")
    ] = None
    component: Annotated[
        str | None,
        Field(description="components of the channel, such as z or 'L1 coxa, R1 coxa'; none: all"),
    ] = None
    axes: Annotated[
        str | None,
        Field(
            description="two axes of the archive, such as 'forward, yaw'; none: all pairs",
            pattern=r"^[^,]*[^, ][^,]*,[^,]*[^, ][^,]*$",
        ),
    ] = None
    beside: Annotated[
        str | None,
        Field(description="other runs, separated by spaces, each plotted with its repeats"),
    ] = None

    def arguments(self, run: Path) -> list[str]:
        """Return the options, with one flag per component and run."""
        return [
            *self._flags("component", "beside", "axes"),
            *(["--axes", *split_names(self.axes)] if self.axes else []),
            *(f"--component={name}" for name in split_names(self.component)),
            *(f"--beside={other}" for other in split_words(self.beside or "")),
        ]


class Video(Settings):
    format: Annotated[VideoFormat, Field(description="'mp4' (H.264), or 'gif' for slides")] = "mp4"
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    engine: Engine = None
    generations: Annotated[
        str | None, Field(description="generations whose best individuals race, such as 1,50,300")
    ] = None
    view: Annotated[VideoView, Field(description="direction of the camera")] = "iso"
    theme: Annotated[Theme, Field(description="colour theme")] = "light"
    speed: Annotated[
        float | None,
        Field(
            gt=0,
            description="playback speed; 0.25 is slow motion; none: real time, or slow motion for "
            "wing beats",
        ),
    ] = None
    intro: Annotated[bool, Field(description="whether to begin with the fitness curve")] = True
    size: Annotated[str | None, Field(description="size in pixels, such as 1280x720")] = None
    fps: Annotated[
        float | None, Field(gt=0, description="frames per second; none: 30, or 25 for a GIF")
    ] = None


class Analysis(Settings):
    generation: Generation = None
    member: Member = None
    damage: Damage = None
    world: World = None
    engine: Engine = None
    perturb: Annotated[
        bool,
        Field(
            description="whether to repeat the gait with delayed, slow and inaccurate servos, "
            "mirrored, and with half the time step"
        ),
    ] = False
    physics: Annotated[
        bool,
        Field(
            description="whether to also play the gait on the body's twin, its version in "
            "rigid-body physics"
        ),
    ] = False
    worlds: Annotated[
        int | None,
        Field(ge=1, le=10_000, description="number of unseen worlds in which to evaluate the gait"),
    ] = None
    world_seed: Annotated[
        int | None, Field(ge=0, description="seed of the unseen worlds; none: 0")
    ] = None
    workers: Annotated[
        int | None, Field(ge=1, le=1024, description="number of parallel workers")
    ] = None
    figure: Annotated[
        PlotFormat | None,
        Field(description="format of a figure of footfalls, phases and stability; none: no figure"),
    ] = None
    gait: Annotated[
        str | None,
        Field(description="gait file to play instead of the individual: .npz, .csv or .mat"),
    ] = None

    def arguments(self, run: Path) -> list[str]:
        """Return the options, with the file of the figure."""
        found = self._flags("figure")
        if self.figure:
            which = f"-generation-{self.generation}" if self.generation else ""
            which = f"-member-{self.member}" if self.member else which
            found += ["--figure", str(run / EXPORTS / f"analysis{which}.{self.figure}")]
        return found


class Differences(Settings):
    runs: Annotated[
        str, Field(min_length=1, description="other runs, such as spider-2 spider-3")
    ] = ""
    quantity: Annotated[Quantity, Field(description="quantity to plot")] = "best"
    by: Annotated[Axis, Field(description="horizontal axis")] = "generation"
    theme: Annotated[Theme, Field(description="colour theme")] = "light"
    format: Annotated[PlotFormat, Field(description="file format of the figure")] = "png"

    def arguments(self, run: Path) -> list[str]:
        """Return the other runs, the options, and the file of the figure."""
        figure = run / EXPORTS / f"differences.{self.format}"
        return [*split_words(self.runs), *self._flags("runs", "format"), "--plot", str(figure)]


def split_names(text: str | None) -> list[str]:
    """Return the comma-separated names in a string; names may contain spaces."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]


def split_words(text: str) -> list[str]:
    """Return the words of a string; quoted words may contain spaces."""
    import shlex

    try:
        return shlex.split(text)
    except ValueError:  # a quotation mark is missing
        return [text]

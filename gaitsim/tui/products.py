"""Everything that gaitsim makes of a run: the commands, with the options that a user may change.

Options are declared as plugins declare theirs, so the same forms show them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.fields import FieldInfo

from gaitsim.choices import (
    Activation,
    Axis,
    GaitFormat,
    OutputActivation,
    PlotFormat,
    PlotKind,
    Quantity,
    Theme,
    TrainingPreset,
    VideoFormat,
    VideoView,
)
from gaitsim.errors import GaitsimError
from gaitsim.registry import options
from gaitsim.runs.files.folder import EXPORTS

if TYPE_CHECKING:
    from gaitsim.individual import Individual

Generation = Annotated[int | None, Field(ge=1, description="The best of it. None: of all.")]
Generations = Annotated[str | None, Field(description="The best of several, as 1,50,300.")]
Check = Callable[["Individual"], object]


class Settings(BaseModel):
    """The options of a command that differ from its defaults are its words."""

    model_config = ConfigDict(extra="forbid", coerce_numbers_to_str=True)

    def words(self, run: Path) -> list[str]:
        """Return the options as the command line takes them."""
        return self._flags()

    def _flags(self, *without: str) -> list[str]:
        """Return the options but some, each as a flag."""
        found = []
        for name, value in self.model_dump(exclude=set(without), exclude_defaults=True).items():
            flag = name.replace("_", "-")
            if isinstance(value, bool):
                found.append(f"--{flag}" if value else f"--no-{flag}")
            elif value is not None:
                found += [f"--{flag}", str(value)]
        return found


class GaitFile(Settings):
    format: Annotated[GaitFormat, Field(description="MATLAB and Octave, CSV or NumPy.")] = "mat"
    generation: Generation = None


class Servo(Settings):
    generation: Generation = None
    keyframe_ms: Annotated[
        int | None,
        Field(
            ge=1,
            le=60_000,
            description="Time between two rows. None: every frame.",
            json_schema_extra={"unit": "ms"},
        ),
    ] = None
    centre: Annotated[float | None, Field(description="Degrees of the pose at rest.")] = None
    min: Annotated[float | None, Field(description="Minimum degrees of the servos.")] = None
    max: Annotated[float | None, Field(description="Maximum degrees.")] = None
    clip: Annotated[bool, Field(description="Clip angles beyond the range.")] = False


class Plot(Settings):
    theme: Annotated[Theme, Field(description="Colours.")] = "light"
    format: Annotated[PlotFormat, Field(description="PNG at 300 dots an inch, or vectors.")] = "png"
    generation: Generation = None
    generations: Generations = None
    window: Annotated[str | None, Field(description="A part of the motion in seconds, as 2:5.")] = (
        None
    )
    channel: Annotated[
        str | None, Field(description="Channel of the motion; a wrong name lists them.")
    ] = None
    component: Annotated[
        str | None, Field(description="Components, as z or 'L1 coxa, R1 coxa'. None: all.")
    ] = None

    beside: Annotated[
        str | None, Field(description="Other runs, each with its repeats, separated by spaces.")
    ] = None

    def words(self, run: Path) -> list[str]:
        """Return the options; each component and run has its own."""
        names = [name.strip() for name in (self.component or "").split(",")]
        return [
            *self._flags("component", "beside"),
            *(f"--component={name}" for name in names if name),
            *(f"--beside={other}" for other in split_words(self.beside or "")),
        ]


class Video(Settings):
    format: Annotated[VideoFormat, Field(description="H.264, or GIF for slides.")] = "mp4"
    generation: Generation = None
    generations: Annotated[
        str | None, Field(description="The best of several, in a race, as 1,50,300.")
    ] = None
    view: Annotated[VideoView, Field(description="Direction of the camera.")] = "iso"
    theme: Annotated[Theme, Field(description="Colours.")] = "light"
    speed: Annotated[
        float | None,
        Field(gt=0, description="0.25 is slow motion. None: real time, or slow for wing beats."),
    ] = None
    intro: Annotated[bool, Field(description="Begin with the fitness curve.")] = True
    size: Annotated[str | None, Field(description="Pixels, as 1280x720.")] = None
    fps: Annotated[float | None, Field(gt=0, description="Pictures a second.")] = None


class Analysis(Settings):
    generation: Generation = None
    perturb: Annotated[bool, Field(description="Repeat it with late and inexact servos.")] = False
    figure: Annotated[
        PlotFormat | None, Field(description="A figure of footfalls, phases and stability.")
    ] = None
    gait: Annotated[
        str | None, Field(description="A file of joint angles to play: .npz, .csv or .mat.")
    ] = None

    def words(self, run: Path) -> list[str]:
        """Return the options, with the file of the figure."""
        found = self._flags("figure")
        if self.figure:
            which = f"-generation-{self.generation}" if self.generation else ""
            found += ["--figure", str(run / EXPORTS / f"analysis{which}.{self.figure}")]
        return found


class Imitator(Settings):
    generation: Generation = None
    settings: Annotated[
        TrainingPreset, Field(description="As published, or steadier for a gait that lasts.")
    ] = "source"
    activation: Annotated[Activation | None, Field(description="Of the hidden layer.")] = None
    output: Annotated[OutputActivation | None, Field(description="Of the outputs.")] = None
    hidden: Annotated[int | None, Field(ge=1, le=4096, description="Hidden neurons.")] = None
    epochs: Annotated[int | None, Field(ge=1, le=1_000_000, description="Passes.")] = None
    learning_rate: Annotated[
        float | None, Field(ge=1e-9, le=10, description="Step along the gradient.")
    ] = None
    seed: Annotated[int, Field(ge=0, description="Of weights, order and noise.")] = 0
    compare_activations: Annotated[
        bool, Field(description="Train with all four, and plot their errors.")
    ] = False
    format: Annotated[GaitFormat, Field(description="Of the imitator's gait file.")] = "mat"


class Differences(Settings):
    runs: Annotated[
        str, Field(min_length=1, description="The other runs, such as spider-2 spider-3.")
    ] = ""
    quantity: Annotated[Quantity, Field(description="Quantity to plot.")] = "best"
    by: Annotated[Axis, Field(description="Horizontal axis.")] = "generation"
    theme: Annotated[Theme, Field(description="Colours.")] = "light"
    format: Annotated[PlotFormat, Field(description="Of the figure.")] = "png"

    def words(self, run: Path) -> list[str]:
        """Return the other runs, the options, and the file of the figure."""
        figure = run / EXPORTS / f"differences.{self.format}"
        return [*split_words(self.runs), *self._flags("runs", "format"), "--plot", str(figure)]


@dataclass(frozen=True)
class Product:
    """Something to make of a run.

    Attributes:
        title: its name in a list.
        command: the words of the command, without the run.
        model: the options.
        kind: the kind of plot, where it is one.
    """

    title: str
    command: tuple[str, ...]
    model: type[Settings]
    kind: str = ""

    def fields(self) -> dict[str, FieldInfo]:
        """Return the options that the command reads, by name."""
        known = self.model.model_fields
        if self.model is not Plot:
            return known
        from gaitsim.render.plots.kinds import KINDS, OF_ALL

        read = KINDS[self.kind].options if self.kind in KINDS else OF_ALL
        return {n: f for n, f in known.items() if n in ("theme", "format") or f"--{n}" in read}

    def arguments(self, run: Path, settings: Settings) -> tuple[str, ...]:
        """Return the arguments of `gaitsim`."""
        verb, *more = self.command
        return (verb, str(run), *more, *settings.words(run))

    def read(self, texts: Mapping[str, str]) -> tuple[Settings | None, dict[str, GaitsimError]]:
        """Read typed options; return them, or None and the problems by name."""
        fields = self.fields()
        typed = {name: text.strip() for name, text in texts.items() if name in fields}
        try:
            return self.model.model_validate(
                {name: _value(fields[name], text) for name, text in typed.items()}
            ), {}
        except ValidationError as error:
            names = dict.fromkeys(str(detail["loc"][0]) for detail in error.errors())
        return None, {
            name: GaitsimError(
                f"{typed.get(name, '')!r} is not allowed",
                allowed=options.takes(fields[name]) if typed.get(name) else "a value for it",
            )
            for name in names
        }


def split_words(text: str) -> list[str]:
    """Return the words of a text, where quoted ones may hold spaces."""
    import shlex

    try:
        return shlex.split(text)
    except ValueError:  # a quotation that does not end
        return [text]


def default(field: FieldInfo) -> str:
    """Return the text of an option that nobody changed."""
    return options.written(field, field.get_default())


def _value(field: FieldInfo, text: str) -> Any:
    texts = str in (field.annotation, *get_args(field.annotation))
    return options.fitting(field, text if texts else options.parse_value(text), text)


PLOTS = {
    "fitness": "Fitness curve",
    "terms": "Terms of the score",
    "diversity": "Diversity",
    "genome": "Genome of each best",
    "runs": "Repeats and other runs",
    "front": "Front of objectives",
    "path": "Path in space",
    "channel": "Channel over time",
    "footfall": "Footfalls",
    "phase": "Phases of the feet",
    "joints": "Joint angles",
    "stability": "Stability margin",
}
GROUPS: dict[str, tuple[Product, ...]] = {
    "Gait": (
        Product("Gait file", ("export",), GaitFile),
        Product("Servo keyframes", ("export", "--format", "servo"), Servo),
    ),
    "Plot": (
        *(
            Product(PLOTS.get(kind, kind.capitalize()), ("plot", "--kind", kind), Plot, kind)
            for kind in get_args(PlotKind)
        ),
        Product("All of these", ("plot", "--kind", "all"), Plot, "all"),
    ),
    "More": (
        Product("Video", ("video",), Video),
        Product("Analysis", ("analyse",), Analysis),
        Product("Imitating network", ("imitate",), Imitator),
        Product("Differences of runs", ("differences",), Differences),
    ),
}
PRODUCTS = tuple(product for products in GROUPS.values() for product in products)


def lacking(run: Path) -> dict[Product, GaitsimError]:
    """Return why products cannot be made of a run's champion, as their commands say.

    Raises:
        GaitsimError: nothing can be made: the run has no champion, or its folder is read-only.
    """
    from gaitsim.gait.files.writer import gait_of
    from gaitsim.imitation.imitating import learnable_gait
    from gaitsim.render.plots.kinds import KINDS
    from gaitsim.runs.files.folder import exports_folder
    from gaitsim.runs.snapshot import RunSnapshot

    exports_folder(run)
    champion = RunSnapshot(run).individual()
    checks: Mapping[type[Settings], Check] = {
        GaitFile: gait_of,
        Servo: gait_of,
        Imitator: learnable_gait,
    }
    found = {}
    for product in PRODUCTS:
        kind = KINDS.get(product.kind)
        check = kind.check if kind else checks.get(product.model)
        try:
            if check is not None:
                check(champion)
        except GaitsimError as error:
            found[product] = error
    return found

"""The base of actions, and the options that choose and change the individuals that they show."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Input, Names
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.gait.gait_files import GaitFile
    from gaitsim.individual import Choice, Individual, Member
    from gaitsim.storage.snapshot import RunSnapshot


class Action(BaseModel):
    """A command; its fields are the arguments and options, its docstring is the help.

    Attributes:
        title: name in menus; '' for actions that no menu offers.
        terminal: whether it needs the terminal, and cannot run in the background.
        not_in_forms: options that forms do not show.
        menu: menu of the terminal UI that offers the command of a package: 'More' in the export
            dialog, or a dialog of its own; '' for none.
        remembered: options that forms keep for the next time.
        plugins: kind of plugins whose options the command has, too; '' for none.
    """

    # Only the action that is carried out is built: the others of its module take 2 ms each.
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    title: ClassVar[str] = ""
    menu: ClassVar[str] = ""
    remembered: ClassVar[tuple[str, ...]] = ()
    terminal: ClassVar[bool] = False
    not_in_forms: ClassVar[tuple[str, ...]] = ("out", "json_lines")
    plugins: ClassVar[str] = ""

    def flags_of(self, *names: str) -> list[str]:
        """Return the flags of those of some options that are set."""
        from gaitsim.registry.options import flag

        fields = type(self).model_fields
        return [flag(name, fields[name]) for name in names if getattr(self, name)]

    def do(self) -> None:
        """Carry out the action, and print its results."""
        raise NotImplementedError

    @classmethod
    def check(cls, individual: "Individual") -> None:
        """Check that the action applies to an individual.

        Raises:
            GaitsimError: data are missing, or a package that is needed is not installed.
        """


def argument(
    help: str,
    placeholder: str,
    default: Any = ...,
    *,
    unset: str = "",
    allowed: str = "",
    completion: str = "run_names",
    shown: bool = False,
) -> Any:
    """Declare an argument of an action.

    Args:
        help: description of the argument, a phrase without a full stop.
        placeholder: name of the argument in the help.
        default: value of the argument if it is omitted; `...` for a required argument.
        unset: description of the default, if the default is None.
        allowed: description of the allowed values in forms, if the type does not suffice.
        completion: name of the function in `gaitsim.cli.completion` that completes it; '' for none.
        shown: whether forms show the argument, which is otherwise the run of the form.
    """
    more = {"placeholder": placeholder, "unset": unset, "completion": completion}
    more |= {"allowed": allowed} if allowed else {}
    argument = "shown" if shown else "hidden"
    return Field(default, description=help, json_schema_extra={**more, "argument": argument})


RUN = "name of a run in runs/, or its folder"
RUN_OR_CODE = (
    "name of a run in runs/, or its folder; or a challenge code (from 'gaitsim share'), a file "
    "that contains a code, or '-' to read a code from standard input"
)
EXPERIMENT = "name of a preset, or path of a TOML file or a robot file such as URDF"
GENERATIONS: int | None = option(None, "number of generations")
POPULATION: int | None = option(None, "number of individuals per generation")
SET: Names | None = option(
    None,
    "set an option of the experiment, such as fitness.yaw_weight=8",
    placeholder="KEY=VALUE",
    flag="--set",
)
WORKERS: int | None = option(
    None,
    "maximum number of parallel workers; fewer or none are used if that is faster. Does not affect "
    "the result",
    ge=1,
    le=1024,
)
DASK: str | None = option(
    None,
    "use a Dask cluster: the address of its scheduler, such as tcp://host:8786, or 'local' to "
    "start a cluster on this machine with the number of workers given by --workers. Does not "
    "affect the result",
    placeholder="ADDRESS|local",
)
WORLD_SEED: int | None = option(None, "seed for drawing the worlds of --worlds", unset="0")
JSON: bool = option(False, "print one JSON object per line, for scripts", flag="--json")


class OneRun(Action):
    """An action on a run."""

    run: str = argument(RUN, "RUN")
    json_lines: bool = JSON


NUMBER = r"0*[1-9][0-9]{0,8}"
GENERATION = re.compile(rf"({NUMBER})(?::({NUMBER}|centre))?")
"""A generation, or an individual of it, such as '12', '12:34' or '12:centre'."""


def parse_generations(value: Any) -> Any:
    """Return the text of generations such as '1,50,50:3', without repetitions."""
    parts = [part.strip() for part in str(value).split(",")]
    if not all(map(GENERATION.fullmatch, parts)):
        raise GaitsimError(
            f"invalid list of generations: {value!r}",
            where="--generations",
            allowed="numbers separated by commas, such as 1,50,300, or individuals of generations, "
            "such as 50:3",
        )
    return ",".join(dict.fromkeys(parts))


def parse_generation(value: Any) -> Any:
    """Return the text of a generation such as '12', or of an individual of it such as '12:34'."""
    text = str(value).strip()
    if not GENERATION.fullmatch(text):
        raise GaitsimError(
            f"invalid generation: {text!r}",
            where="--generation",
            allowed="a number from 1, or an individual of a generation, such as 12:34",
        )
    return text


Generations = Annotated[str, BeforeValidator(parse_generations)]


class ChosenIndividual(Action):
    """Options that choose an individual of a run."""

    generation: Annotated[str, BeforeValidator(parse_generation)] | None = option(
        None,
        "use the best individual of this generation, or one of its individuals, such as 12:34",
        placeholder="N|N:I",
        unset="the champion, the best individual of the run",
    )
    member: Annotated[str, BeforeValidator(str)] | None = option(
        None,
        "use this member of the front or archive (see 'gaitsim members'), or the best member near "
        "the given values, such as 'duty factor L2=0'",
        placeholder="N|NAME=VALUE,…",
    )

    @property
    def choice(self) -> "Choice":
        """The chosen individual; None for the champion.

        Raises:
            GaitsimError: both a generation and a member are chosen, or the member is invalid.
        """
        from gaitsim.individual import parse_mark

        if self.member is None:
            return None if self.generation is None else parse_mark(self.generation)
        if self.generation is not None:
            raise not_combinable(
                "--generation", "--member", "one of the two; members belong to the last generation"
            )
        return parse_member(self.member)

    def choices(self) -> "tuple[Choice, ...]":
        """Return the chosen individuals, in order; () for the champion."""
        return () if self.choice is None else (self.choice,)


class OneIndividual(ChosenIndividual):
    """Options that choose an individual of a run, and change its body."""

    damage: Names | None = option(
        None,
        "simulate damage to the body, such as 'L2 lost' or 'R1 femur stuck 20'",
        placeholder="TEXT",
    )
    world: Names | None = option(
        None,
        "set a condition of the world, such as 'friction 0.4' ('gaitsim plugins show BODY' lists "
        "conditions)",
        placeholder="TEXT",
    )
    engine: str | None = option(
        None, "physics engine for the robot, such as 'bullet'", placeholder="NAME"
    )
    gait: Path | None = option(
        None,
        "play the joint angles in this file (.npz, .csv or .mat), such as the recording of a real "
        "robot, instead of the run's own gait",
        placeholder="FILE",
    )
    gait_unit: Literal["rad", "deg"] | None = option(
        None,
        "unit of the angles in --gait, for joints whose columns state none",
        unset="radians, unless no joint could reach them",
    )
    gait_repeat: int = option(
        1, "how often the gait in --gait is repeated, such as one cycle", ge=1, le=1_000
    )

    def changed(self, individual: "Individual") -> "Individual":
        """Return an individual with the chosen gait, damage, world and engine.

        Raises:
            GaitsimError: the body does not support the change, or a condition has no value.
        """
        if self.gait is not None:
            from gaitsim.gait.gait_files import play_gait, read_gait

            for name in ("generation", "member", "generations"):
                if getattr(self, name, None):
                    raise not_combinable(f"--{name}", "--gait")
            file = read_gait(self.gait, self.gait_unit).repeated(self.gait_repeat)
            body = individual.embodied.experiment
            individual = play_gait(file, body)
            _say(file, body.organism.joint_names())
        if not (self.damage or self.world or self.engine):
            return individual
        from gaitsim.evaluation.worlds import parse_world
        from gaitsim.gait.changed import in_engine, with_damage, with_world

        conditions = parse_world(self.world or (), "--world")
        if self.damage:
            individual = with_damage(individual, self.damage)
        if conditions:
            individual = with_world(individual, conditions)
        return in_engine(individual, self.engine) if self.engine else individual

    def individuals(self, run: "RunSnapshot") -> "tuple[Individual, ...]":
        """Return the chosen individuals of a run, on their changed bodies."""
        return tuple(map(self.changed, run.individuals(self.choices())))


def _say(file: "GaitFile", joints: Sequence[str]) -> None:
    """Print what was changed in a gait from a file, and what is not used."""
    from gaitsim.console.printing import notice

    for text in file.notices:
        notice(f"{file.path}: {text}")
    if unused := file.left_over(joints):
        names = ", ".join(unused[:6]) + " …" * (len(unused) > 6)
        notice(f"{file.path}: this body has no joints for the columns {names}")


class SeveralIndividuals(OneIndividual):
    """Options that choose individuals of a run, and change their bodies."""

    generations: Generations | None = option(
        None,
        "show the best individuals of several generations side by side, such as 1,50,300; or "
        "individuals of generations, such as 12:34",
        allowed="numbers separated by commas",
        placeholder="N,N,…",
    )

    def choices(self) -> "tuple[Choice, ...]":
        """Return the chosen individuals, in order; () for the champion."""
        from gaitsim.individual import parse_mark

        found = super().choices()
        if found and self.generations:
            option = "--generation" if self.member is None else "--member"
            raise not_combinable(option, "--generations")
        chosen = self.generations.split(",") if self.generations else []
        return tuple(map(parse_mark, chosen)) or found


def individual_options(input: Input) -> tuple[str, ...]:
    """Return the names of the options above that apply to a kind of input."""
    models = {"run": Action, "individual": OneIndividual, "individuals": SeveralIndividuals}
    return tuple(models[input].model_fields)


def not_combinable(first: str, second: str, allowed: str = "one of the two") -> GaitsimError:
    """Return the error of two options that exclude each other."""
    return GaitsimError(
        f"{first} and {second} cannot be combined", where=f"{first}, {second}", allowed=allowed
    )


def parse_member(text: str) -> "Member | dict[str, float]":
    """Return the member of `--member`: a number, or values that it is near.

    Raises:
        GaitsimError: the text is neither a number nor NAME=VALUE,….
    """
    import math

    from gaitsim.individual import Member

    allowed = "a number from 1, or NAME=VALUE,…, such as 'duty factor L2=0'"
    if text.isascii() and text.isdecimal() and len(text) < 10 and int(text):
        return Member(int(text))
    if "=" not in text:
        raise GaitsimError(f"invalid member: {text!r}", where="--member", allowed=allowed)
    values = parse_pairs(text, "--member", allowed)
    try:
        found = {name: float(value) for name, value in values.items()}
        if not all(map(math.isfinite, found.values())):
            raise ValueError
    except ValueError:
        raise GaitsimError(
            f"a value in {text!r} is not a number", where="--member", allowed=allowed
        ) from None
    return found


def parse_pairs(text: str, option: str, allowed: str) -> dict[str, str]:
    """Return the texts of a list NAME=TEXT,… by name; '' for a name without a text.

    Raises:
        GaitsimError: a name is missing or repeated.
    """
    found: dict[str, str] = {}
    for part in text.split(","):
        name, _, value = (one.strip() for one in part.partition("="))
        if not name or name in found:
            what = f"{name!r} is given twice" if name else f"a name is missing in {text!r}"
            raise GaitsimError(what, where=option, allowed=allowed)
        found[name] = value
    return found


def choose_format(
    format: str | None, out: Path | None, known: Sequence[str], default: str, what: str
) -> str:
    """Return the format given by `--format`, or else by the extension of `--out`.

    Args:
        format: value of `--format`.
        out: value of `--out`.
        known: the formats, each equal to the extension of its files.
        default: format if neither option is given.
        what: content of the files, in the plural.

    Raises:
        GaitsimError: the two options contradict each other, or the extension is unknown.
    """
    if out is None:
        return format or default
    ending = out.suffix[1:].lower()
    if format is None and ending not in known:
        raise GaitsimError(
            f"unknown extension for {what}: {out}",
            where="--out",
            allowed=", ".join(f".{one}" for one in known),
            remedy="change the extension, or add --format",
        )
    if format is not None and ending in known and ending != format:
        raise GaitsimError(
            f"{out} ends with .{ending}, but --format is {format}",
            remedy="omit one of the two",
        )
    return format or ending

"""Gaits with reflexes as C99: the rhythm, its reflexes, and their state."""

import re
import string
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from textwrap import fill, indent
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import (
    COMMAND,
    OBSERVATIONS,
    SAMPLES,
    Controller,
    Exported,
    GaitsimError,
    Organism,
    Reflex,
    RunError,
    find,
    plugin_errors,
)
from gaitsim.plugin.gait import check_parent, has_rhythm_on_twin, rhythm_on_twin
from gaitsim.plugin.runs import Individual, write_bytes, writing

Values = Mapping[str, NDArray[np.float64]]
"""Numbers and arrays by name."""

_C_KEYWORDS = re.findall(
    r"\w+",
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while",
)
DOUBLE, FLOAT = 8, 4  # bytes


@dataclass(frozen=True)
class CCode:
    """A gait as C99.

    Attributes:
        header: text of gait.h.
        source: text of gait.c.
        tables: size of the tables, bytes.
        state: size of the state, bytes.
        summary: description of the gait, one line.
    """

    header: str
    source: str
    tables: int
    state: int
    summary: str


def check_controller(individual: Individual) -> None:
    """Check that the gaits of a body or its twin can follow commands, without simulating one.

    Raises:
        GaitsimError: neither has controllers, or the individual has no genome.
    """
    organism = individual.experiment.organism
    if individual.genome is None:
        raise GaitsimError(
            "a gait from a file has only joint angles, and cannot follow commands",
            where=str(individual.source or ""),
            allowed="an individual of a run",
        )
    if type(organism).controller is Organism.controller and not has_rhythm_on_twin(individual):
        raise _no_controller(individual)


def controller_of(individual: Individual) -> Controller:
    """Return the gait of an individual as a rhythm with reflexes.

    Raises:
        GaitsimError: the body has no controllers, or the individual has no genome.
    """
    check_controller(individual)
    entry, own = individual.experiment.entries["organism"], individual.embodied
    with plugin_errors(entry, "returning the controller of a gait"):
        found = own.body.controller(np.asarray(own.genome))
    if found is None:
        raise _no_controller(individual)
    return found


def with_rhythm(individual: Individual) -> tuple[Individual, tuple[str, ...]]:
    """Return an individual whose gait follows commands, and notices.

    A gait of a kinematic body becomes one of its twin in physics, with reflexes.

    Raises:
        GaitsimError: neither body has controllers, or the twin cannot play the gait.
    """
    check_controller(individual)
    if not has_rhythm_on_twin(individual):
        return individual, ()
    twin, about = rhythm_on_twin(individual)
    return twin, (about,)


def _no_controller(individual: Individual) -> GaitsimError:
    return GaitsimError(
        f"the gaits of {individual.experiment.entries['organism']} cannot follow commands",
        where=str(individual.source or ""),
        allowed="a body with the method controller(), such as the robots of 'gaitsim run hexapod' "
        "and 'gaitsim run quadruped'",
    )


def needs_of(controller: Controller) -> set[str]:
    """Return the names of the observations that the reflexes need."""
    return {need for reflex in controller.reflexes.values() for need in reflex.needs}


def export_c(individual: Individual, folder: Path) -> Exported:
    """Write a gait with its reflexes as C99 to a folder."""
    individual, notices = with_rhythm(individual)
    controller = controller_of(individual)
    code = c_code(controller, individual.title)
    make_folder(folder)
    write_bytes(folder / "gait.h", code.header.encode(), follow=False)
    write_bytes(folder / "gait.c", code.source.encode(), follow=False)
    return Exported(f"gait.h and gait.c: {code.summary}", notices)


def c_code(controller: Controller, title: str) -> CCode:
    """Return a gait as C99.

    Args:
        controller: rhythm and reflexes.
        title: title of the gait, one line.

    Raises:
        GaitsimError: a reflex cannot be exported.
    """
    rhythm = controller.rhythm
    legs, joints = len(rhythm.names), len(rhythm.joint_names)
    reflexes = [
        _ReflexCode(number, name, reflex, _first(controller.states[name]))
        for number, (name, reflex) in enumerate(controller.reflexes.items(), 1)
    ]
    needs = needs_of(controller)
    strings = "".join(f"    {_string(name)},\n" for name in rhythm.joint_names)
    tables = [*_tables(controller)]
    header = {
        "LEGS": str(legs),
        "JOINTS": str(joints),
        **{
            f"MAX_{name.upper()}": _literal(limit)
            for name, limit in zip(COMMAND, rhythm.limits[0], strict=True)
        },
        "SPEED": _literal(rhythm.own_speed[0]),
        "INTERVAL": _literal(np.float64(controller.interval)),
        "NEEDS": "\n".join(
            f"#define GAIT_NEEDS_{name.upper()} {int(name in needs)}" for name in OBSERVATIONS
        ),
        "NEEDS_TEXT": ", ".join(name for name in OBSERVATIONS if name in needs) or "no sensors",
        "STATES": "\n\n".join(reflex.state_type for reflex in reflexes if reflex.state),
        "STATE_FIELDS": "\n".join(
            f"    {reflex.type} {reflex.function};" for reflex in reflexes if reflex.state
        ),
        "LEGS_TEXT": ", ".join(map(as_comment, rhythm.names)),
        "TITLE": as_comment(title),
    }
    source = {
        "SAMPLES": str(SAMPLES),
        "MOST": str(np.diff(rhythm.first).max()),
        "TABLES": "\n".join(
            [
                *(_table(*table) for table in tables),
                f"const char *const GAIT_JOINT_NAMES[GAIT_JOINTS] = {{\n{strings}}};",
            ]
        ),
        "REFLEXES": "\n".join(reflex.definition for reflex in reflexes),
        "STARTS": "".join(reflex.start for reflex in reflexes if reflex.state),
        "STEPS": "".join(reflex.call for reflex in reflexes),
        "TITLE": as_comment(title),
    }
    numbers = 19 + 6 * legs + 2 * joints
    numbers += sum(value.size for reflex in reflexes for value in reflex.state.values())
    size = sum(values.size * (FLOAT if kind == "float" else DOUBLE) for kind, _, values in tables)
    names = ", ".join(controller.reflexes) or "none"
    return CCode(
        filled("gait.h", header),
        filled("gait.c", source),
        size,
        numbers * DOUBLE,
        f"{joints} joints, {legs} legs, reflexes: {names}; {size / 1000:.1f} kB of tables, "
        f"{numbers * DOUBLE / 1000:.1f} kB of state, and 5 to 9 kB of code",
    )


def make_folder(folder: Path) -> None:
    """Create a folder for exported files, unless it exists."""
    check_parent(folder)
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise RunError(
            f"cannot write {folder}: it is not a folder",
            remedy="choose a different folder with --out",
        )
    with writing(folder):
        folder.mkdir(exist_ok=True)


def as_comment(text: str) -> str:
    """Return a text without the characters that could end its comment.

    The question mark is one of them, as ??/ is a backslash in C99.
    """
    return "".join(char if char.isprintable() and char not in "\\?*" else "_" for char in text)


def filled(resource: str, values: Mapping[str, str]) -> str:
    """Return a template of the package with its placeholders filled in, in one pass."""
    text = (files("gaitsim_hardware") / resource).read_text(encoding="utf-8")
    text = re.sub(r"@([A-Z_]+)@", lambda found: values[found[1]], text)
    return re.sub(r"\n{3,}", "\n\n", text)


def _tables(controller: Controller) -> Iterator[tuple[str, str, NDArray[Any]]]:
    """Yield type, name and values of each table and constant."""
    rhythm = controller.rhythm
    yield "int", "FIRST", rhythm.first
    yield "double", "GAIT_STANDING", rhythm.standing
    for name in ("anchors", "axes", "tips", "lower", "upper", "speed_limit", "weights"):
        yield "gait_real", name.upper(), getattr(rhythm, name)
    yield "gait_real", "DAMPING", np.array(1e-6 * rhythm.length * rhythm.length)
    yield "double", "FEET", rhythm.legs.feet
    for name in ("frequency", "duty", "longest", "gains", "offset", "centre", "stroke"):
        yield "double", name.upper(), getattr(rhythm, name)[0]
    yield "double", "OWN_SPEED", np.array(max(rhythm.own_speed[0], 1e-9))
    yield "float", "PATH", rhythm.path[0]


def _table(kind: str, name: str, values: NDArray[Any]) -> str:
    """Return the definition of a constant or a table."""
    shape = "".join(f"[{size}]" for size in values.shape)
    static = "" if name.startswith("GAIT_") else "static "
    exact = values.astype(np.float32) if kind == "float" else values
    line = f"{static}const {kind} {name}{shape} = {_literal(exact)};"
    if len(line) <= 100:
        return line
    rows = (
        [_wrapped(_literal(row)) for row in exact]
        if values.ndim > 1
        else [_wrapped(_literal(exact)[1:-1])]
    )
    return f"{static}const {kind} {name}{shape} = {{\n{f',{chr(10)}'.join(rows)}}};"


def _literal(value: NDArray[Any] | np.generic) -> str:
    """Return a number or an array, (…), as an initialiser."""
    if np.ndim(value):
        return f"{{{', '.join(_literal(one) for one in np.asarray(value))}}}"
    number = value.item()
    if not np.isfinite(number):
        return "-INFINITY" if number < 0 else "INFINITY"
    if isinstance(value, np.float32):
        text = np.format_float_positional(value, unique=True, trim="0")
        return f"{text}f"
    return repr(number)


def _string(text: str) -> str:
    """Return a text as a string literal; bytes beyond printable ASCII are octal."""
    plain = string.ascii_letters + string.digits + " -_.:/"
    safe = (chr(one) if chr(one) in plain else f"\\{one:03o}" for one in text.encode())
    return f'"{"".join(safe)}"'


def _wrapped(text: str) -> str:
    """Return a list of numbers on lines of at most 100 characters."""
    wrapped = fill(text, 96, break_long_words=False, break_on_hyphens=False)
    return indent(wrapped, "    ")


def _first(state: Mapping[str, NDArray[np.float64]]) -> Values:
    """Return the state of the only individual."""
    return {name: np.asarray(value[0], np.float64) for name, value in state.items()}


@dataclass(frozen=True, eq=False)
class _ReflexCode:
    """The code of a reflex.

    Attributes:
        number: number of the reflex, from 1, which names its function and types.
        name: name of the reflex.
        reflex: the reflex.
        state: its state at the start.
    """

    number: int
    name: str
    reflex: Reflex
    state: Values

    @property
    def function(self) -> str:
        """Name of its function, and of its state."""
        return f"reflex_{self.number}"

    @property
    def type(self) -> str:
        """Name of the type of its state."""
        return f"gait_{self.function}"

    @property
    def options(self) -> Values:
        """The options that are numbers."""
        found = {}
        for name in type(self.reflex).model_fields:
            value = np.asarray(getattr(self.reflex, name))
            if value.dtype.kind in "biuf" and value.size:
                found[name] = value.astype(np.float64)
        return found

    @property
    def state_type(self) -> str:
        """Definition of the type of its state."""
        kind = self._struct(self.state, self.type)
        return f"// State of the reflex {as_comment(self.name)}.\n{kind}"

    @property
    def start(self) -> str:
        """Code that sets its state at the start."""
        text = _wrapped(_literal_struct(self.state))
        return (
            f"    static const {self.type} {self.function} =\n    {indent(text, '    ').strip()};\n"
            f"    state->{self.function} = {self.function};\n"
        )

    @property
    def call(self) -> str:
        """Call of its function."""
        options = [f"&{self.function}_options"] if self.options else []
        state = [f"&state->{self.function}"] if self.state else []
        return f"    {self.function}({', '.join([*options, *state, '&seen', 'inputs', 'dt'])});\n"

    @property
    def definition(self) -> str:
        """Definition of its options and its function."""
        entry = find("reflex", self.name)
        with plugin_errors(entry, "returning its C code"):
            body = self.reflex.c99()
        if not body:
            raise GaitsimError(
                f"the {entry} cannot be exported: it has no C code",
                allowed="reflexes with the method c99()",
                remedy="evolve a gait without it, or ask its author for c99()",
            )
        parameters, unused, text = ["const gait_seen *seen", "gait_inputs *inputs"], [], ""
        if self.state:
            parameters.insert(0, f"{self.type} *s")
            unused.append("s")
        if options := self.options:
            kind = f"{self.function}_type"
            text = (
                f"{self._struct(options, kind)}\n"
                f"static const {kind} {self.function}_options = {_literal_struct(options)};\n\n"
            )
            parameters.insert(0, f"const {kind} *o")
            unused.append("o")
        ignored = " ".join(f"(void){name};" for name in (*unused, "seen", "inputs", "interval"))
        return (
            f"// The reflex {as_comment(self.name)}.\n{text}"
            f"static void {self.function}(\n    {', '.join(parameters)}, double interval) {{\n"
            f"    {ignored}\n"
            f"{indent(body.rstrip(), '    ')}\n}}\n"
        )

    def _struct(self, values: Values, kind: str) -> str:
        lines = "".join(
            f"    double {self._member(name, value)};\n" for name, value in values.items()
        )
        return f"typedef struct {{\n{lines}}} {kind};"

    def _member(self, name: str, value: NDArray[np.float64]) -> str:
        """Return the declaration of a member of a struct, without its type."""
        if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII) or name in _C_KEYWORDS:
            raise GaitsimError(
                f"the reflex {self.name!r} has the option or state {name!r}, which is not a name "
                "in C",
                allowed="letters, digits and underscores, and no keyword of C",
            )
        return name + "".join(f"[{size}]" for size in value.shape)


def _literal_struct(values: Values) -> str:
    return f"{{{', '.join(_literal(value) for value in values.values())}}}"

"""Load experiments from presets, files, texts and Python functions.

The name of an entry point of the group `gaitsim.files` is the suffix of files that describe a body,
such as a robot's URDF. Its value is the class of the body, as in the group `gaitsim.organism`,
followed by the option that takes the path: `urdf = "gaitsim_robot.organism:Robot.model"`.
"""

import math
import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from gaitsim.contracts import BitSpace, GenomeSpace, Organism, RealSpace
from gaitsim.errors import GaitsimError, PluginError
from gaitsim.experiment.model import Experiment, space_of
from gaitsim.experiment.outline import ExperimentOutline
from gaitsim.experiment.overrides import COMMAND_LINE, Overrides
from gaitsim.experiment.reader import LONGEST_NAME, NOT_IN_NAMES, Reader
from gaitsim.opening import read_regular
from gaitsim.registry import (
    FILES,
    Entry,
    contract_error,
    entries,
    find,
    options,
)
from gaitsim.registry.entry_points import ARGUMENTS, install_hint, python_name
from gaitsim.registry.loading import read_preset
from gaitsim.registry.options import PLUGIN
from gaitsim.registry.python_plugins import python_options
from gaitsim.toml import LARGEST


def load_experiment(
    reference: str,
    overrides: Overrides | None = None,
    place: str = COMMAND_LINE,
    *,
    roots: Sequence[Path] = (),
) -> Experiment:
    """Return the experiment of a preset, a TOML file or a robot's file.

    A robot's file, such as `my_robot.urdf`, uses the preset of the body that reads such files.

    Args:
        reference: name of a preset, or path of a file. A path contains a '/', or ends with '.toml'
            or the suffix of a robot's file.
        overrides: values of options by key, such as `{"mutation.rate": 0.1}`.
        place: origin of the overrides, for messages.
        roots: additional folders that a robot's file may refer to.

    Raises:
        ExperimentError: the experiment has problems; the error lists all of them.
        GaitsimError: the preset or file does not exist or cannot be read.
    """
    path = Path(reference)
    if is_body_file(reference) or _conversion(path):
        body, option = reader_of(path)
        given = {
            "name": experiment_name(path),
            f"organism.{option}": reference,
            **(overrides or {}),
        }
        return parse_experiment(read_preset(body), reference, given, place, roots=roots)
    if hint := install_hint(FILES, path.suffix[1:].lower()):
        what = f"no installed package reads files such as {reference}"
        raise PluginError(what, where=reference, remedy=hint)
    if path.suffix == ".toml" or path.name != reference:
        example, listed = "'gaitsim experiments show spider'", "'gaitsim experiments list'"
        text = read_file(path, "experiment", example, f"name a preset: {listed}")
        return parse_experiment(text, str(path), overrides, place, path.parent)
    try:
        text = read_preset(reference)
    except PluginError as error:
        if formats := entries(FILES):
            suffixes = ", ".join(f".{suffix}" for suffix in formats)
            error.allowed += f"; or a file with the extension .toml, {suffixes}"
        # Unlike pathlib, os.path does not raise an error for an invalid file name.
        here = [file for file in (path, f"{reference}.toml") if os.path.isfile(file)]  # noqa: PTH113
        if here:
            hint = f"for the file of that name, use ./{here[0]}"
            error.remedy = f"{error.remedy} or, {hint}" if error.remedy else hint
        raise
    return parse_experiment(text, f"preset {reference}", overrides, place)


def read_file(path: Path, noun: str, example: str, remedy: str) -> str:
    """Return the text of a TOML file that the user named.

    Args:
        path: path of the file.
        noun: content of the file, for messages, such as 'experiment'.
        example: command that prints an example of such a file, for messages.
        remedy: alternative to another path, for messages.
    """
    try:
        return read_regular(path, LARGEST, follow=True).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise GaitsimError(
            f"{path} is not a text file in UTF-8: {error.reason} at byte {error.start}",
            remedy=f"save it as UTF-8, or start from the output of {example}",
        ) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise GaitsimError(
            f"cannot read the {noun} file {path}: {reason}", remedy=f"check the path, or {remedy}"
        ) from None


def parse_experiment(
    text: str,
    source: str,
    overrides: Overrides | None = None,
    place: str = COMMAND_LINE,
    folder: Path | None = None,
    roots: Sequence[Path] = (),
) -> Experiment:
    """Return the experiment that a TOML text describes, with overrides.

    Args:
        text: text of the experiment, in TOML.
        source: origin of the text, for messages.
        overrides: values of options by key.
        place: origin of the overrides, for messages.
        folder: folder of relative paths in the text; None for a text that must not refer to files.
        roots: additional folders that files in options may refer to.
    """
    return Reader(text, source, overrides, place, folder, roots).read()


def parse_space(text: str, source: str) -> tuple[str, GenomeSpace]:
    """Return the name and the genome space of the body of an experiment in TOML.

    Unlike `parse_experiment`, this function does not need the other plugins of the experiment.
    """
    entry, organism = Reader(text, source).read_organism()
    return entry.name, space_of(entry, organism)


def with_overrides(
    experiment: Experiment, overrides: Overrides, place: str = COMMAND_LINE
) -> Experiment:
    """Return an experiment with changed options."""
    return parse_experiment(experiment.to_toml(), "the experiment", overrides, place)


def is_body_file(reference: str) -> bool:
    """Return whether a reference to an experiment ends with the suffix of a body's file."""
    return Path(reference).suffix[1:].lower() in entries(FILES)


def reader_of(path: Path) -> tuple[str, str]:
    """Return the name of the body that reads a file, and the option that takes its path."""
    if not is_body_file(str(path)):
        raise GaitsimError(
            f"{path} is not a file that describes a body",
            allowed=", ".join(f".{suffix}" for suffix in entries(FILES)),
            remedy=_conversion(path),
        )
    entry = find(FILES, path.suffix[1:].lower())
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    if not os.path.isfile(path):  # noqa: PTH113
        found = "not a file" if os.path.lexists(path) else "file not found"
        raise GaitsimError(f"{found}: {path}", remedy="check the path")
    # The entry point must refer to a body of the same package.
    if body := _body_of(entry):
        return body, entry.target.rpartition(".")[2]
    raise contract_error(
        entry,
        "does not refer to a body of this package",
        "the class and the option of an organism, such as package.module:Robot.model",
    )


def _conversion(path: Path) -> str:
    """Return how to convert a file of a common format of robots that no body reads, or ''."""
    if not os.path.isfile(path):  # noqa: PTH113 (unlike pathlib, it accepts invalid names)
        return ""
    return {
        ".sdf": "use the URDF from which the SDF file was made, or convert it: "
        f"pip install sdformat-mjcf, then sdf2mjcf {path} robot.xml",
        ".xacro": f"expand the macros: xacro {path} > robot.urdf",
        ".usd": "convert the USD file to URDF or MJCF",
        ".usda": "convert the USD file to URDF or MJCF",
    }.get(path.suffix.lower(), "")


def _body_of(entry: Entry) -> str:
    """Return the name of the body to which an entry refers; '' if it does not exist."""
    body = entry.target.rpartition(".")[0], entry.package
    names = (
        name
        for name, claims in entries("organism").items()
        if any((one.target, one.package) == body for one in claims)
    )
    return next(names, "")


def experiment_name(path: Path) -> str:
    """Return a name for the experiment of a file: the file's name without invalid characters."""
    stem = "".join(c if c.isprintable() and c not in NOT_IN_NAMES else "-" for c in path.stem)
    short = stem.encode()[: LONGEST_NAME // 2].decode(errors="ignore")
    return short.strip(" .-") or "experiment"


def readers() -> dict[str, list[str]]:
    """Return the suffixes of the files that each body reads, by the name of the body."""
    found: dict[str, list[str]] = {}
    for suffix, claims in entries(FILES).items():
        for entry in claims:
            if body := _body_of(entry):
                found.setdefault(body, []).append(suffix)
    return found


CMA_ES = "cma-es"
_REAL = f'[search]\nplugin = "{CMA_ES}"\n'
_BITS = """[selection]
plugin = "tournament"
[crossover]
plugin = "uniform"
[mutation]
plugin = "bit-flip"
"""


def python_experiment(
    experiment: str | Path | Experiment | None,
    overrides: Mapping[str, Any],
    place: str = COMMAND_LINE,
    *,
    fitness: Any = None,
    body: Any = None,
    space: Any = None,
) -> Experiment:
    """Return an experiment with overrides, and with a fitness and a body passed in Python.

    Args:
        experiment: name of a preset, path of a file, or an experiment; None for a body only.
        overrides: values of options by key.
        place: origin of the overrides, for messages.
        fitness: see `gaitsim.evolve`.
        body: see `gaitsim.evolve`.
        space: see `gaitsim.evolve`.
    """
    sections = python_options(fitness, body, space)
    for kind in sections:
        if f"{kind}.{PLUGIN}" in overrides:
            what = (
                f"both the argument {ARGUMENTS[kind]!r} and the option '{kind}.{PLUGIN}' are given"
            )
            raise GaitsimError(what, where=place, remedy="omit one of them")
    given = {**_keys(sections), **overrides}
    text = ""
    if experiment is None:
        text = _default_toml(body, space, overrides.get(f"search.{PLUGIN}", CMA_ES))
    if "organism" in sections:
        label = getattr(body, "__name__", type(body).__name__).strip("<>")  # '<lambda>'
        given = {"name": label, "description": f"the body {label}", **given}
    if text:
        return parse_experiment(text, "the experiment of a body", given, place)
    if not isinstance(experiment, Experiment):
        return load_experiment(str(experiment), given, place)
    return with_overrides(experiment, given, place) if given else experiment


def _keys(sections: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    return {f"{kind}.{key}": v for kind, table in sections.items() for key, v in table.items()}


def _default_toml(body: Any, space: Any, search: str) -> str:
    """Return the TOML of a default search for a body: CMA-ES, or a genetic algorithm for bits.

    The population of CMA-ES is that of Hansen 2016, "The CMA evolution strategy: a tutorial",
    eq. 48.

    Args:
        body: see `gaitsim.evolve`.
        space: see `gaitsim.evolve`.
        search: name of the search of a body with real genes.
    """
    presets = "name a preset to use its search and options: gs.evolve('spider', …)"
    if body is None:
        raise GaitsimError(
            "there is nothing to evolve",
            where="experiment",
            allowed="a preset's name, a path, an experiment, or a body",
            remedy=presets,
        )
    genomes = body.genome_space() if isinstance(body, Organism) else space
    if isinstance(genomes, RealSpace):
        size = f"[evolution]\npopulation = {4 + math.floor(3 * math.log(genomes.genes))}\n"
        return _REAL + (size if search == CMA_ES else "")
    if isinstance(genomes, BitSpace):
        return _BITS
    what = f"there is no default search for genomes of a {type(genomes).__name__}"
    raise GaitsimError(what, where="experiment", remedy=presets)


def check_functions_match(
    sections: Mapping[str, Mapping[str, Any]], outlines: Collection[ExperimentOutline], where: str
) -> None:
    """Check that the functions passed for a run have the names of those that evolved it."""
    for kind, table in sections.items():
        known = [python_name(one.plugins[kind]) for one in outlines]
        argument = ARGUMENTS[kind]
        if table[PLUGIN] not in known:
            raise GaitsimError(
                f"the {argument} of the run is {known[-1]!r}, not {table[PLUGIN]!r}",
                where=where,
                allowed=f"the {argument} that evolved the run",
                remedy=f"run.resume({argument}=…) continues with another one, as a new stage",
            )


def resumed_options(
    sections: Mapping[str, Mapping[str, Any]], outline: ExperimentOutline
) -> dict[str, Any]:
    """Return the options of functions and objects that differ from those of a run, by key."""
    changed = {
        kind: {key: value for key, value in table.items() if _differs(outline, kind, key, value)}
        for kind, table in sections.items()
    }
    return _keys(changed)


def _differs(outline: ExperimentOutline, kind: str, key: str, value: Any) -> bool:
    now = outline.sections[kind].get(key, options.NOT_SET)
    return bool((python_name(now) if key == PLUGIN else now) != value)

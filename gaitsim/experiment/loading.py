"""Load experiments from presets, files and texts."""

import os
from collections.abc import Sequence
from pathlib import Path

from gaitsim import registry
from gaitsim.contracts import BodyFile, GenomeSpace, Organism
from gaitsim.errors import GaitsimError, PluginError
from gaitsim.experiment.body_files import experiment_name, is_body_file, reader_of
from gaitsim.experiment.model import Experiment, space_of
from gaitsim.experiment.problems import COMMAND_LINE, Overrides
from gaitsim.experiment.reader import Reader
from gaitsim.opening import read_regular
from gaitsim.registry.loading import read_preset
from gaitsim.toml import LARGEST


def load_experiment(
    reference: str, overrides: Overrides | None = None, place: str = COMMAND_LINE
) -> Experiment:
    """Return the experiment of a preset, a TOML file or a robot's file.

    A robot's file, such as `my_robot.urdf`, uses the preset of the body that reads such files.

    Args:
        reference: name of a preset, or path of a file. A path contains a '/', or ends with '.toml'
            or the suffix of a robot's file.
        overrides: values of options by key, such as `{"mutation.rate": 0.1}`.
        place: origin of the overrides, for messages.

    Raises:
        ExperimentError: the experiment has problems; the error lists all of them.
        GaitsimError: the preset or file does not exist or cannot be read.
    """
    path = Path(reference)
    if is_body_file(reference):
        body, option = reader_of(path)
        given = {
            "name": experiment_name(path),
            f"organism.{option}": reference,
            **(overrides or {}),
        }
        return parse_experiment(read_preset(body), reference, given, place)
    if path.suffix == ".toml" or path.name != reference:
        example, listed = "'gaitsim experiments show spider'", "'gaitsim experiments list'"
        text = read_file(path, "experiment", example, f"name a preset: {listed}")
        return parse_experiment(text, str(path), overrides, place, path.parent)
    try:
        text = read_preset(reference)
    except PluginError as error:
        if formats := registry.entries(registry.FILES):
            suffixes = ", ".join(f".{suffix}" for suffix in formats)
            error.allowed += f"; or a file with the extension .toml, {suffixes}"
        # Unlike pathlib, os.path does not raise an error for an invalid file name.
        here = [file for file in (path, f"{reference}.toml") if os.path.isfile(file)]  # noqa: PTH113
        if here:
            hint = f"for the file of that name, use ./{here[0]}"
            error.remedy = f"{error.remedy} or, {hint}" if error.remedy else hint
        raise
    return parse_experiment(text, f"preset {reference}", overrides, place)


def read_body(path: Path, roots: Sequence[Path] = ()) -> tuple[BodyFile, Experiment]:
    """Return the body in a file, such as a robot's, and the experiment that `gaitsim run` uses.

    Args:
        path: path of the file.
        roots: further folders that the file may refer to.

    Raises:
        GaitsimError: the file does not exist, or does not describe a valid body.
    """
    body, option = reader_of(path)
    entry, model = registry.find("organism", body), registry.load_class("organism", body)
    assert issubclass(model, Organism)
    with registry.plugin_errors(entry, "reading a file"):
        found = model.read_file(path, roots)
    given = {"name": experiment_name(path), f"organism.{option}": found.text}
    return found, parse_experiment(read_preset(body), str(path), given, str(path))


def read_file(path: Path, noun: str, example: str, remedy: str) -> str:
    """Return the text of a TOML file that the user named.

    Args:
        path: path of the file.
        noun: content of the file, for messages, such as 'experiment'.
        example: command that prints an example of such a file, for messages.
        remedy: alternative to another path, for messages.

    Raises:
        GaitsimError: the file cannot be read, is not text, or is too large.
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
            f"cannot read the {noun} file {path}: {reason}",
            remedy=f"check the path, or {remedy}",
        ) from None


def parse_experiment(
    text: str,
    source: str,
    overrides: Overrides | None = None,
    place: str = COMMAND_LINE,
    folder: Path | None = None,
) -> Experiment:
    """Return the experiment that a TOML text describes, with overrides.

    Args:
        text: text of the experiment, in TOML.
        source: origin of the text, for messages.
        overrides: values of options by key.
        place: origin of the overrides, for messages.
        folder: folder of relative paths in the text; None for a text that must not refer to files.

    Raises:
        ExperimentError: the text or the overrides have problems; the error lists all of them.
    """
    return Reader(text, source, overrides, place, folder).read()


def parse_space(text: str, source: str) -> tuple[str, GenomeSpace]:
    """Return the name and the genome space of the body of an experiment in TOML.

    Unlike `parse_experiment`, this function does not need the other plugins of the experiment.

    Raises:
        ExperimentError: the body has problems, such as a package that is not installed.
        PluginError: the body fails or breaks its contract.
    """
    entry, organism = Reader(text, source).read_organism()
    return entry.name, space_of(entry, organism)


def with_overrides(
    experiment: Experiment, overrides: Overrides, place: str = COMMAND_LINE
) -> Experiment:
    """Return an experiment with changed options.

    Raises:
        ExperimentError: the overrides have problems; the error lists all of them.
    """
    return parse_experiment(experiment.to_toml(), "the experiment", overrides, place)

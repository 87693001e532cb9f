"""Convert the values of a TOML file to an experiment, or report all problems."""

import json
import shlex
import unicodedata
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from gaitsim import registry, toml
from gaitsim.contracts import Organism
from gaitsim.contracts.plugin import ReadableFiles
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment.combination import Combination
from gaitsim.experiment.model import (
    CONSTRAINTS,
    DEFAULT_SEARCH,
    SCHEMA,
    TRANSFERABILITY,
    Constraints,
    Evolution,
    Experiment,
    Islands,
    Transferability,
    Worlds,
    space_of,
)
from gaitsim.experiment.overrides import (
    COMMAND_LINE,
    HEAD,
    SECTIONS,
    Overrides,
    Problems,
    apply_overrides,
)
from gaitsim.registry import KINDS, Entry, options, plugin_errors
from gaitsim.registry.options import OPERATORS, PLUGIN
from gaitsim.toml import literal

_Scalar = TypeVar("_Scalar", int, str)
_Model = TypeVar("_Model", bound=BaseModel)

_NAMES: dict[type, str] = {int: "a whole number", str: "a string in quotes"}
NOT_IN_NAMES = frozenset('/\\:*?"<>|')
LONGEST_DESCRIPTION = 1000  # characters
LONGEST_TEXT = 1_000_000  # bytes of an option, so that the stored experiment stays readable
LONGEST_NAME = 200  # bytes; file systems allow 255, and the number of a run is appended


def _study_error(source: str) -> GaitsimError:
    return GaitsimError(
        "the file is a study of several experiments, not an experiment",
        where=f"{source}, key experiments",
        remedy=f"run: gaitsim study {shlex.quote(source)}",
        key="experiments",
    )


class Reader:
    """Reads an experiment and collects its problems; `parse_experiment` describes the arguments.

    Relative paths in overrides start from the current folder.
    """

    def __init__(
        self,
        text: str,
        source: str,
        overrides: Overrides | None = None,
        place: str = COMMAND_LINE,
        folder: Path | None = None,
        roots: Sequence[Path] = (),
    ) -> None:
        self._folder, self._roots = folder, tuple(roots)
        try:
            self._data = toml.parse(text, source)
        except GaitsimError as error:
            raise ExperimentError([error]) from None
        if "experiments" in self._data:
            raise ExperimentError([_study_error(source)])
        self._problems = Problems(source, overrides, place)
        self._report = self._problems.report
        self._entries: dict[str, Entry] = {}
        self._plugins: dict[str, Any] = {}

    def read(self) -> Experiment:
        """Return the experiment with the overrides."""
        problems, entries, plugins = self._problems, self._entries, self._plugins
        self._data.setdefault("search", {PLUGIN: DEFAULT_SEARCH})
        apply_overrides(self._data, problems)
        for key in self._data:
            if key not in (*HEAD, *SECTIONS):
                problems.add_unknown_key("", key, [*HEAD, *SECTIONS])
        self._check_schema()
        name, description, seed = self._name(), self._description(), self._seed()
        evolution = self._options("evolution", Evolution)
        islands = self._options("islands", Islands)
        worlds = self._options("worlds", Worlds)
        transferability = self._options(TRANSFERABILITY, Transferability)
        constraints = self._options(CONSTRAINTS, Constraints)
        for kind in KINDS:
            if kind not in OPERATORS or self._uses_operator(kind):
                self._read_plugin(kind)
        combination = Combination(entries, plugins, problems)
        if evolution is not None:
            combination.check_pairing(evolution)
        if evolution is not None and islands is not None:
            combination.check_search(evolution, islands)
            combination.check_islands(evolution, islands)
        combination.check_genomes()
        if evolution is not None and worlds is not None:
            combination.check_worlds(evolution, worlds)
        reality = None
        if transferability is not None:
            transferability = combination.check_transferability(transferability)
            reality = self._reality(transferability.reality)
            transferability = transferability.resolved(reality)
        if constraints is not None and islands is not None:
            combination.check_constraints(constraints, islands, reality)
        if problems.found or not (
            evolution and islands and worlds and transferability and constraints
        ):
            raise ExperimentError(problems.found)
        return Experiment(
            name,
            description,
            seed,
            evolution,
            **plugins,
            entries=entries,
            islands=islands,
            worlds=worlds,
            transferability=transferability,
            reality=reality,
            constraints=constraints,
        )

    def _uses_operator(self, kind: str) -> bool:
        """Return whether the search uses a kind of operator; report an unused section.

        Unused sections of operators are ignored if an override chose another search.
        """
        search = self._plugins.get("search")
        if search is None:  # already reported
            return kind in self._data
        if kind in search.operators:
            return True
        given = [key for key in self._problems.overrides if key.partition(".")[0] == kind]
        if kind in self._data and (given or f"search.{PLUGIN}" not in self._problems.overrides):
            name = self._entries["search"].name
            self._report(
                given[0] if given else kind,
                f"the search {name!r} does not use a {kind}",
                remedy=f"remove {'it' if given else f'the section [{kind}]'}, or choose a search "
                f"that does: {DEFAULT_SEARCH}",
            )
        return False

    def _reality(self, given: Mapping[str, Any]) -> Organism | None:
        """Return the body that represents reality; None without options for it."""
        organism: Organism | None = self._plugins.get("organism")
        if organism is None or not given:
            return None
        key, entry = f"{TRANSFERABILITY}.reality", self._entries["organism"]
        reality: Organism | None = None
        with self._problems.recorded(key):
            with plugin_errors(entry, "validating its options in reality"):
                values = {**options.values(organism), **given}
                reality = self._options(key, type(organism), values)
            if reality is not None and (
                space_of(entry, reality).labels != space_of(entry, organism).labels
            ):
                self._report(
                    key,
                    f"the options in {key} change the genome",
                    "options of the body that do not change the genome",
                )
        return reality

    def read_organism(self) -> tuple[Entry, Organism]:
        """Return only the body; problems of other sections are ignored."""
        self._read_plugin("organism")
        if self._problems.found:
            raise ExperimentError(self._problems.found)
        return self._entries["organism"], self._plugins["organism"]

    def _check_schema(self) -> None:
        schema = self._scalar("schema", SCHEMA)
        if schema > SCHEMA:
            self._report(
                "schema",
                f"schema {schema} belongs to a newer version of gaitsim",
                f"up to {SCHEMA}",
                "update gaitsim: pip install --upgrade gaitsim",
            )
        elif schema < 1:
            self._report("schema", f"there is no schema {schema}", f"{SCHEMA}")

    def _name(self) -> str:
        name = self._scalar("name", "experiment")
        fits = (
            name == name.strip()
            and name[:1] not in ("", ".", "-")
            and not set(name) & NOT_IN_NAMES
            and _is_one_line(name)
            and len(name.encode()) <= LONGEST_NAME
        )
        if not fits:
            self._report(
                "name",
                f"invalid name: {literal(name)} (the folder of a run has the same name)",
                f'at most {LONGEST_NAME} bytes without / \\ : * ? " < > |, without spaces at '
                "either end, and without a dot or hyphen at the start",
            )
        return name

    def _description(self) -> str:
        description = self._scalar("description", "")
        if not _is_one_line(description) or len(description) > LONGEST_DESCRIPTION:
            self._report(
                "description",
                f"{literal(description)} is too long or has more than one line",
                f"one line of at most {LONGEST_DESCRIPTION:,} characters",
            )
        return description

    def _seed(self) -> int:
        seed = self._scalar("seed", 0)
        if not 0 <= seed < 2**63:
            self._report("seed", f"invalid seed: {seed}", "a whole number from 0 to 2^63 − 1")
        return seed

    def _scalar(self, key: str, default: _Scalar) -> _Scalar:
        """Return the value of a key, which must have the type of the default."""
        kind = type(default)
        value = self._data.get(key, default)
        typed = self._problems.typed.get(key)
        if typed is not None and kind is str and not isinstance(value, str):
            value = str(typed)
        if type(value) is not kind:
            self._report(key, f"{literal(value)} is not {_NAMES[kind]}", _NAMES[kind])
            return default
        return value

    def _read_plugin(self, kind: str) -> None:
        section = self._data.get(kind, {})
        key = f"{kind}.{PLUGIN}"
        if not isinstance(section, dict):
            self._report_not_a_section(kind, section, f'{PLUGIN} = "…"')
            return
        name = section.get(PLUGIN)
        if not isinstance(name, str):
            what = f"{literal(name)} is not the name of a plugin"
            self._report(
                key,
                what if PLUGIN in section else f"the {kind} is missing",
                ", ".join(registry.entries(kind)) or f"no installed package provides a {kind}",
            )
            return
        try:
            entry = registry.find(kind, name)
            model = registry.load_entry(entry)
            with plugin_errors(entry, "validating its options"):
                plugin = self._options(kind, model)
        except GaitsimError as error:
            given: Any = section
            for part in error.key.split("."):
                given = given.get(part) if isinstance(given, dict) else None
            if error.key and given is not None:  # a validator named the option
                key, value = f"{kind}.{error.key}", literal(given)
                implied = (error.key, f"{entry}, {entry.target}")
                where = "" if error.where in implied else error.where
                mentioned = value.strip('"') in f"{error.what} {where}"
                error.where = where if mentioned else ", ".join(filter(None, (value, where)))
            self._problems.add_plugin_error(key, error)
            return
        if plugin is not None:
            self._entries[kind], self._plugins[kind] = entry, plugin

    def _report_not_a_section(self, section: str, value: Any, example: str) -> None:
        listed = isinstance(value, list) and value and isinstance(value[0], dict)
        what = "is a list of sections, [[…]]" if listed else f"is {literal(value)}, not a section"
        self._report(section, f"{section} {what}", f"a section: [{section}], followed by {example}")

    def _options(self, section: str, model: type[_Model], given: Any = None) -> _Model | None:
        given = self._data.get(section, {}) if given is None else given
        if not isinstance(given, dict):
            self._report_not_a_section(section, given, "population = 100")
            return None
        values = {name: value for name, value in given.items() if name != PLUGIN}
        for name in values.keys() & model.model_fields.keys():
            typed = self._problems.typed.get(f"{section}.{name}")
            values[name] = options.convert_value(model.model_fields[name], values[name], typed)
        folders = {
            name: Path() if f"{section}.{name}" in self._problems.overrides else self._folder
            for name in values
        }
        try:
            # Strict validation of JSON, unlike that of Python values, accepts a list for a tuple.
            text = json.dumps(values, default=_reject_date)
            parsed = model.model_validate_json(
                text, strict=True, context=ReadableFiles(folders, self._roots)
            )
        except ValidationError as error:
            self._problems.add_option_errors(section, model, values, error)
            return None
        for name in model.model_fields:
            value = getattr(parsed, name)
            if isinstance(value, str) and len(value.encode(errors="replace")) > LONGEST_TEXT:
                key, limit = f"{section}.{name}", f"at most {LONGEST_TEXT:,} bytes"
                self._report(key, f"the text is too long: {literal(value)}", limit)
        return parsed


def _reject_date(value: Any) -> Any:
    """Return an invalid value for a date or time, which must not pass as a string."""
    return {"date or time": str(value)}


def _is_one_line(text: str) -> bool:
    return not any(unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") for c in text)

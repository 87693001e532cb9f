"""From a TOML file's values to an experiment, or to all its problems."""

import json
import unicodedata
from collections.abc import Mapping
from typing import Any, cast

from pydantic import BaseModel, ValidationError

from gaitsim import registry
from gaitsim.contracts import Organism
from gaitsim.errors import ExperimentError, GaitsimError, PluginError
from gaitsim.experiment.combination import (
    check_combination,
    check_islands,
    check_pairing,
    check_sizes,
)
from gaitsim.experiment.model import SCHEMA, Evolution, Experiment, Islands
from gaitsim.experiment.overrides import HEAD, SECTIONS, override
from gaitsim.experiment.problems import COMMAND_LINE, Overrides, Problems
from gaitsim.registry import KINDS, Entry, options, plugin_errors
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.toml import literal

_NAMES = {int: "a whole number", str: "a text in quotes"}
_NOT_IN_NAMES = frozenset('/\\:*?"<>|')
LONGEST_NAME = 200  # bytes; file systems take 255, and a run's number is put behind it


class Reader:
    """Reads one experiment and collects its problems on the way.

    Args:
        source: where the values come from, for messages.
        overrides: options to change in them.
        place: where the overrides come from, for messages.
    """

    def __init__(
        self, source: str, overrides: Overrides | None = None, place: str = COMMAND_LINE
    ) -> None:
        self.problems = Problems(source, overrides, place)

    def read(self, data: dict[str, Any]) -> Experiment:
        """Return the experiment of these values; `data` is changed by the overrides.

        Raises:
            ExperimentError: with all problems.
        """
        override(data, self.problems)
        for key in data:
            if key not in (*HEAD, *SECTIONS):
                self.problems.unknown("", key, [*HEAD, *SECTIONS])
        self._schema(data)
        name, description = self._name(data), self._description(data)
        seed = self._scalar(data, "seed", int, 0)
        if not 0 <= seed < 2**63:
            self._report("seed", f"{seed} is out of range", "a whole number from 0 to 2^63 − 1")
        evolution = cast(Evolution | None, self._options("evolution", Evolution, data))
        islands = cast(Islands | None, self._options("islands", Islands, data))
        entries: dict[str, Entry] = {}
        plugins: dict[str, Any] = {}
        for kind in KINDS:
            self._plugin(kind, data, entries, plugins)
        if evolution is not None:
            check_sizes(evolution, self.problems)
            check_pairing(evolution, entries, plugins, self.problems)
        if evolution is not None and islands is not None:
            check_islands(evolution, islands, self.problems)
        check_combination(entries, plugins, self.problems)
        if self.problems.found or evolution is None or islands is None:
            raise ExperimentError(self.problems.found)
        return Experiment(
            name, description, seed, evolution, **plugins, entries=entries, islands=islands
        )

    def read_organism(self, data: dict[str, Any]) -> tuple[Entry, Organism]:
        """The body alone, whatever is wrong with the rest.

        Raises:
            ExperimentError: with all the body's problems.
        """
        entries: dict[str, Entry] = {}
        plugins: dict[str, Any] = {}
        self._plugin("organism", data, entries, plugins)
        if self.problems.found:
            raise ExperimentError(self.problems.found)
        return entries["organism"], plugins["organism"]

    def _report(self, key: str, what: str, allowed: str = "", remedy: str = "") -> None:
        self.problems.report(key, what, allowed, remedy)

    def _schema(self, data: Mapping[str, Any]) -> None:
        schema = self._scalar(data, "schema", int, SCHEMA)
        if schema > SCHEMA:
            self._report(
                "schema",
                f"written for schema {schema}, by a newer gaitsim",
                f"up to {SCHEMA}",
                "update gaitsim: pip install --upgrade gaitsim",
            )
        elif schema < 1:
            self._report("schema", f"there is no schema {schema}", f"{SCHEMA}")

    def _name(self, data: Mapping[str, Any]) -> str:
        name = self._scalar(data, "name", str, "experiment")
        fits = (
            name == name.strip()
            and name[:1] not in ("", ".", "-")
            and not set(name) & _NOT_IN_NAMES
            and _is_one_line(name)
            and len(name.encode()) <= LONGEST_NAME
        )
        if not fits:
            self._report(
                "name",
                f"{literal(name)} cannot name a folder of runs",
                f'at most {LONGEST_NAME} letters, digits and signs but / \\ : * ? " < > |, no '
                "blank at either end, no dot or hyphen in front",
            )
        return cast(str, name)

    def _description(self, data: Mapping[str, Any]) -> str:
        description = self._scalar(data, "description", str, "")
        if not _is_one_line(description):
            self._report("description", f"{literal(description)} is not one line", "one line")
        return cast(str, description)

    def _scalar(self, data: Mapping[str, Any], key: str, kind: type[Any], default: Any) -> Any:
        value = data.get(key, default)
        typed = self.problems.typed(key)
        if kind is str and typed is not None and not isinstance(value, str):
            return str(typed)
        if type(value) is not kind:
            self._report(key, f"{literal(value)} is not {_NAMES[kind]}", _NAMES[kind])
            return default
        return value

    def _plugin(
        self,
        kind: str,
        data: Mapping[str, Any],
        entries: dict[str, Entry],
        plugins: dict[str, Any],
    ) -> None:
        section = data.get(kind, {})
        key = f"{kind}.{PLUGIN}"
        if not isinstance(section, dict):
            self._not_a_section(kind, section, f'{PLUGIN} = "…"')
            return
        name = section.get(PLUGIN)
        if not isinstance(name, str):
            what = f"{literal(name)} is not the name of a plugin"
            self._report(
                key,
                what if PLUGIN in section else f"no {kind} is chosen",
                ", ".join(registry.entries(kind)) or f"no installed package has any {kind}",
            )
            return
        try:
            entry = registry.find(kind, name)
        except PluginError as error:
            self._report(key, error.what, error.allowed, error.remedy)
            return
        try:
            model = registry.load_entry(entry)
            with plugin_errors(entry, "taking its options"):
                plugin = self._options(kind, model, data)
        except GaitsimError as error:
            self.problems.of_plugin(key, error)
            return
        if plugin is not None:
            entries[kind], plugins[kind] = entry, plugin

    def _not_a_section(self, section: str, value: Any, example: str) -> None:
        listed = isinstance(value, list) and value and isinstance(value[0], dict)
        what = "is a list of sections, [[…]]" if listed else f"is {literal(value)}, not a section"
        self._report(section, f"{section} {what}", f"[{section}] and below it {example}")

    def _options(
        self, section: str, model: type[BaseModel], data: Mapping[str, Any]
    ) -> BaseModel | None:
        given = data.get(section, {})
        if not isinstance(given, dict):
            self._not_a_section(section, given, "population = 100")
            return None
        values = {name: value for name, value in given.items() if name != PLUGIN}
        for name in values.keys() & model.model_fields.keys():
            typed = self.problems.typed(f"{section}.{name}")
            values[name] = options.fitting(model.model_fields[name], values[name], typed)
        try:
            # By way of JSON: strict, and yet a list will do for a tuple.
            return model.model_validate_json(json.dumps(values, default=_no_text), strict=True)
        except ValidationError as error:
            self.problems.of_options(section, model, values, error)
            return None


def _no_text(value: Any) -> Any:
    """A date or time: nothing that an option takes, and no text either."""
    return {"date or time": str(value)}


def _is_one_line(text: str) -> bool:
    return not any(unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") for c in text)

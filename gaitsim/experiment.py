"""An experiment: everything that a run is a function of. Frozen; to and from TOML."""

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from pydantic import BaseModel, ConfigDict, ValidationError

from gaitsim import options, registry
from gaitsim.contracts import (
    Crossover,
    Fitness,
    GenomeSpace,
    Mutation,
    Organism,
    Plugin,
    Selection,
    option,
)
from gaitsim.errors import ExperimentError, GaitsimError, PluginError, nearest
from gaitsim.presets import read_preset
from gaitsim.registry import Entry, containing

SCHEMA = 1


class Evolution(BaseModel):
    """How long and how large the search is. Options, not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    population: int = option(100, "individuals in each generation", ge=2, le=1_000_000)
    generations: int = option(300, "generations, the first one at random", ge=1, le=100_000_000)
    elites: int = option(1, "best individuals carried over unchanged", ge=0)
    target_score: float | None = option(None, "stop once the best score reaches this")
    max_evaluations: int | None = option(
        None, "stop before more individuals than this are evaluated", ge=1
    )
    stagnation: int | None = option(
        None, "stop after this many generations without a better best score", ge=1
    )
    fitness_threshold: float | None = option(
        None, "keep a champion once the best score beats this; none keeps none"
    )
    delta_fitness: float = option(
        0.1, "step by which the threshold then rises to the best score", gt=0
    )


@dataclass(frozen=True)
class Experiment:
    """A body, a fitness, a genetic scheme and a seed.

    Attributes:
        name: short name; runs are named after it.
        description: one line for lists.
        seed: of all randomness.
        evolution: size and length of the search.
        organism, fitness, selection, crossover, mutation: the plugins, options set.
        entries: where each of the five comes from, by kind.
    """

    name: str
    description: str
    seed: int
    evolution: Evolution
    organism: Organism
    fitness: Fitness
    selection: Selection
    crossover: Crossover
    mutation: Mutation
    entries: Mapping[str, Entry]

    def plugin(self, kind: str) -> Plugin:
        """The plugin of a kind."""
        return cast(Plugin, getattr(self, kind))

    def space(self) -> GenomeSpace:
        """The genome space of the body.

        Raises:
            PluginError: the body cannot say.
        """
        with containing(self.entries["organism"], "giving its genome space"):
            return self.organism.genome_space()

    def to_toml(self) -> str:
        """The experiment as TOML, every option written out with what it means."""
        import tomlkit

        document = tomlkit.document()
        document["schema"] = SCHEMA
        document["name"] = self.name
        document["description"] = self.description
        document["seed"] = self.seed
        document["evolution"] = _table(self.evolution, {})
        for kind in registry.KINDS:
            document[kind] = _table(self.plugin(kind), {"plugin": self.entries[kind].name})
        return tomlkit.dumps(document)


def _table(model: BaseModel, head: Mapping[str, str]) -> Any:
    import tomlkit

    table = tomlkit.table()
    for key, value in head.items():
        table[key] = value
    given = options.values(model)
    for name, field in type(model).model_fields.items():
        note = f"{field.description} ({options.allowed(field)})"
        if name in given:
            table[name] = given[name]
            table[name].comment(note)
        else:
            table.add(tomlkit.comment(f"{name} is not set: {note}"))
    return table


def load_experiment(reference: str, overrides: Sequence[str] = ()) -> Experiment:
    """The experiment of a preset's name or a TOML file's path.

    Args:
        reference: a preset's name, or a path; a path has a '/' or ends with '.toml'.
        overrides: 'KEY=VALUE' each, as 'mutation.rate=0.1'.

    Raises:
        ExperimentError: with all its problems.
        GaitsimError: there is no such preset or file, or it cannot be read.
    """
    path = Path(reference)
    if path.suffix == ".toml" or path.name != reference:
        return parse_experiment(_read(path), str(path), overrides)
    try:
        text = read_preset(reference)
    except PluginError as error:
        if path.exists() and error.remedy == "":
            error = PluginError(
                error.what, allowed=error.allowed, remedy=f"for the file of that name, ./{path}"
            )
        raise error from None
    return parse_experiment(text, f"preset {reference}", overrides)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise GaitsimError(
            f"{path} is not a text file in UTF-8: {error.reason} at byte {error.start}",
            remedy="save it as UTF-8, or start from 'gaitsim experiments show spider'",
        ) from None
    except OSError as error:
        raise GaitsimError(
            f"cannot read the experiment file {path}: {error.strerror}",
            remedy="check the path, or name a preset: 'gaitsim experiments list'",
        ) from None


def parse_experiment(text: str, source: str, overrides: Sequence[str] = ()) -> Experiment:
    """The experiment that a TOML text describes, after `overrides`.

    Raises:
        ExperimentError: with all the problems of file and overrides.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        problem = GaitsimError(f"not valid TOML: {error}", where=source)
        raise ExperimentError([problem]) from None
    return _Reader(source).read(data, overrides)


def with_overrides(experiment: Experiment, overrides: Sequence[str]) -> Experiment:
    """The same experiment with options changed."""
    return parse_experiment(experiment.to_toml(), "the experiment", overrides)


class _Reader:
    """Reads one experiment and collects its problems on the way."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.problems: list[GaitsimError] = []
        self.overridden: set[str] = set()

    def read(self, data: dict[str, Any], overrides: Sequence[str]) -> Experiment:
        self._override(data, overrides)
        known = {"schema", "name", "description", "seed", "evolution", *registry.KINDS}
        for key in data:
            if key not in known:
                self._report(key, f"unknown key {key!r}", _listing(known), nearest(key, [*known]))
        schema = self._scalar(data, "schema", int, SCHEMA)
        if schema > SCHEMA:
            self._report(
                "schema",
                f"written for schema {schema}, by a newer gaitsim",
                f"up to {SCHEMA}",
                "update gaitsim: pip install --upgrade gaitsim",
            )
        name = self._scalar(data, "name", str, "experiment")
        if not name.strip() or name in (".", "..") or set(name) & set('/\\\0\n:*?"<>|'):
            self._report("name", f"{name!r} cannot name a folder", "a plain file name")
        description = self._scalar(data, "description", str, "")
        seed = self._scalar(data, "seed", int, 0)
        if not 0 <= seed < 2**63:
            self._report("seed", f"{seed} is out of range", "a whole number from 0 to 2^63 − 1")
        evolution = self._model("evolution", Evolution, data.get("evolution", {}))
        entries: dict[str, Entry] = {}
        plugins: dict[str, Any] = {}
        for kind in registry.KINDS:
            self._plugin(kind, data, entries, plugins)
        if evolution is not None:
            self._check_sizes(cast(Evolution, evolution))
        self._check_combination(entries, plugins)
        if self.problems:
            raise ExperimentError(self.problems)
        return Experiment(
            name, description, seed, cast(Evolution, evolution), **plugins, entries=entries
        )

    def _override(self, data: dict[str, Any], overrides: Sequence[str]) -> None:
        for text in overrides:
            try:
                path, value = options.parse_assignment(text)
            except ValueError as error:
                self.problems.append(
                    GaitsimError(str(error), where="--set", allowed="as mutation.rate=0.1")
                )
                continue
            self.overridden.add(path)
            section, _, key = path.rpartition(".")
            table = data.setdefault(section, {}) if section else data
            if not isinstance(table, dict) or isinstance(data.get(path), dict):
                self._report(path, "a section is not an option", "as mutation.rate=0.1")
            elif value is None:
                table.pop(key, None)
            elif key == "plugin" and table.get("plugin") != value:
                # The old plugin's options mean nothing to the new one.
                kept = {k: v for k, v in table.items() if f"{section}.{k}" in self.overridden}
                table.clear()
                table.update(kept, plugin=value)
            else:
                table[key] = value

    def _report(self, key: str, what: str, allowed: str = "", remedy: str = "") -> None:
        place = "--set" if key in self.overridden else self.source
        self.problems.append(
            GaitsimError(what, where=f"{place}, key {key}", allowed=allowed, remedy=remedy)
        )

    def _scalar(self, data: Mapping[str, Any], key: str, kind: type[Any], default: Any) -> Any:
        value = data.get(key, default)
        if type(value) is not kind:
            self._report(key, f"{value!r} is not {_NAMES[kind]}", _NAMES[kind])
            return default
        return value

    def _plugin(
        self,
        kind: str,
        data: Mapping[str, Any],
        entries: dict[str, Entry],
        plugins: dict[str, Any],
    ) -> None:
        section = data.get(kind)
        if not isinstance(section, dict) or not isinstance(section.get("plugin"), str):
            names = _listing(registry.entries(kind))
            self._report(f"{kind}.plugin", f"no {kind} is chosen", names)
            return
        name = section["plugin"]
        try:
            model = registry.load_class(kind, name)
            entries[kind] = registry.find(kind, name)
        except PluginError as error:
            if error.where:
                self.problems.append(error)
            else:
                self._report(f"{kind}.plugin", error.what, error.allowed, error.remedy)
            return
        rest = {key: value for key, value in section.items() if key != "plugin"}
        try:
            with containing(entries[kind], "taking its options"):
                plugin = self._model(kind, model, rest)
        except PluginError as error:
            self.problems.append(error)
            return
        if plugin is not None:
            plugins[kind] = plugin

    def _model(self, section: str, model: type[BaseModel], data: Any) -> BaseModel | None:
        try:
            # By way of JSON: strict, and yet a list will do for a tuple.
            return model.model_validate_json(json.dumps(data, default=str), strict=True)
        except ValidationError as error:
            for detail in error.errors(include_url=False):
                self._explain(section, model, detail)
            return None

    def _explain(self, section: str, model: type[BaseModel], detail: Any) -> None:
        path = [str(part) for part in detail["loc"]]
        key = ".".join([section, *path])
        names = list(model.model_fields)
        field = model.model_fields.get(path[0]) if path else None
        given = detail["input"]
        if detail["type"] == "extra_forbidden":
            self._report(
                key, f"unknown key {path[0]!r}", _listing(names) or "none", nearest(path[0], names)
            )
        elif field is None:
            self._report(key, detail["msg"].removeprefix("Value error, "))
        else:
            if isinstance(given, float) and not math.isfinite(given):
                shown = f"{given} is not a finite number"
            else:
                shown = f"{given!r} is not allowed"
            choices = [word for word in _words(field) if isinstance(given, str)]
            self._report(
                key,
                f"{shown}: {field.description}",
                options.allowed(field),
                nearest(str(given), choices),
            )

    def _check_sizes(self, evolution: Evolution) -> None:
        if evolution.elites >= evolution.population:
            self._report(
                "evolution.elites",
                f"{evolution.elites} elites leave no room in a population of "
                f"{evolution.population}",
                f"a whole number < {evolution.population}",
            )
        limit = evolution.max_evaluations
        if limit is not None and limit < evolution.population:
            self._report(
                "evolution.max_evaluations",
                f"{limit} evaluations are fewer than a population of {evolution.population}",
                f"a whole number ≥ {evolution.population}",
            )

    def _check_combination(self, entries: Mapping[str, Entry], plugins: Mapping[str, Any]) -> None:
        """Refuse operators that do not work on the genomes, a fitness that lacks channels."""
        organism = plugins.get("organism")
        if organism is None:
            return
        body = entries["organism"].name
        try:
            with containing(entries["organism"], "giving its genome space"):
                space = organism.genome_space()
        except PluginError as error:
            self.problems.append(error)
            return
        for kind in ("crossover", "mutation"):
            operator = plugins.get(kind)
            if operator is not None and not isinstance(space, operator.spaces):
                able = [
                    name
                    for name, other in registry.scan(kind)[0].items()
                    if isinstance(space, cast("type[Mutation | Crossover]", other).spaces)
                ]
                self._report(
                    f"{kind}.plugin",
                    f"{entries[kind].name!r} does not work on the {space.name} genomes of the "
                    f"organism {body!r}",
                    _listing(able) or f"no installed {kind} works on them",
                )
        fitness = plugins.get("fitness")
        missing = [] if fitness is None else sorted({*fitness.needs} - {*organism.channels})
        if missing:
            able = [
                name
                for name, other in registry.scan("fitness")[0].items()
                if {*cast("type[Fitness]", other).needs} <= {*organism.channels}
            ]
            self._report(
                "fitness.plugin",
                f"{entries['fitness'].name!r} reads the channels {', '.join(missing)}, which the "
                f"organism {body!r} does not have",
                _listing(able) or "no installed fitness can judge it",
            )


_NAMES = {int: "a whole number", str: "a text in quotes"}


def _words(field: Any) -> list[str]:
    from typing import get_args

    return [value for value in get_args(field.annotation) if isinstance(value, str)]


def _listing(names: Any) -> str:
    return ", ".join(sorted(names))

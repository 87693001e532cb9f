"""The content of an experiment's TOML, readable even if its plugins are not installed."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from gaitsim import toml
from gaitsim.errors import GaitsimError
from gaitsim.experiment.model import (
    CONSTRAINTS,
    DEFAULT_SEARCH,
    TRANSFERABILITY,
    Evolution,
    Islands,
    Worlds,
)
from gaitsim.registry import KINDS
from gaitsim.registry.options import OPERATORS, PLUGIN

# Options of [evolution] that change the individuals. The others limit the length of the search and
# choose which individuals are saved.
_EVOLUTION_OPTIONS = ("population",)
_SAVING_OPTIONS = ("fitness_threshold", "delta_fitness")


_Model = TypeVar("_Model", bound=BaseModel)


@dataclass(frozen=True, eq=False)
class ExperimentOutline:
    """The values of an experiment's TOML, validated as far as possible without plugins.

    Attributes:
        name: name of the experiment.
        description: description for lists, one line.
        seed: seed of all random numbers.
        plugins: name of each plugin by kind; without operators for a search that uses none.
        evolution: size and length of the search.
        islands: populations that the search is divided into.
        worlds: worlds in which each individual is evaluated.
        sections: tables of the file, including the names of plugins.
    """

    name: str
    description: str
    seed: int
    plugins: Mapping[str, str]
    evolution: Evolution
    islands: Islands
    worlds: Worlds
    sections: Mapping[str, Mapping[str, Any]]

    def search_options(self) -> dict[str, dict[str, Any]]:
        """Return the options that change the individuals or the champions that are saved.

        They are grouped by section; `''` holds the seed.
        """
        found = {kind: dict(self.sections[kind]) for kind in self.plugins}
        evolution, islands = self.sections.get("evolution", {}), self.sections.get("islands", {})
        keys = [*_EVOLUTION_OPTIONS]
        if self.evolution.fitness_threshold is not None:  # otherwise, no champions are saved
            keys += _SAVING_OPTIONS
        found["evolution"] = {key: evolution[key] for key in keys if key in evolution}
        if self.islands.number > 1:  # with one island, these options have no effect
            found["islands"] = dict(islands)
        if self.worlds.count:
            found["worlds"] = self._worlds
        if tested := self.sections.get(TRANSFERABILITY):
            found[TRANSFERABILITY] = dict(tested)
        if bounds := self.sections.get(CONSTRAINTS):
            found[CONSTRAINTS] = dict(bounds)
        return {"": {"seed": self.seed}, **found}

    def options(self) -> dict[str, Any]:
        """Return all options by dotted key, as in `--set`; those of worlds only if in use."""
        found: dict[str, Any] = {"seed": self.seed}
        for section, table in self.sections.items():
            found |= toml.flatten(self._worlds if section == "worlds" else table, f"{section}.")
        return found

    @property
    def _worlds(self) -> dict[str, Any]:
        """The options of worlds that have an effect on scores."""
        if not self.worlds.count:
            return {}
        unused = () if self.worlds.number else ("ranges", "redraw")
        return {key: one for key, one in self.sections["worlds"].items() if key not in unused}


@lru_cache(maxsize=64)  # a program that watches a run parses the same text repeatedly
def read_outline(text: str, source: str) -> ExperimentOutline:
    """Parse the TOML of an experiment."""
    tables = toml.parse(text, source)
    sections = {name: table for name, table in tables.items() if isinstance(table, dict)}
    sections.setdefault("search", {PLUGIN: DEFAULT_SEARCH})
    plugins = {
        kind: sections.get(kind, {}).get(PLUGIN)
        for kind in KINDS
        if kind not in OPERATORS or kind in sections
    }
    seed = tables.get("seed", 0)
    labels = {key: tables.get(key, "") for key in ("name", "description")}
    missing = [f"{kind}.{PLUGIN}" for kind, name in plugins.items() if not isinstance(name, str)]
    missing += [] if type(seed) is int and 0 <= seed < 2**63 else ["seed"]
    missing += [key for key, text in labels.items() if not isinstance(text, str)]
    if missing:
        raise GaitsimError(
            f"{source} is not an experiment: {missing[0]} is missing or invalid",
            where=source,
            allowed="a seed, and sections that name their plugins: " + ", ".join(plugins),
            remedy="restore the file from a copy; the checkpoint of a run also contains its text",
            key=missing[0],
        )
    return ExperimentOutline(
        labels["name"],
        labels["description"],
        seed,
        {kind: str(name) for kind, name in plugins.items()},
        _section(Evolution, tables.get("evolution", {}), "evolution", source),
        _section(Islands, tables.get("islands", {}), "islands", source),
        _section(Worlds, tables.get("worlds", {}), "worlds", source),
        sections,
    )


def _section(model: type[_Model], table: Any, name: str, source: str) -> _Model:
    try:
        return model.model_validate(table)
    except ValidationError as error:
        wrong = error.errors()[0]
        key = ".".join([name, *map(str, wrong["loc"])])
        raise GaitsimError(
            f"{source} is not an experiment: {key} is invalid",
            where=f"{source}, key {key}",
            remedy="undo the last changes to the file",
            key=key,
        ) from None

"""The experiment itself, and how it is written."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, cast

from pydantic import BaseModel, ConfigDict

from gaitsim import toml
from gaitsim.contracts import (
    Crossover,
    Fitness,
    GenomeSpace,
    Mutation,
    Organism,
    Plugin,
    Search,
    Selection,
    option,
)
from gaitsim.experiment.transferability import NO_REALITY, TRANSFERABILITY, Transferability
from gaitsim.experiment.worlds import OWN_WORLD, WORLD, Worlds
from gaitsim.registry import KINDS, Entry, contract_error, options, plugin_errors
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.registry.python_entries import PythonEntry, is_outside
from gaitsim.repr_mixin import ReprField, ReprMixin

SCHEMA = 1
MOST_GENERATIONS = 100_000_000
DEFAULT_SEARCH = "genetic"
"""The search of an experiment file that names none."""


class Evolution(BaseModel):
    """How long and how large the search is. Options, not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    population: int = option(
        100, "individuals in each generation, on each island", ge=2, le=1_000_000
    )
    generations: int = option(
        300, "generations, the first one at random", ge=1, le=MOST_GENERATIONS
    )
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


class Islands(BaseModel):
    """Populations that evolve apart and now and then exchange their best. Options, not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    number: int = option(
        1,
        "islands: populations that evolve apart, each of the size evolution.population",
        ge=1,
        le=10_000,
    )
    topology: Literal["ring", "all"] = option(
        "ring", "an island's best go to the next one alone, or to all others"
    )
    every: int = option(10, "generations between two migrations", ge=1)
    migrants: int = option(2, "how many of an island's best replace the worst of a neighbour", ge=0)

    @property
    def immigrants(self) -> int:
        """How many come to each island in a migration."""
        sources = min(1, self.number - 1) if self.topology == "ring" else self.number - 1
        return self.migrants * sources


ONE_ISLAND = Islands()


@dataclass(frozen=True, repr=False)
class Experiment(ReprMixin):
    """A body, a fitness, a search and a seed.

    Attributes:
        name: short name; runs are named after it.
        description: one line for lists.
        seed: of all randomness.
        evolution: size and length of the search.
        organism, fitness, search: the plugins, options set.
        entries: where each plugin comes from, by kind.
        islands: in how many populations the search is parted.
        worlds: in which each individual is evaluated.
        transferability: what stands for reality, and how its difference is learnt.
        reality: the body in reality; None where nothing stands for it.
        selection, crossover, mutation: the operators, for a search that uses them.
    """

    name: str
    description: str
    seed: int
    evolution: Evolution
    organism: Organism
    fitness: Fitness
    search: Search
    entries: Mapping[str, Entry]
    islands: Islands = ONE_ISLAND
    worlds: Worlds = OWN_WORLD
    transferability: Transferability = NO_REALITY
    reality: Organism | None = None
    selection: Selection | None = None
    crossover: Crossover | None = None
    mutation: Mutation | None = None

    @property
    def individuals(self) -> int:
        """How many a generation has, on all islands."""
        return self.evolution.population * self.islands.number

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of its plugins: organism, fitness, search, and the operators of the search."""
        return tuple(kind for kind in KINDS if kind in self.entries)

    @property
    def in_python(self) -> tuple[PythonEntry, ...]:
        """Its functions and classes that were given in Python, which no package has."""
        return tuple(one for one in self.entries.values() if isinstance(one, PythonEntry))

    @property
    def outside(self) -> tuple[PythonEntry, ...]:
        """Those whose code is the user's, so that no file can reproduce the experiment."""
        return tuple(entry for entry in self.in_python if is_outside(entry.name))

    def check_given(self) -> None:
        """Refuse an experiment with functions that this process was not given.

        Raises:
            MissingFunctionError: it has one.
        """
        for entry in self.in_python:
            if entry.model is None:
                raise entry.missing

    def plugin(self, kind: str) -> Plugin:
        """The plugin of one of its `kinds`."""
        return cast(Plugin, getattr(self, kind))

    def space(self) -> GenomeSpace:
        """The genome space of the body.

        Raises:
            PluginError: the body cannot say.
        """
        return space_of(self.entries["organism"], self.organism)

    def sections(self) -> dict[str, BaseModel]:
        """The options that have a part in the result, by their section of the file."""
        found: dict[str, BaseModel] = {"evolution": self.evolution}
        if self.search.several:
            found["islands"] = self.islands
        if WORLD in type(self.organism).model_fields:
            found["worlds"] = self.worlds
        if self.reality is not None:
            found[TRANSFERABILITY] = self.transferability
        return found | {kind: self.plugin(kind) for kind in self.kinds}

    def to_dict(self) -> dict[str, Any]:
        """The experiment as values for JSON: what `to_toml` writes, without its comments.

        Raises:
            PluginError: a plugin has an option whose value JSON cannot hold.
        """
        found: dict[str, Any] = {
            "schema": SCHEMA,
            "name": self.name,
            "description": self.description,
            "seed": self.seed,
        }
        for name, model in self.sections().items():
            entry = self.entries.get(name)
            if entry is None:
                found[name] = options.values(model)
                continue
            with plugin_errors(entry, "writing its options"):
                found[name] = {PLUGIN: entry.name, **options.values(model)}
        return found

    def to_toml(self, *, brief: bool = False) -> str:
        """The experiment as TOML, every option written out with what it means.

        Args:
            brief: whether to show long texts by their beginning and size, for people.

        Raises:
            PluginError: a plugin has an option whose value TOML cannot hold.
        """
        import tomlkit

        document = tomlkit.document()
        document["schema"] = SCHEMA
        document["name"] = self.name
        document["description"] = self.description
        document["seed"] = self.seed
        for name, model in self.sections().items():
            entry = self.entries.get(name)
            if entry is None:
                document[name] = _table(model, {}, brief)
                continue
            with plugin_errors(entry, "writing its options"):
                document[name] = _table(model, {PLUGIN: entry.name}, brief)
            if isinstance(entry, PythonEntry) and entry in self.outside:
                document[name].add(tomlkit.comment(entry.notice))
        return tomlkit.dumps(document)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "name": self.name,
            "seed": self.seed,
            "population": self.evolution.population,
            "generations": self.evolution.generations,
            **{kind: self.entries[kind].name for kind in self.kinds},
        }

    def _repr_details(self) -> Mapping[str, ReprField]:
        return {**self._repr_fields(), "description": self.description}


def space_of(entry: Entry, organism: Organism) -> GenomeSpace:
    """The genome space of a body.

    Raises:
        PluginError: the body cannot say, or says something else.
    """
    with plugin_errors(entry, "giving its genome space"):
        space: object = organism.genome_space()
    if isinstance(space, GenomeSpace):
        return space
    raise contract_error(
        entry,
        f"gave a {type(space).__name__} from genome_space()",
        "a RealSpace, a BitSpace or another gaitsim.contracts.GenomeSpace",
    )


def _table(model: BaseModel, head: Mapping[str, str], brief: bool) -> Any:
    import tomlkit

    table = tomlkit.table()
    for key, value in head.items():
        table[key] = value
    given = options.values(model)
    if brief:
        given = {name: toml.brief(v) if toml.is_long(v) else v for name, v in given.items()}
    fields = type(model).model_fields
    # Below the others, which would else be far apart.
    for name in sorted(fields, key=lambda name: toml.is_long(given.get(name))):
        field = fields[name]
        about = options.meaning(field)
        note = _one_line(f"{about} ({options.allowed(field)})" if about else options.allowed(field))
        if name not in given and field.get_default(call_default_factory=True) is None:
            table.add(tomlkit.comment(f"{name} is not set: {note}"))
            continue
        if toml.is_long(given.get(name)):
            table.add(tomlkit.comment(f"{name}: {note}"))
            table.add(name, _multiline(given[name]))
            continue
        # Not set although its default is: left out, it would come back as the default.
        item = tomlkit.item(_inline(given[name]) if name in given else options.NOT_SET)
        table.add(name, item.comment(note))
    return table


def _one_line(text: str) -> str:
    """A text as a comment can hold it: a line break in it would end the comment."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _multiline(text: str) -> Any:
    """A text over several lines, as it stands where TOML allows that; else with escapes."""
    from tomlkit import string
    from tomlkit.items import String, StringType, Trivia

    plain = all(c.isprintable() or c in "\n\t" for c in text)
    if plain and "'''" not in text and not text.endswith("'"):
        # TOML drops a line break that follows the quotes.
        return String(StringType.MLL, text, f"\n{text}", Trivia())
    return string(text)


def _inline(value: Any) -> Any:
    """A value for one line: a dict as `{…}`, since a table of its own would end the section."""
    import tomlkit

    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update({key: _inline(item) for key, item in value.items()})
        return table
    if isinstance(value, list):
        array = tomlkit.array()
        array.extend(_inline(item) for item in value)
        return array
    return value

"""The experiment, and its form as TOML and JSON."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from gaitsim import toml
from gaitsim.contracts import (
    Crossover,
    Fitness,
    Genomes,
    GenomeSpace,
    Mutation,
    Organism,
    Plugin,
    Question,
    Search,
    Selection,
    option,
)
from gaitsim.contracts.search import BODY_STARTS, RANDOM_START
from gaitsim.registry import KINDS, Entry, contract_error, options, plugin_errors
from gaitsim.registry.entry_points import PythonEntry, is_outside
from gaitsim.registry.options import PLUGIN
from gaitsim.repr_mixin import ReprField, ReprMixin

WORLD = "world"
"""The option of a body that holds the conditions of its world."""


class Worlds(BaseModel):
    """Options for the worlds in which each individual is evaluated; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    number: int = option(
        0,
        "number of worlds, drawn from the seed and the same for all individuals, in which each one "
        "is evaluated; without drawn worlds and cases, only the world of the body's options is "
        "used. N worlds take N times as long, but count as one evaluation",
        ge=0,
        le=1000,
    )
    cases: tuple[dict[str, float], ...] = option(
        (),
        "worlds in which each individual is evaluated, besides the drawn ones: values of "
        "conditions by name, such as { friction = 0.4, latency = 0.03 }; the others are as in the "
        "world of the body's options",
    )
    ranges: dict[str, tuple[float, float]] = option(
        {},
        "lowest and highest value of each condition that varies, by name; {} varies all conditions "
        "of the body over their usual ranges, but for a few that must be named",
    )
    combine: Literal["mean", "worst", "worst tenth"] = option(
        "mean",
        "score of an individual: 'mean' is its mean score over all worlds, 'worst' its "
        "score in its worst world, 'worst tenth' its mean score over the worst tenth of "
        "its worlds",
    )
    redraw: int = option(
        0,
        "generations after which new worlds are drawn, and the best score is reset; 0 keeps the "
        "same worlds for the whole run",
        ge=0,
    )

    @property
    def own(self) -> "Worlds":
        """Options with only the body's own world; the ranges remain for unseen worlds."""
        return Worlds(ranges=self.ranges)

    @property
    def count(self) -> int:
        """Number of worlds, cases and drawn ones, in which each individual is evaluated."""
        return len(self.cases) + self.number

    @property
    def counted(self) -> int:
        """Number of an individual's worst worlds whose mean is its score."""
        share = {"mean": self.count, "worst": 1, "worst tenth": -(-self.count // 10)}
        return share[self.combine]

    def draw(self, generation: int) -> int:
        """Return the number of the draw of worlds for a generation, counted from 0."""
        return (generation - 1) // self.redraw if self.number and self.redraw else 0

    def first_of_draw(self, generation: int) -> int:
        """Return the first generation that is evaluated in the same worlds as `generation`."""
        return self.draw(generation) * self.redraw + 1

    def redraws(self, first: int, last: int) -> range:
        """Return the generations from `first` to `last` before which the worlds are redrawn."""
        if not (self.number and self.redraw):
            return range(0)
        first = max(first, 2)
        return range(first + (1 - first) % self.redraw, last + 1, self.redraw)

    def redrawn(self, generation: int) -> bool:
        """Return whether the worlds of a generation differ from those of the previous one."""
        return generation in self.redraws(generation, generation)


OWN_WORLD = Worlds()


TRANSFERABILITY = "transferability"
"""The section of an experiment, and the name of the prediction that a search reads."""

FEATURES = ("forward", "yaw", "body height", "slip ratio", "duty factor", "stride frequency")
"""The default features; a body may lack some of them."""


class Transferability(BaseModel):
    """Options for reality, and for learning how it differs from the simulation; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    reality: dict[str, Any] = option(
        {},
        "options of the body that represents reality, such as world = {friction = 0.3}; {} turns "
        "off tests in reality",
    )
    every: int = option(5, "generations between tests in reality, each of one individual", ge=1)
    features: tuple[str, ...] = option(
        (),
        "measures of the simulated motion from which the model predicts; [] uses those of "
        f"{', '.join(FEATURES[:-1])} and {FEATURES[-1]} that the body has",
    )

    def resolved(self, reality: Organism | None) -> "Transferability":
        """Return the options with `reality` as validated by the body."""
        if reality is None:
            return self
        validated = options.values(reality)
        values = {name: validated[name] for name in self.reality if name in validated}
        return self.model_copy(update={"reality": values})


NO_REALITY = Transferability()


CONSTRAINTS = "constraints"
"""The section of an experiment with constraints."""


class Constraints(BaseModel):
    """Bounds on terms and measures; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    at_most: dict[str, float] = option(
        {},
        'terms or measures that must not exceed a value, such as { "slip ratio" = 0.1 }; an '
        "individual that exceeds it fails",
    )
    at_least: dict[str, float] = option(
        {}, "terms or measures that must not be below a value; an individual below it fails"
    )

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the term or measure of each constraint."""
        return (*self.at_most, *self.at_least)

    def violations(self, values: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Return how far individuals are beyond each bound, (population, constraints).

        A constraint is satisfied if its violation is at most 0.

        Args:
            values: values of terms and measures by name, each (population,).
        """
        above = [values[name] - bound for name, bound in self.at_most.items()]
        below = [bound - values[name] for name, bound in self.at_least.items()]
        return np.stack([*above, *below], axis=-1)

    def reason(self, number: int, value: float) -> str:
        """Return why an individual fails that violates a constraint.

        Args:
            number: index of the constraint, in the order of `names`.
            value: value of its term or measure.
        """
        name, bounds = self.names[number], [*self.at_most.values(), *self.at_least.values()]
        limit = "most" if number < len(self.at_most) else "least"
        return f"{name} is {value:g}, and must be at {limit} {bounds[number]:g}"


UNCONSTRAINED = Constraints()


SCHEMA = 1
MOST_GENERATIONS = 100_000_000
DEFAULT_SEARCH = "genetic"
"""The search of an experiment file that does not choose one."""

PORTABLE = "portable"
"""The class of results that have the same bits on every processor."""


class Evolution(BaseModel):
    """Options for the size and length of a search; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    population: int = option(
        100, "number of individuals in each generation, on each island", ge=2, le=1_000_000
    )
    generations: int = option(
        300, "number of generations, including the first", ge=1, le=MOST_GENERATIONS
    )
    target_score: float | None = option(None, "stop once the best score reaches this value")
    max_evaluations: int | None = option(
        None, "stop before the number of evaluations exceeds this value", ge=1
    )
    stagnation: int | None = option(
        None, "stop after this many generations without an improvement of the best score", ge=1
    )
    fitness_threshold: float | None = option(
        None, "save a champion once the best score exceeds this threshold; none: save no champions"
    )
    delta_fitness: float = option(
        0.1,
        "after a champion is saved, the threshold rises in steps of this size until it "
        "reaches the best score",
        gt=0,
    )


class Islands(BaseModel):
    """Options for populations that evolve separately and exchange individuals; not a plugin."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    number: int = option(
        1,
        "number of islands; each is a separate population of 'evolution.population' individuals",
        ge=1,
        le=10_000,
    )
    topology: Literal["ring", "all"] = option(
        "ring",
        "islands that receive an island's best individuals: 'ring' is only the next "
        "island, 'all' is all others",
    )
    every: int = option(10, "generations between two migrations", ge=1)
    migrants: int = option(
        2,
        "number of an island's best individuals that replace the worst individuals of a "
        "receiving island",
        ge=0,
    )

    @property
    def immigrants(self) -> int:
        """Number of individuals that each island receives in a migration."""
        sources = min(1, self.number - 1) if self.topology == "ring" else self.number - 1
        return self.migrants * sources


ONE_ISLAND = Islands()


@dataclass(frozen=True, repr=False)
class Experiment(ReprMixin):
    """A body, a fitness, a search and a seed.

    Attributes:
        name: short name, after which runs are named.
        description: description for lists, one line.
        seed: seed of all random numbers.
        evolution: size and length of the search.
        organism, fitness, search: plugins with their options.
        entries: entry of each plugin, by kind.
        islands: populations that the search is divided into.
        worlds: worlds in which each individual is evaluated.
        transferability: options for reality, and for learning how it differs from simulation.
        reality: body that represents reality; None without tests in reality.
        constraints: bounds on terms and measures.
        selection, crossover, mutation: operators, for a search that uses them.
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
    constraints: Constraints = UNCONSTRAINED
    selection: Selection | None = None
    crossover: Crossover | None = None
    mutation: Mutation | None = None

    @property
    def individuals(self) -> int:
        """Number of individuals in a generation, on all islands."""
        return self.evolution.population * self.islands.number

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of the plugins: organism, fitness, search, and the operators of the search."""
        return tuple(kind for kind in KINDS if kind in self.entries)

    @property
    def outside(self) -> tuple[PythonEntry, ...]:
        """Entries with a user's code, without which files cannot reproduce the experiment."""
        return tuple(
            entry
            for entry in self.entries.values()
            if isinstance(entry, PythonEntry) and is_outside(entry.name)
        )

    @property
    def body_outside(self) -> bool:
        """Whether the body is a user's code, such as a function."""
        return any(entry.kind == "organism" for entry in self.outside)

    @property
    def engine(self) -> str:
        """Package of the physics engine that simulates the body, or ''.

        Raises:
            PluginError: the body fails.
        """
        bodies = [body for body in (self.organism, self.reality) if body is not None]
        with plugin_errors(self.entries["organism"], "naming its physics engine"):
            return next((name for name in (body.physics_engine() for body in bodies) if name), "")

    @property
    def undeclared(self) -> tuple[Entry, ...]:
        """Entries of the plugins that do not declare that they are portable."""
        return tuple(
            entry
            for kind, entry in self.entries.items()
            if not vars(type(self.plugin(kind))).get("portable", False)
        )

    @property
    def portability(self) -> str:
        """The class of the results and its meaning, as 'portable: the same bits …'.

        Raises:
            PluginError: the body fails.
        """
        if self.engine:
            return (
                f"engine-bound: the same bits with one version of {self.engine} on one kind of "
                "processor"
            )
        if self.undeclared:
            names = ", ".join(str(entry) for entry in self.undeclared)
            return f"not known to be portable: not declared by the {names}"
        return f"{PORTABLE}: the same bits with the same versions on any x86-64 or ARM64 processor"

    def warnings(self) -> tuple[str, ...]:
        """Return likely mistakes in the options of the body, each with a remedy.

        Raises:
            PluginError: the body fails.
        """
        with plugin_errors(self.entries["organism"], "checking its options for mistakes"):
            return tuple(self.organism.warnings())

    def questions(self) -> tuple[Question, ...]:
        """Return what the body guessed about its file.

        Raises:
            PluginError: the body fails.
        """
        with plugin_errors(self.entries["organism"], "asking about its file"):
            return tuple(self.organism.questions())

    def check_functions(self) -> None:
        """Check that all Python functions of the experiment are registered in this process."""
        for entry in self.outside:
            if entry.model is None:
                raise entry.missing_error

    def plugin(self, kind: str) -> Plugin:
        """Return the plugin of one of the `kinds`."""
        return cast(Plugin, getattr(self, kind))

    def space(self) -> GenomeSpace:
        """Return the genome space of the body.

        Raises:
            PluginError: the body fails or breaks its contract.
        """
        return space_of(self.entries["organism"], self.organism)

    def starts(self) -> dict[str, Genomes]:
        """Return the start points of the body by name, each (genes,).

        Raises:
            PluginError: the body fails or breaks its contract.
        """
        return starts_of(self.entries["organism"], self.organism, self.space())

    def sections(self) -> dict[str, BaseModel]:
        """Return the options that affect the result, by section of the file."""
        found: dict[str, BaseModel] = {"evolution": self.evolution}
        if self.search.several:
            found["islands"] = self.islands
        if WORLD in type(self.organism).model_fields:
            found["worlds"] = self.worlds
        if self.reality is not None:
            found[TRANSFERABILITY] = self.transferability
        if self.constraints.names:
            found[CONSTRAINTS] = self.constraints
        return found | {kind: self.plugin(kind) for kind in self.kinds}

    def to_dict(self) -> dict[str, Any]:
        """Return the experiment as values for JSON, the same values as in `to_toml`.

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
        """Return the experiment as TOML, with all options and a comment that describes each.

        Args:
            brief: whether to shorten long texts to their beginning and size, for display.

        Raises:
            PluginError: a plugin has an option whose value TOML cannot hold.
        """
        return self._as_toml(brief=True) if brief else self._toml

    @cached_property
    def _toml(self) -> str:  # a command writes and compares it several times
        return self._as_toml(brief=False)

    def _as_toml(self, *, brief: bool) -> str:
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
    """Return the genome space of a body."""
    with plugin_errors(entry, "returning its genome space"):
        space: object = organism.genome_space()
    if isinstance(space, GenomeSpace):
        return space
    raise contract_error(
        entry,
        f"returned a {type(space).__name__} from genome_space()",
        "a RealSpace, a BitSpace or another gaitsim.contracts.GenomeSpace",
    )


def starts_of(entry: Entry, organism: Organism, space: GenomeSpace) -> dict[str, Genomes]:
    """Return the start points of a body by name, each (genes,)."""
    with plugin_errors(entry, "returning its start points"):
        found = dict(organism.starts())
        for name, genome in found.items():
            if not (isinstance(name, str) and name.isprintable() and name.strip()):
                raise contract_error(entry, f"names a start point {name!r:.80}", "a printable name")
            if name in (BODY_STARTS, RANDOM_START):
                raise contract_error(entry, f"names a start point {name!r}", "another name")
            if not (isinstance(genome, np.ndarray) and space.contains(genome[None])):
                raise contract_error(
                    entry,
                    f"returned an invalid genome as the start point {name!r}",
                    f"a valid genome of shape (genes,) = ({space.genes},) in {space.dtype}",
                )
    return found


def _table(model: BaseModel, head: Mapping[str, str], brief: bool) -> Any:
    import tomlkit

    table = tomlkit.table()
    for key, value in head.items():
        table[key] = value
    given = options.values(model)
    if brief:
        given = {name: toml.brief(v) if toml.is_long(v) else v for name, v in given.items()}
    fields, notes = type(model).model_fields, _notes(type(model))
    long = {name for name, value in given.items() if toml.is_long(value)}
    # Long texts go last, because they would separate the other options.
    for name in sorted(fields, key=long.__contains__):
        field, note = fields[name], notes[name]
        if name not in given and field.get_default(call_default_factory=True) is None:
            table.add(tomlkit.comment(f"{name} is not set: {note}"))
            continue
        if name in long:
            table.add(tomlkit.comment(f"{name}: {note}"))
            table.add(name, _multiline(given[name]))
            continue
        # An unset option must be written: if omitted, it would be read as its default.
        item = tomlkit.item(_inline(given[name]) if name in given else options.NOT_SET)
        table.add(name, item.comment(note))
    return table


@lru_cache(maxsize=64)
def _notes(model: type[BaseModel]) -> dict[str, str]:
    """Return a comment, on one line, for each option of a class: meaning, type, bounds and unit."""
    found = {}
    for name, field in model.model_fields.items():
        about, allowed = options.meaning(field), options.allowed(field)
        text = f"{about} ({allowed})" if about else allowed
        found[name] = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return found


def _multiline(text: str) -> Any:
    """Return a TOML string of several lines, with escapes only if it cannot be literal."""
    from tomlkit import string
    from tomlkit.items import String, StringType, Trivia

    plain = all(c.isprintable() or c in "\n\t" for c in text)
    if plain and "'''" not in text and not text.endswith("'"):
        # TOML ignores the line break after the opening quotes.
        return String(StringType.MLL, text, f"\n{text}", Trivia())
    return string(text)


def _inline(value: Any) -> Any:
    """Return a value on one line: a dict as `{…}`, because a table would end the section."""
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

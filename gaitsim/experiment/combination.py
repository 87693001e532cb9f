"""Check that the parts of an experiment work together."""

from collections.abc import Collection, Mapping
from typing import Any

from gaitsim import registry
from gaitsim.contracts import (
    Condition,
    Crossover,
    Fitness,
    GenomeSpace,
    Mutation,
    Organism,
    Plugin,
    Search,
    Selection,
    check_world,
)
from gaitsim.contracts.search import BODY_STARTS, RANDOM_START
from gaitsim.errors import GaitsimError, nearest
from gaitsim.experiment.model import (
    CONSTRAINTS,
    NO_REALITY,
    TRANSFERABILITY,
    WORLD,
    Constraints,
    Evolution,
    Islands,
    Transferability,
    Worlds,
    space_of,
    starts_of,
)
from gaitsim.experiment.overrides import Problems
from gaitsim.registry import Entry
from gaitsim.registry.options import PLUGIN
from gaitsim.registry.python_plugins import MissingBody


class Combination:
    """Checks of the parts of an experiment that could be read; the others have been reported.

    Args:
        entries: entry of each plugin that could be read, by kind.
        plugins: these plugins, by kind.
        problems: problems of the experiment, to which the checks add theirs.
    """

    def __init__(
        self, entries: Mapping[str, Entry], plugins: Mapping[str, Any], problems: Problems
    ) -> None:
        self._entries, self._plugins, self._problems = entries, plugins, problems
        self._report = problems.report
        self._organism: Organism | None = plugins.get("organism")
        self._search: Search | None = plugins.get("search")

    def check_search(self, evolution: Evolution, islands: Islands) -> None:
        """Report a population size or islands that the search does not support."""
        search, organism = self._search, self._organism
        if search is None:
            return
        entry = self._entries["search"]
        if islands.number > 1 and not search.several:
            self._report(
                "islands.number", f"the search {entry.name!r} evolves only one population", "1"
            )
        if organism is None:
            return
        try:
            space = space_of(self._entries["organism"], organism)
        except GaitsimError:
            return  # reported by `check_genomes`, as is a space that the search does not support
        if not isinstance(space, search.spaces):
            return
        self._check_start(search.start, organism, space)
        objection = ""
        with (
            self._problems.recorded(f"search.{PLUGIN}"),
            registry.plugin_errors(entry, "checking the population size"),
        ):
            objection = search.objection(space, evolution.population)
        if objection:
            self._report(
                "evolution.population",
                objection,
                remedy="choose a different population, or different options of the search",
            )

    def _check_start(self, start: str, organism: Organism, space: GenomeSpace) -> None:
        """Report a start point that the body does not have."""
        if start in (BODY_STARTS, RANDOM_START):
            return
        entry = self._entries["organism"]
        with self._problems.recorded(f"organism.{PLUGIN}"):
            allowed = [BODY_STARTS, RANDOM_START, *starts_of(entry, organism, space)]
            if start not in allowed:
                what = f"the body {entry.name!r} has no start point {start!r}"
                self._report("search.start", what, ", ".join(allowed), nearest(start, allowed))

    def check_islands(self, evolution: Evolution, islands: Islands) -> None:
        """Report too many migrants for an island, and too few evaluations for one generation."""
        population, number = evolution.population, islands.number
        sources = islands.immigrants // max(islands.migrants, 1)
        if islands.immigrants >= population:
            most = (population - 1) // sources
            senders = f"each of {sources:,} neighbours" if sources > 1 else "the neighbour"
            self._report(
                "islands.migrants",
                f"{islands.migrants:,} migrants from {senders} leave no room in a population of "
                f"{population:,}",
                f"a whole number ≤ {most:,}",
                "set islands.topology = 'ring'"
                if sources > 1 and islands.migrants < population
                else "",
            )
        limit, individuals = evolution.max_evaluations, population * number
        if limit is not None and limit < individuals:
            each = f"{number:,} populations" if number > 1 else "a population"
            self._report(
                "evolution.max_evaluations",
                f"{limit:,} evaluations are not enough for {each} of {population:,}",
                f"a whole number ≥ {individuals:,}",
            )

    def check_worlds(self, evolution: Evolution, worlds: Worlds) -> None:
        """Report worlds of a body without conditions, unknown conditions, and invalid ranges."""
        organism = self._organism
        if not (worlds.count or worlds.ranges) or isinstance(organism, MissingBody | None):
            return
        stagnation = evolution.stagnation
        if worlds.number and worlds.redraw and stagnation and stagnation >= worlds.redraw:
            self._report(
                "evolution.stagnation",
                f"{stagnation:,} generations are never reached if worlds are redrawn every "
                f"{worlds.redraw:,} generations, because each redraw resets the best score",
                "none" if worlds.redraw == 1 else f"a whole number < {worlds.redraw:,}, or none",
            )
        entry = self._entries["organism"]
        conditions: Mapping[str, Condition] | None = None
        with self._problems.recorded(f"organism.{PLUGIN}"):
            with registry.plugin_errors(entry, "naming its conditions"):
                found = organism.conditions()
            if found and WORLD not in type(organism).model_fields:
                what = f"has conditions, but no option {WORLD!r}"
                raise registry.contract_error(entry, what, "both or neither")
            conditions = found
        if conditions is None:
            return
        if not conditions:
            self._report(
                "worlds",
                f"the body {entry.name!r} has no conditions that vary between worlds",
                "a body with conditions",
            )
            return
        for number, case in enumerate(worlds.cases):
            try:
                check_world(case, conditions)
            except GaitsimError as error:
                self._report(f"worlds.cases.{number}", error.what, error.allowed, error.remedy)
        for name, (low, high) in worlds.ranges.items():
            key = f"worlds.ranges.{name}"
            if name not in conditions:
                what = f"the body {entry.name!r} has no condition {name!r}"
                self._report(key, what, ", ".join(conditions), nearest(name, [*conditions]))
                continue
            one = conditions[name]
            if not one.least <= low <= high <= one.most:
                self._report(
                    key,
                    f"invalid range for the condition {name!r}: {low:g} to {high:g}",
                    f"[lowest, highest], from {one.least:g} to {one.most:g} {one.unit}".rstrip(),
                )

    def check_transferability(self, options: Transferability) -> Transferability:
        """Report tests in reality that the search does not use, or a lack of tests that it uses.

        Returns:
            The options; without reality if an override chose a search that does not use the tests.
        """
        search, reads = self._search, None
        if search is None:
            return options
        entry = self._entries["search"]
        with (
            self._problems.recorded(f"search.{PLUGIN}"),
            registry.plugin_errors(entry, "naming the values it reads"),
        ):
            reads = TRANSFERABILITY in search.reads()
        if reads is None:
            return options
        if reads and not options.reality:
            self._report(
                f"{TRANSFERABILITY}.reality",
                f"the search uses {TRANSFERABILITY!r}, but the experiment has no body that "
                "represents reality",
                "options of the body, such as { world = { friction = 0.3 } }",
                f"add a section [{TRANSFERABILITY}] with reality = {{ … }}",
            )
        elif options.reality and not reads:
            overrides = self._problems.overrides
            given = [key for key in overrides if key.partition(".")[0] == TRANSFERABILITY]
            if not given and f"search.{PLUGIN}" in overrides:
                return NO_REALITY
            self._report(
                given[0] if given else TRANSFERABILITY,
                f"the search {entry.name!r} does not use {TRANSFERABILITY!r}",
                "a search that uses it, such as 'nsga-2' with "
                f'objectives.{TRANSFERABILITY} = "max"',
                f"add this objective, or remove the section [{TRANSFERABILITY}]",
            )
        return options

    def check_constraints(
        self, constraints: Constraints, islands: Islands, reality: Organism | None
    ) -> None:
        """Report a search that cannot respect constraints."""
        search = self._search
        if search is None or not constraints.names:
            return
        several = "islands" if islands.number > 1 else "tests in reality" if reality else ""
        if several:
            self._report(CONSTRAINTS, f"constraints cannot be combined with {several}")
        elif search.keeps:
            self._report(
                CONSTRAINTS,
                f"the search {self._entries['search'].name!r} does not support constraints",
                "a search for one best individual, such as 'cma-es'",
            )
        for name in constraints.at_most.keys() & constraints.at_least.keys():
            low, high = constraints.at_least[name], constraints.at_most[name]
            if low > high:
                what = f"{name!r} cannot be at least {low:g} and at most {high:g}"
                self._report(f"{CONSTRAINTS}.at_least", what, f"a number ≤ {high:g}")

    def check_pairing(self, evolution: Evolution) -> None:
        """Report population sizes that the selection does not support."""
        selection: Selection | None = self._plugins.get("selection")
        crossover: Crossover | None = self._plugins.get("crossover")
        if selection is None or crossover is None:
            return
        size, elites, objection = evolution.population, getattr(self._search, "elites", 0), ""
        with (
            self._problems.recorded(f"selection.{PLUGIN}"),
            registry.plugin_errors(self._entries["selection"], "checking the population size"),
        ):
            objection = selection.objection(size, elites, crossover.children)
        if objection:
            self._report(
                "evolution.population",
                objection,
                f"{max(2, size - 1):,} or {size + 1:,}, or a different search.elites",
            )

    def check_genomes(self) -> None:
        """Report plugins that do not support the body's genomes or read channels it lacks."""
        organism = self._organism
        if isinstance(organism, MissingBody | None):
            return
        body, channels = self._entries["organism"].name, organism.channels
        space: GenomeSpace | None = None
        with self._problems.recorded(f"organism.{PLUGIN}"):
            space = space_of(self._entries["organism"], organism)
        for kind in ("search", "crossover", "mutation", "fitness"):
            plugin = self._plugins.get(kind)
            if plugin is None or compatible(type(plugin), channels, space):
                continue
            if kind == "fitness":
                missing = ", ".join(map(repr, sorted({*plugin.needs} - {*channels})))
                wrong = f"reads the channels {missing}, which the body {body!r} does not have"
            else:
                name = getattr(space, "name", type(space).__name__)
                wrong = (
                    f"does not support the genomes of the body {body!r}, which are of the kind "
                    f"{name!r}"
                )
            classes, _ = registry.scan(kind)
            usable = [name for name, other in classes.items() if compatible(other, channels, space)]
            self._report(
                f"{kind}.{PLUGIN}",
                f"{self._entries[kind].name!r} {wrong}",
                ", ".join(usable) or f"none, because no installed {kind} works with this body",
            )


def compatible(
    plugin: type[Plugin], channels: Collection[str] | None, space: GenomeSpace | None
) -> bool:
    """Return whether a plugin works with a body.

    Args:
        plugin: class of the plugin.
        channels: names of the body's channels; None if they are unknown.
        space: genome space of the body; None if it is unknown.
    """
    if issubclass(plugin, Fitness):
        return channels is None or {*plugin.needs} <= {*channels}
    if issubclass(plugin, Search | Crossover | Mutation):
        return space is None or isinstance(space, plugin.spaces)
    return True

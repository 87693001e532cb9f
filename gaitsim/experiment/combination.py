"""Check that the parts of an experiment work together."""

from collections.abc import Collection, Mapping
from typing import Any

from gaitsim import registry
from gaitsim.contracts import (
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


def check_search(
    evolution: Evolution,
    islands: Islands,
    entries: Mapping[str, Entry],
    plugins: Mapping[str, Any],
    problems: Problems,
) -> None:
    """Report a population size or islands that the search does not support."""
    search: Search | None = plugins.get("search")
    if search is None:
        return
    entry = entries["search"]
    if islands.number > 1 and not search.several:
        problems.report(
            "islands.number", f"the search {entry.name!r} evolves only one population", "1"
        )
    organism: Organism | None = plugins.get("organism")
    if organism is None:
        return
    try:
        space = space_of(entries["organism"], organism)
    except GaitsimError:
        return  # reported by `check_combination`, as is a space that the search does not support
    if not isinstance(space, search.spaces):
        return
    _check_start(search.start, entries["organism"], organism, space, problems)
    try:
        with registry.plugin_errors(entry, "checking the population size"):
            objection = search.objection(space, evolution.population)
    except GaitsimError as error:
        problems.add_plugin_error(f"search.{PLUGIN}", error)
        return
    if objection:
        problems.report(
            "evolution.population",
            objection,
            remedy="choose a different population, or different options of the search",
        )


def _check_start(
    start: str, entry: Entry, organism: Organism, space: GenomeSpace, problems: Problems
) -> None:
    """Report a start point that the body does not have."""
    if start in (BODY_STARTS, RANDOM_START):
        return
    try:
        allowed = [BODY_STARTS, RANDOM_START, *starts_of(entry, organism, space)]
    except GaitsimError as error:
        problems.add_plugin_error(f"organism.{PLUGIN}", error)
        return
    if start not in allowed:
        what = f"the body {entry.name!r} has no start point {start!r}"
        problems.report("search.start", what, ", ".join(allowed), nearest(start, allowed))


def check_islands(evolution: Evolution, islands: Islands, problems: Problems) -> None:
    """Report too many migrants for an island, and a limit of evaluations below one generation."""
    population, number = evolution.population, islands.number
    sources = islands.immigrants // max(islands.migrants, 1)
    if islands.immigrants >= population:
        most = (population - 1) // sources
        senders = f"each of {sources:,} neighbours" if sources > 1 else "the neighbour"
        problems.report(
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
        problems.report(
            "evolution.max_evaluations",
            f"{limit:,} evaluations are not enough for {each} of {population:,}",
            f"a whole number ≥ {individuals:,}",
        )


def check_worlds(
    evolution: Evolution,
    worlds: Worlds,
    entries: Mapping[str, Entry],
    plugins: Mapping[str, Any],
    problems: Problems,
) -> None:
    """Report worlds of a body without conditions, unknown conditions, and invalid ranges."""
    organism: Organism | None = plugins.get("organism")
    if organism is None or not (worlds.count or worlds.ranges):
        return
    if isinstance(organism, MissingBody):
        return
    stagnation = evolution.stagnation
    if worlds.number and worlds.redraw and stagnation and stagnation >= worlds.redraw:
        problems.report(
            "evolution.stagnation",
            f"{stagnation:,} generations are never reached if worlds are redrawn every "
            f"{worlds.redraw:,} generations, because each redraw resets the best score",
            "none" if worlds.redraw == 1 else f"a whole number < {worlds.redraw:,}, or none",
        )
    entry = entries["organism"]
    try:
        with registry.plugin_errors(entry, "naming its conditions"):
            conditions = organism.conditions()
        if conditions and WORLD not in type(organism).model_fields:
            what = f"has conditions, but no option {WORLD!r}"
            raise registry.contract_error(entry, what, "both or neither")
    except GaitsimError as error:
        problems.add_plugin_error(f"organism.{PLUGIN}", error)
        return
    if not conditions:
        problems.report(
            "worlds",
            f"the body {entry.name!r} has no conditions that vary between worlds",
            "a body with conditions",
        )
        return
    for number, case in enumerate(worlds.cases):
        try:
            check_world(case, conditions)
        except GaitsimError as error:
            problems.report(f"worlds.cases.{number}", error.what, error.allowed, error.remedy)
    for name, (low, high) in worlds.ranges.items():
        key = f"worlds.ranges.{name}"
        if name not in conditions:
            what = f"the body {entry.name!r} has no condition {name!r}"
            problems.report(key, what, ", ".join(conditions), nearest(name, [*conditions]))
            continue
        one = conditions[name]
        if not one.least <= low <= high <= one.most:
            problems.report(
                key,
                f"invalid range for the condition {name!r}: {low:g} to {high:g}",
                f"[lowest, highest], from {one.least:g} to {one.most:g} {one.unit}".rstrip(),
            )


def check_transferability(
    options: Transferability,
    entries: Mapping[str, Entry],
    plugins: Mapping[str, Any],
    problems: Problems,
) -> Transferability:
    """Report tests in reality that the search does not use, or a lack of tests that it uses.

    Returns:
        The options; without reality if an override chose a search that does not use the tests.
    """
    search: Search | None = plugins.get("search")
    if search is None:
        return options
    try:
        with registry.plugin_errors(entries["search"], "naming the values it reads"):
            reads = TRANSFERABILITY in search.reads()
    except GaitsimError as error:
        problems.add_plugin_error(f"search.{PLUGIN}", error)
        return options
    if reads and not options.reality:
        problems.report(
            f"{TRANSFERABILITY}.reality",
            f"the search uses {TRANSFERABILITY!r}, but the experiment has no body that represents "
            "reality",
            "options of the body, such as { world = { friction = 0.3 } }",
            f"add a section [{TRANSFERABILITY}] with reality = {{ … }}",
        )
    elif options.reality and not reads:
        given = [key for key in problems.overrides if key.partition(".")[0] == TRANSFERABILITY]
        if not given and f"search.{PLUGIN}" in problems.overrides:
            return NO_REALITY
        problems.report(
            given[0] if given else TRANSFERABILITY,
            f"the search {entries['search'].name!r} does not use {TRANSFERABILITY!r}",
            f"a search that uses it, such as 'nsga-2' with objectives.{TRANSFERABILITY} = \"max\"",
            f"add this objective, or remove the section [{TRANSFERABILITY}]",
        )
    return options


def check_constraints(
    constraints: Constraints,
    islands: Islands,
    reality: Organism | None,
    entries: Mapping[str, Entry],
    plugins: Mapping[str, Any],
    problems: Problems,
) -> None:
    """Report a search that cannot respect constraints."""
    search: Search | None = plugins.get("search")
    if search is None or not constraints.names:
        return
    several = "islands" if islands.number > 1 else "tests in reality" if reality else ""
    if several:
        problems.report(CONSTRAINTS, f"constraints cannot be combined with {several}")
    elif search.keeps:
        problems.report(
            CONSTRAINTS,
            f"the search {entries['search'].name!r} does not support constraints",
            "a search for one best individual, such as 'cma-es'",
        )
    for name in constraints.at_most.keys() & constraints.at_least.keys():
        low, high = constraints.at_least[name], constraints.at_most[name]
        if low > high:
            what = f"{name!r} cannot be at least {low:g} and at most {high:g}"
            problems.report(f"{CONSTRAINTS}.at_least", what, f"a number ≤ {high:g}")


def check_reality(reality: Organism, entry: Entry, organism: Organism, problems: Problems) -> None:
    """Report a body in reality with different genes."""
    if space_of(entry, reality).labels != space_of(entry, organism).labels:
        key = f"{TRANSFERABILITY}.reality"
        problems.report(
            key,
            f"the options in {key} change the genome",
            "options of the body that do not change the genome",
        )


def check_pairing(
    evolution: Evolution,
    entries: Mapping[str, Entry],
    plugins: Mapping[str, Any],
    problems: Problems,
) -> None:
    """Report population sizes that the selection does not support."""
    selection: Selection | None = plugins.get("selection")
    crossover: Crossover | None = plugins.get("crossover")
    if selection is None or crossover is None:
        return
    size, elites = evolution.population, getattr(plugins.get("search"), "elites", 0)
    try:
        with registry.plugin_errors(entries["selection"], "checking the population size"):
            objection = selection.objection(size, elites, crossover.children)
    except GaitsimError as error:
        problems.add_plugin_error("selection.plugin", error)
        return
    if objection:
        problems.report(
            "evolution.population",
            objection,
            f"{max(2, size - 1):,} or {size + 1:,}, or a different search.elites",
        )


def check_combination(
    entries: Mapping[str, Entry], plugins: Mapping[str, Any], problems: Problems
) -> None:
    """Report plugins that do not support the body's genomes or read channels that it lacks."""
    organism: Organism | None = plugins.get("organism")
    if organism is None or isinstance(organism, MissingBody):
        return
    body, channels = entries["organism"].name, organism.channels
    space: GenomeSpace | None = None
    try:
        space = space_of(entries["organism"], organism)
    except GaitsimError as error:
        problems.add_plugin_error("organism.plugin", error)
    for kind in ("search", "crossover", "mutation", "fitness"):
        plugin = plugins.get(kind)
        if plugin is None or compatible(type(plugin), channels, space):
            continue
        if kind == "fitness":
            missing = ", ".join(map(repr, sorted({*plugin.needs} - {*channels})))
            wrong = f"reads the channels {missing}, which the body {body!r} does not have"
        else:
            name = getattr(space, "name", type(space).__name__)
            wrong = (
                f"does not support the genomes of the body {body!r}, which are of the kind {name!r}"
            )
        classes, _ = registry.scan(kind)
        usable = [name for name, other in classes.items() if compatible(other, channels, space)]
        problems.report(
            f"{kind}.plugin",
            f"{entries[kind].name!r} {wrong}",
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

"""Whether the parts of an experiment work together."""

from collections.abc import Callable, Mapping
from typing import Any, cast

from gaitsim import registry
from gaitsim.contracts import Crossover, Fitness, GenomeSpace, Mutation, Organism, Plugin, Selection
from gaitsim.errors import GaitsimError
from gaitsim.experiment.model import Evolution, Islands, space_of
from gaitsim.experiment.problems import Problems
from gaitsim.registry import Entry


def check_sizes(evolution: Evolution, problems: Problems) -> None:
    """Refuse more elites than the population has room for."""
    population = evolution.population
    if evolution.elites >= population:
        problems.report(
            "evolution.elites",
            f"{evolution.elites:,} elites leave no room in a population of {population:,}",
            f"a whole number < {population:,}",
        )


def check_islands(evolution: Evolution, islands: Islands, problems: Problems) -> None:
    """Refuse migrants who would leave none of an island, a budget below one generation."""
    population, number = evolution.population, islands.number
    sources = islands.immigrants // max(islands.migrants, 1)
    if islands.immigrants >= population:
        most = (population - 1) // sources
        whence = f"each of {sources:,} neighbours" if sources > 1 else "the neighbour"
        problems.report(
            "islands.migrants",
            f"{islands.migrants:,} migrants from {whence} leave no room in a population of "
            f"{population:,}",
            f"a whole number ≤ {most:,}"
            + (", or the topology ring" if islands.topology == "all" and sources > 1 else ""),
        )
    limit, individuals = evolution.max_evaluations, population * number
    if limit is not None and limit < individuals:
        each = f"{number:,} populations" if number > 1 else "a population"
        problems.report(
            "evolution.max_evaluations",
            f"{limit:,} evaluations are fewer than {each} of {population:,}",
            f"a whole number ≥ {individuals:,}",
        )


def check_pairing(
    evolution: Evolution,
    entries: Mapping[str, Entry],
    plugins: Mapping[str, Any],
    problems: Problems,
) -> None:
    """Refuse sizes of the population that the selection cannot breed as it means to."""
    selection: Selection | None = plugins.get("selection")
    crossover: Crossover | None = plugins.get("crossover")
    if selection is None or crossover is None:
        return
    size, elites = evolution.population, evolution.elites
    try:
        with registry.plugin_errors(entries["selection"], "being asked for objections"):
            objection = selection.objection(size, elites, crossover.children)
    except GaitsimError as error:
        problems.of_plugin("selection.plugin", error)
        return
    if objection:
        problems.report(
            "evolution.population",
            objection,
            f"{max(2, size - 1):,} or {size + 1:,}, or other evolution.elites",
        )


def check_combination(
    entries: Mapping[str, Entry], plugins: Mapping[str, Any], problems: Problems
) -> None:
    """Refuse operators that do not work on the genomes, a fitness that lacks channels."""
    organism: Organism | None = plugins.get("organism")
    if organism is None:
        return
    body = entries["organism"].name
    try:
        space = space_of(entries["organism"], organism)
    except GaitsimError as error:
        problems.of_plugin("organism.plugin", error)
    else:
        for kind in ("crossover", "mutation"):
            operator = plugins.get(kind)
            if operator is not None and not isinstance(space, operator.spaces):
                problems.report(
                    f"{kind}.plugin",
                    f"{entries[kind].name!r} does not work on the {_name(space)} genomes of the "
                    f"organism {body!r}",
                    _able(kind, lambda other: isinstance(space, cast(_Operator, other).spaces))
                    or f"no installed {kind} works on them",
                )
    fitness: Fitness | None = plugins.get("fitness")
    missing = [] if fitness is None else sorted({*fitness.needs} - {*organism.channels})
    if missing:
        problems.report(
            "fitness.plugin",
            f"{entries['fitness'].name!r} reads the channels {', '.join(missing)}, which the "
            f"organism {body!r} does not have",
            _able("fitness", lambda other: {*cast(_Fitness, other).needs} <= {*organism.channels})
            or "no installed fitness can judge it",
        )


_Operator = type[Crossover] | type[Mutation]
_Fitness = type[Fitness]


def _name(space: GenomeSpace) -> str:
    return str(getattr(space, "name", type(space).__name__))


def _able(kind: str, works: Callable[[type[Plugin]], bool]) -> str:
    """The installed plugins of a kind that would work."""
    return ", ".join(name for name, other in registry.scan(kind)[0].items() if works(other))

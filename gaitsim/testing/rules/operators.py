"""Rules for crossover and mutation, on real genes and on bits."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, Mutation
from gaitsim.errors import PluginError
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.bits import same
from gaitsim.testing.rules.common import ANEW, array, rate, schedule, spaces


def crossover_rules(crossover: Crossover, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a crossover with its current options."""
    yield from schedule(crossover, Crossover)
    for what, space in _fitting(crossover):
        for pairs in (1, 9):
            random = np.random.default_rng(1)
            parents = [space.random(pairs, random), space.random(pairs, random)]
            shape = (pairs * crossover.children, space.genes)
            found = list(_bred("cross()", what, _crossing(crossover, space), parents, shape, space))
            yield from found
            if found:
                return
        figures["individuals_per_second"] = rate(_crossing(crossover, space), parents, shape[0])


def mutation_rules(mutation: Mutation, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a mutation with its current options."""
    found = list(schedule(mutation, Mutation))
    yield from found
    if found:
        return
    for what, space in _fitting(mutation):
        for count, generation in ((1, 1), (12, 1), (12, 1000)):
            mutating = _mutating(mutation.at(generation), space)
            parents = [space.random(count, np.random.default_rng(1))]
            shape = (count, space.genes)
            found = list(_bred("mutate()", what, mutating, parents, shape, space))
            yield from found
            if found:
                return
        figures["individuals_per_second"] = rate(mutating, parents, count)


def _fitting(plugin: Crossover | Mutation) -> Iterator[tuple[str, GenomeSpace]]:
    for what, space in spaces().items():
        if isinstance(space, plugin.spaces):
            yield what, space


def _crossing(crossover: Crossover, space: GenomeSpace) -> Callable[..., object]:
    return lambda mothers, fathers: crossover.cross(
        mothers, fathers, space, np.random.default_rng(7)
    )


def _mutating(mutation: Mutation, space: GenomeSpace) -> Callable[..., object]:
    return lambda genomes: mutation.mutate(genomes, space, np.random.default_rng(7))


def _bred(
    method: str,
    what: str,
    breed: Callable[..., object],
    parents: Sequence[Genomes],
    shape: tuple[int, ...],
    space: GenomeSpace,
) -> Iterator[Finding]:
    lent = [genomes.copy() for genomes in parents]
    try:
        children: Any = breed(*lent)
    except PluginError as problem:
        yield error(
            "genome space",
            f"{method} works on {what}, as 'spaces' declares",
            problem.what,
            "declare in 'spaces' those that it works on: (RealSpace,) or (BitSpace,)",
        )
        return
    problems = list(array(method, what, children, shape, space.dtype))
    yield from problems
    if problems:
        return
    if not all(map(same, lent, parents)):
        yield error(
            "inputs",
            "unchanged parents",
            f"{method} changes them ({what})",
            "work on a copy()",
        )
    if any(np.shares_memory(children, genomes) for genomes in lent):
        yield error(
            "inputs",
            f"a new array from {method}",
            f"the given one ({what})",
            "return a copy()",
        )
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        yield error(
            "finite values",
            "finite genes",
            f"genes that are not ({what})",
            "guard against overflow and division by 0",
        )
    elif not space.contains(space.repair(children)):
        yield error(
            "bounds", "genes that repair() can bring back", f"others ({what})", "bits are 0 and 1"
        )
    if not same(children, breed(*[genomes.copy() for genomes in parents])):
        yield error(
            "determinism", f"the same children from the same generator ({what})", "others", ANEW
        )

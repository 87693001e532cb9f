"""Rules for crossovers and mutations, with real genes and bits."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, Mutation
from gaitsim.errors import PluginError
from gaitsim.testing.report import Finding, any_error, error
from gaitsim.testing.rules.bits import same
from gaitsim.testing.rules.common import (
    STATELESS,
    check_array,
    check_schedule,
    measure_rate,
    supported_spaces,
)


def operator_rules(operator: Crossover | Mutation, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a crossover or a mutation with its current options."""
    crosses = isinstance(operator, Crossover)
    if (yield from any_error(check_schedule(operator, Crossover if crosses else Mutation))):
        return
    method, parents_per_child = ("cross()", 2) if crosses else ("mutate()", 1)
    for what, space in supported_spaces(operator):
        for count, generation in ((1, 1), (9, 1), (9, 1000)):
            scheduled, random = operator.at(generation), np.random.default_rng(1)
            parents = [space.random(count, random) for _ in range(parents_per_child)]
            children = scheduled.children if isinstance(scheduled, Crossover) else 1
            shape, breed = (count * children, space.genes), _bind_operator(scheduled, space)
            if (yield from any_error(_check_breeding(method, what, breed, parents, shape, space))):
                return
        figures["individuals_per_second"] = measure_rate(breed, parents, shape[0])


def _bind_operator(operator: Crossover | Mutation, space: GenomeSpace) -> Callable[..., object]:
    """Return a function that breeds from parents, always with the same random numbers."""
    if isinstance(operator, Crossover):
        return lambda mothers, fathers: operator.cross(
            mothers, fathers, space, np.random.default_rng(7)
        )
    return lambda genomes: operator.mutate(genomes, space, np.random.default_rng(7))


def _check_breeding(
    method: str,
    what: str,
    breed: Callable[..., object],
    parents: Sequence[Genomes],
    shape: tuple[int, ...],
    space: GenomeSpace,
) -> Iterator[Finding]:
    arguments = [genomes.copy() for genomes in parents]
    try:
        children: Any = breed(*arguments)
    except PluginError as problem:
        yield error(
            "genome space",
            f"{method} supports {what}, as 'spaces' declares",
            problem.what,
            "declare only supported spaces in 'spaces': (RealSpace,) or (BitSpace,)",
        )
        return
    if (yield from any_error(check_array(method, what, children, shape, space.dtype))):
        return
    if not all(map(same, arguments, parents)):
        yield error(
            "inputs",
            "unchanged parents",
            f"{method} changes them ({what})",
            "work on a copy made with copy()",
        )
    if any(np.shares_memory(children, genomes) for genomes in arguments):
        yield error(
            "inputs",
            f"a new array from {method}",
            f"memory shared with an argument ({what})",
            "return a copy made with copy()",
        )
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        yield error(
            "finite values",
            "finite genes",
            f"non-finite genes ({what})",
            "prevent overflow and division by 0",
        )
    elif not space.contains(space.repair(children)):
        yield error(
            "bounds",
            "genes that repair() can make valid",
            f"genes that stay invalid ({what})",
            "return only 0 and 1 as bits",
        )
    if not same(children, breed(*[genomes.copy() for genomes in parents])):
        yield error(
            "determinism",
            f"the same children from the same generator ({what})",
            "different children",
            STATELESS,
        )

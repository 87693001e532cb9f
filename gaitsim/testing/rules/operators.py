"""Rules for crossovers and mutations, with real genes and bits."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import Crossover, Genomes, GenomeSpace, Mutation, Selection
from gaitsim.errors import PluginError
from gaitsim.testing.report import Finding, advice, any_error, error
from gaitsim.testing.rules.common import (
    STATELESS,
    check_array,
    check_schedule,
    measure_rate,
    same,
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


def selection_rules(selection: Selection, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a selection with its current options."""
    random = np.random.default_rng(1).normal(size=40)
    cases = {
        "40 random scores": random,
        "half of them −inf": np.where(np.arange(40) % 2, random, -np.inf),
        "all of them −inf": np.full(40, -np.inf),
        "equal scores": np.zeros(40),
        "very large scores": random * 1e300,
        "two individuals": np.array([0.0, 1.0]),
    }
    yield from check_schedule(selection, Selection)
    for what, scores in cases.items():
        for pairs in (1, 21):
            if (yield from any_error(_check_parents(selection, what, scores, pairs))):
                return
    parents = selection.parents(random.copy(), 500, np.random.default_rng(2))
    if random[parents].mean() <= random.mean():
        yield advice(
            "selection",
            "parents whose mean score is higher than that of the population",
            f"a mean of {random[parents].mean():.3f}, and {random.mean():.3f} for the population",
            "prefer higher scores: np.argmax, or np.argsort(-scores)",
        )
    objection: object = selection.objection(40, 2, 2)
    if not isinstance(objection, str):
        yield error("objection", "objection() returns a string", f"{objection!r:.60}", "")
    figures["individuals_per_second"] = measure_rate(
        selection.parents, [random, 500, np.random.default_rng(2)], 1000
    )


def _check_parents(selection: Selection, what: str, scores: Any, pairs: int) -> Iterator[Finding]:
    argument = scores.copy()
    parents: object = selection.parents(argument, pairs, np.random.default_rng(7))
    yield from check_array("parents()", what, parents, (pairs, 2), np.dtype(np.intp))
    if not (isinstance(parents, np.ndarray) and parents.shape == (pairs, 2)):
        return
    if not ((parents >= 0) & (parents < len(scores))).all():
        yield error(
            "bounds",
            f"indices from 0 to {len(scores) - 1} ({what})",
            f"{parents.min()} to {parents.max()}",
            "return indices into the scores",
        )
    if not same(argument, scores):
        yield error(
            "inputs",
            "unchanged scores",
            "parents() changes them",
            "work on a copy made with copy()",
        )
    if not same(parents, selection.parents(scores.copy(), pairs, np.random.default_rng(7))):
        yield error(
            "determinism",
            f"the same parents from the same generator ({what})",
            "different parents",
            STATELESS,
        )
    each: Any = selection.parents_each(scores[None].copy(), pairs, np.random.default_rng(7))
    if not same(np.asarray(each), parents[None]):
        yield error(
            "parents_each",
            f"the same choice as parents() for a single population ({what})",
            "a different choice",
            "draw in the same order, or do not override parents_each()",
        )

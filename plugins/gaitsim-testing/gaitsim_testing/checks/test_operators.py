"""Checks of selections, and of crossovers and mutations, with real genes and bits."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gaitsim.plugin import OPERATORS, Crossover, Genomes, GenomeSpace, Mutation, Selection
from gaitsim_testing.finding import advise, require, require_array, require_type, require_unchanged
from gaitsim_testing.samples import (
    STATELESS,
    check_schedule,
    measure_rate,
    same,
    sample_spaces,
)

KINDS = OPERATORS
Record = Callable[..., None]


@pytest.mark.parametrize("what", sample_spaces())
def test_breeding(plugin: Any, what: str, record_property: Record) -> None:
    """Children are new, valid genomes, and the same from the same random numbers."""
    space = sample_spaces()[what]
    if isinstance(plugin, Selection) or not isinstance(space, plugin.spaces):
        return
    crosses = isinstance(plugin, Crossover)
    check_schedule(plugin, Crossover if crosses else Mutation)
    method, parents_per_child = ("cross()", 2) if crosses else ("mutate()", 1)
    for count, generation in ((1, 1), (9, 1), (9, 1000)):
        scheduled, random = plugin.at(generation), np.random.default_rng(1)
        parents = [space.random(count, random) for _ in range(parents_per_child)]
        children = count * (scheduled.children if crosses else 1)
        breed = _bind_operator(scheduled, space)
        arguments = [genomes.copy() for genomes in parents]
        bred: Any = breed(*arguments)
        require_array(method, what, bred, (children, space.genes), space.dtype)
        require_unchanged(all(map(same, arguments, parents)), method, f"the parents ({what})")
        require(
            not any(np.shares_memory(bred, genomes) for genomes in arguments),
            f"{method} shares memory with an argument ({what})",
            "a new array",
            "return a copy made with copy()",
        )
        require(
            bred.dtype.kind != "f" or np.isfinite(bred).all(),
            f"{method} returns genes that are not finite ({what})",
            "finite genes",
            "prevent overflow and division by 0",
        )
        require(
            space.contains(space.repair(bred)),
            f"{method} returns genes that stay invalid ({what})",
            "genes that repair() can make valid",
            "return only 0 and 1 as bits",
        )
        require(
            same(bred, breed(*[genomes.copy() for genomes in parents])),
            f"{method} returns different children from the same generator ({what})",
            "the same children",
            STATELESS,
        )
    record_property("rate", measure_rate(breed, parents, children))


def _bind_operator(operator: Crossover | Mutation, space: GenomeSpace) -> Callable[..., object]:
    """Return a function that breeds from parents, always with the same random numbers."""

    def breed(*parents: Genomes) -> object:
        method: Any = operator.cross if isinstance(operator, Crossover) else operator.mutate
        return method(*parents, space, np.random.default_rng(7))

    return breed


RANDOM = np.random.default_rng(1).normal(size=40)
SCORES = {
    "40 random scores": RANDOM,
    "half of them −inf": np.where(np.arange(40) % 2, RANDOM, -np.inf),
    "all of them −inf": np.full(40, -np.inf),
    "equal scores": np.zeros(40),
    "very large scores": RANDOM * 1e300,
    "two individuals": np.array([0.0, 1.0]),
}


@pytest.mark.parametrize("what", SCORES)
@pytest.mark.parametrize("pairs", [1, 21])
def test_parents(plugin: Any, what: str, pairs: int) -> None:
    """Parents are valid indices, and the same from the same random numbers."""
    if not isinstance(plugin, Selection):
        return
    scores = SCORES[what]
    argument = scores.copy()
    parents: Any = plugin.parents(argument, pairs, np.random.default_rng(7))
    require_array("parents()", what, parents, (pairs, 2), np.dtype(np.intp))
    require(
        ((parents >= 0) & (parents < len(scores))).all(),
        f"parents() returns {parents.min()} to {parents.max()} ({what})",
        f"indices from 0 to {len(scores) - 1}",
        "return indices into the scores",
    )
    require_unchanged(same(argument, scores), "parents()", "the scores")
    require(
        same(parents, plugin.parents(scores.copy(), pairs, np.random.default_rng(7))),
        f"parents() returns different parents from the same generator ({what})",
        "the same parents",
        STATELESS,
    )
    each: Any = plugin.parents_each(scores[None].copy(), pairs, np.random.default_rng(7))
    require(
        same(np.asarray(each), parents[None]),
        f"parents_each() makes a different choice for a single population ({what})",
        "the same choice as parents()",
        "draw in the same order, or do not override parents_each()",
    )


def test_selection(plugin: Any, record_property: Record) -> None:
    """Parents are better than the average, and schedule and objection are valid."""
    if not isinstance(plugin, Selection):
        return
    check_schedule(plugin, Selection)
    mean = RANDOM[plugin.parents(RANDOM.copy(), 500, np.random.default_rng(2))].mean()
    advise(
        mean > RANDOM.mean(),
        f"parents have a mean score of {mean:.3f}, and the population of {RANDOM.mean():.3f}",
        "parents whose mean score is higher than that of the population",
        "prefer higher scores: np.argmax, or np.argsort(-scores)",
    )
    require_type("objection()", plugin.objection(40, 2, 2), str)
    rate = measure_rate(plugin.parents, [RANDOM.copy(), 500, np.random.default_rng(2)], 1000)
    record_property("rate", rate)

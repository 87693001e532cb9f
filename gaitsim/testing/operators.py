"""Rules for selection, crossover and mutation, on real genes and on bits."""

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from gaitsim.contracts import (
    BitSpace,
    Crossover,
    Genomes,
    GenomeSpace,
    Mutation,
    Plugin,
    RealSpace,
    Selection,
)
from gaitsim.errors import PluginError
from gaitsim.testing.bits import same
from gaitsim.testing.report import Finding, advice, error

GENERATIONS = (1, 2, 1000, 1_000_000)

_NEW = "draw from the generator 'rng' alone, and remember nothing between calls"


def _at_most_half(genomes: Genomes) -> Genomes:
    """A repair: clears the last half of genomes of which more than half is set."""
    repaired = genomes.copy()
    repaired[genomes.sum(axis=1) > genomes.shape[1] / 2, genomes.shape[1] // 2 :] = 0
    return repaired


def spaces() -> dict[str, GenomeSpace]:
    """Genome spaces to try an operator on, by what they are."""
    lower = np.array([-1.0, 0.0, 1e-3, -np.pi, 10.0])
    width = np.array([2.0, 1e-6, 1.0, 2 * np.pi, 1e6])
    labels = tuple("abcde")
    return {
        "real genes": RealSpace(lower, lower + width, labels),
        "real genes, one periodic": RealSpace(
            lower, lower + width, labels, spread=width / 4, periodic=np.array([0, 0, 0, 1, 0], bool)
        ),
        "a single real gene": RealSpace(lower[:1], lower[:1] + 1, labels[:1]),
        "bits": BitSpace(tuple("abcdefg")),
        "bits with a repair": BitSpace(tuple("abcdefg"), _at_most_half),
    }


def _fitting(plugin: Crossover | Mutation) -> Iterator[tuple[str, GenomeSpace]]:
    for what, space in spaces().items():
        if isinstance(space, plugin.spaces):
            yield what, space


def selection_rules(selection: Selection, figures: dict[str, float]) -> Iterator[Finding]:
    """All rules for a selection, as its options are."""
    random = np.random.default_rng(1).normal(size=40)
    cases = {
        "40 random scores": random,
        "half of them −inf": np.where(np.arange(40) % 2, random, -np.inf),
        "all of them −inf": np.full(40, -np.inf),
        "equal scores": np.zeros(40),
        "very large scores": random * 1e300,
        "two individuals": np.array([0.0, 1.0]),
    }
    yield from _schedule(selection, Selection)
    for what, scores in cases.items():
        for pairs in (1, 21):
            found = list(_selected(selection, what, scores, pairs))
            yield from found
            if found:
                return
    parents = selection.parents(random.copy(), 500, np.random.default_rng(2))
    if random[parents].mean() <= random.mean():
        yield advice(
            "selection",
            "parents that score better than the population on the average",
            f"{random[parents].mean():.3f}, the population {random.mean():.3f}",
            "more is better: np.argmax, or np.argsort(-scores)",
        )
    objection: object = selection.objection(40, 2, 2)
    if not isinstance(objection, str):
        yield error("objection", "a text, '' where all is well", f"{objection!r:.60}", "")
    figures["individuals_per_second"] = _rate(
        lambda: selection.parents(random, 500, np.random.default_rng(2)), 1000
    )


def _selected(selection: Selection, what: str, scores: Any, pairs: int) -> Iterator[Finding]:
    lent = scores.copy()
    parents: object = selection.parents(lent, pairs, np.random.default_rng(7))
    yield from _array("parents()", what, parents, (pairs, 2), np.dtype(np.intp))
    if not (isinstance(parents, np.ndarray) and parents.shape == (pairs, 2)):
        return
    if not ((parents >= 0) & (parents < len(scores))).all():
        yield error(
            "bounds",
            f"indices from 0 to {len(scores) - 1} ({what})",
            f"{parents.min()} to {parents.max()}",
            "return indices into the scores",
        )
    if not same(lent, scores):
        yield error("inputs", "scores as they were given", "parents() changes them", "copy them")
    if not same(parents, selection.parents(scores.copy(), pairs, np.random.default_rng(7))):
        yield error(
            "determinism", f"the same parents from the same generator ({what})", "others", _NEW
        )
    each: Any = selection.parents_each(scores[None].copy(), pairs, np.random.default_rng(7))
    if not same(np.asarray(each), parents[None]):
        yield error(
            "parents_each",
            f"for one population what parents() chooses ({what})",
            "something else",
            "draw in the same order, or leave parents_each() out",
        )


def crossover_rules(crossover: Crossover, figures: dict[str, float]) -> Iterator[Finding]:
    """All rules for a crossover, as its options are."""
    yield from _schedule(crossover, Crossover)
    for what, space in _fitting(crossover):
        for pairs in (1, 9):
            random = np.random.default_rng(1)
            mothers, fathers = space.random(pairs, random), space.random(pairs, random)

            def cross(mothers: Genomes, fathers: Genomes, space: GenomeSpace = space) -> object:
                return crossover.cross(mothers, fathers, space, np.random.default_rng(7))

            shape = (pairs * crossover.children, space.genes)
            found = list(_bred("cross()", what, cross, [mothers, fathers], shape, space))
            yield from found
            if found:
                return
            figures["individuals_per_second"] = _rate(
                lambda m=mothers, f=fathers, s=space: crossover.cross(  # type: ignore[misc]
                    m, f, s, np.random.default_rng(7)
                ),
                shape[0],
            )


def mutation_rules(mutation: Mutation, figures: dict[str, float]) -> Iterator[Finding]:
    """All rules for a mutation, as its options are."""
    found = list(_schedule(mutation, Mutation))
    yield from found
    if found:
        return
    for what, space in _fitting(mutation):
        for count, generation in ((1, 1), (12, 1), (12, 1000)):
            scheduled = mutation.at(generation)
            genomes = space.random(count, np.random.default_rng(1))

            def mutate(
                genomes: Genomes, space: GenomeSpace = space, by: Mutation = scheduled
            ) -> object:
                return by.mutate(genomes, space, np.random.default_rng(7))

            found = list(_bred("mutate()", what, mutate, [genomes], genomes.shape, space))
            yield from found
            if found:
                return
            figures["individuals_per_second"] = _rate(lambda g=genomes: mutate(g), count)  # type: ignore[misc]


def _schedule(plugin: Plugin, contract: type[Plugin]) -> Iterator[Finding]:
    for generation in GENERATIONS:
        scheduled: object = plugin.at(generation)
        if not isinstance(scheduled, contract):
            yield error(
                "schedule",
                f"at({generation}) returns a {contract.__name__}",
                f"a {type(scheduled).__name__}",
                "return self.model_copy(update={…})",
            )
            return


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
            f"{method} works on {what}, of which 'spaces' speaks",
            problem.what,
            "spaces = (RealSpace,) or (BitSpace,), what it works on",
        )
        return
    problems = list(_array(method, what, children, shape, space.dtype))
    yield from problems
    if problems:
        return
    if not all(map(same, lent, parents)):
        yield error(
            "inputs",
            "parents as they were given",
            f"{method} changes them ({what})",
            "begin with a copy()",
        )
    if any(np.shares_memory(children, genomes) for genomes in lent):
        yield error(
            "inputs",
            f"a new array from {method}",
            f"the one that was given ({what})",
            "return a copy()",
        )
    if children.dtype.kind == "f" and not np.isfinite(children).all():
        yield error(
            "finite values",
            "finite genes",
            f"genes that are not ({what})",
            "guard what overflows or divides by 0",
        )
    elif not space.contains(space.confine(children)):
        yield error(
            "bounds", "genes that confining can bring back", f"others ({what})", "bits are 0 and 1"
        )
    if not same(children, breed(*[genomes.copy() for genomes in parents])):
        yield error(
            "determinism", f"the same children from the same generator ({what})", "others", _NEW
        )


def _array(
    method: str, what: str, thing: object, shape: tuple[int, ...], dtype: np.dtype[Any]
) -> Iterator[Finding]:
    expected = f"{method} returns an array of shape {shape}, dtype {dtype} ({what})"
    if not isinstance(thing, np.ndarray):
        yield error("shapes", expected, f"a {type(thing).__name__}", "return a NumPy array")
    elif thing.shape != shape:
        yield error("shapes", expected, f"shape {thing.shape}", "see the contract's docstring")
    elif thing.dtype != dtype:
        yield error("dtypes", expected, f"dtype {thing.dtype}", f"end with .astype({dtype.name!r})")


def _rate(work: Callable[[], object], count: int) -> float:
    begun = time.perf_counter()
    work()
    return count / max(time.perf_counter() - begun, 1e-9)

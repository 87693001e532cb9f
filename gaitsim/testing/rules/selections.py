"""Rules for a selection."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from gaitsim.contracts import Selection
from gaitsim.testing.report import Finding, advice, any_error, error
from gaitsim.testing.rules.bits import same
from gaitsim.testing.rules.common import STATELESS, check_array, check_schedule, measure_rate


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

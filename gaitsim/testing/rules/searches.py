"""Rules for a search: valid genomes, pure calls, and a state from which it can be resumed."""

import io
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gaitsim.contracts import Results, Search
from gaitsim.testing.report import Finding, advice, error, reported
from gaitsim.testing.rules.bits import differing, same
from gaitsim.testing.rules.common import ANEW, array, fitting, rate
from gaitsim.testing.rules.states import copied, described, state_rule, unchanged
from gaitsim.testing.rules.trials import CASES, GENERATIONS, POPULATIONS, Trial, parts

SMALL = (1, 2, 3, 4, 5)


def search_rules(search: Search, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a search with its current options."""
    reads: object = search.reads()
    if not (isinstance(reads, tuple) and all(isinstance(name, str) for name in reads)):
        yield error("reads", "reads() returns a tuple of names", f"{reads!r:.60}", "")
        return
    refused = []
    for what, space in fitting(search):
        objections: list[object] = [search.objection(space, size) for size in POPULATIONS + SMALL]
        if not all(isinstance(objection, str) for objection in objections):
            yield error("objection", "a string, '' for none", f"{objections[0]!r:.60}", "")
            return
        able = [
            size
            for size, objection in zip(POPULATIONS + SMALL, objections, strict=True)
            if not objection
        ]
        if not able:
            refused.append(f"{what}: {objections[0]}")
            continue
        least = Trial(search, space, min(able))
        if (yield from reported(_asked_and_told(least, f"{what}, population {min(able)}", 2))):
            return
        trial = Trial(search, space, able[0])
        if (yield from reported(_begun(trial, what))):
            return
        trial = replace(trial, begun=trial.initial())
        if (yield from reported(_in_space(trial, what))):
            return
        figures["individuals_per_second"] = rate(
            lambda trial: list(trial.run(GENERATIONS)), [trial], GENERATIONS * able[0]
        )
    if refused:
        yield advice(
            "objection",
            f"support for {POPULATIONS[0]} to {POPULATIONS[-1]} genomes of all spaces in 'spaces'",
            "; ".join(refused),
            "declare only supported spaces in 'spaces': (RealSpace,) or (BitSpace,)",
        )


def _begun(trial: Trial, what: str) -> Iterator[Finding]:
    """Check the state before the first generation."""
    state = trial.initial()
    if (yield from reported(state_rule("initial()", what, state, state))):
        return
    if not same(state, trial.initial()):
        expected = f"the same state from each call of initial() ({what})"
        yield error("determinism", expected, "different states", ANEW)


def _in_space(trial: Trial, what: str) -> Iterator[Finding]:
    for case in CASES:
        each, which = replace(trial, case=case), f"{what}, {case}"
        if (yield from reported(_asked_and_told(each, which, GENERATIONS))):
            return
        yield from described(each, which)
    if (yield from reported(_resumed(trial, what))):
        return
    yield from _warm_started(trial, what)
    if trial.search.several:
        yield from _several(trial, what)


def _asked_and_told(trial: Trial, what: str, generations: int) -> Iterator[Finding]:
    """Check each call of some generations; call each method twice with the same arguments."""
    search, last = trial.search, None
    state: Any = trial.initial()
    if (yield from reported(state_rule("initial()", what, state, state))):
        return
    first = state
    for generation in range(1, generations + 1):
        lent, lent_last = copied(state), last and _lent(last)
        answer: Any = search.ask(lent, lent_last, trial.context(generation, 1))
        if not (isinstance(answer, tuple) and len(answer) == 2):
            yield error("ask", "genomes and a state", f"a {type(answer).__name__}", "")
            return
        genomes, asked = answer
        shape = (trial.population, trial.space.genes)
        if (yield from reported(array("ask()", what, genomes, shape, trial.space.dtype))):
            return
        if not trial.space.contains(genomes):
            yield error(
                "bounds", f"valid genomes ({what})", "invalid genomes", "context.repair(genomes)"
            )
            return
        wrong = yield from reported(state_rule("ask()", what, asked, first))
        wrong |= yield from reported(
            unchanged("ask()", what, [state, parts(last)], [lent, parts(lent_last)])
        )
        again = search.ask(copied(state), last and _lent(last), trial.context(generation, 1))
        if not same([genomes, asked], list(again)):
            expected = f"the same result from a second call of ask() ({what})"
            yield error("determinism", expected, "different bits", ANEW)
            return
        asked, last = copied(asked), trial.evaluated(genomes.copy(), generation)
        lent, told = copied(asked), _lent(last)
        state = search.tell(lent, told, trial.context(generation, 2))
        wrong |= yield from reported(state_rule("tell()", what, state, first))
        wrong |= yield from reported(
            unchanged("tell()", what, [asked, parts(last)], [lent, parts(told)])
        )
        if wrong:
            return
        retold = search.tell(copied(asked), _lent(last), trial.context(generation, 2))
        if not same(state, retold):
            expected = f"the same result from a second call of tell() ({what})"
            yield error("determinism", expected, "different bits", ANEW)
            return
        state = copied(state)


def _lent(results: Results) -> Results:
    values = {name: one.copy() for name, one in results.values.items()}
    return Results(results.genomes.copy(), results.scores.copy(), values)


def _resumed(trial: Trial, what: str) -> Iterator[Finding]:
    """Check that another object continues from a stored state with the same bits."""
    whole = list(trial.run(GENERATIONS))
    for done in (1, GENERATIONS // 2):
        state, last = whole[done - 1]
        other = replace(trial, search=type(trial.search).model_validate(trial.search.model_dump()))
        rest = other.run(GENERATIONS, _stored(state), last, done)
        for (here, asked), (there, expected) in zip(rest, whole[done:], strict=True):
            name = differing(there, here)
            if name or not same(asked.genomes, expected.genomes):
                yield error(
                    "resume",
                    "the same bits after the state was stored and read, because runs are resumed",
                    f"{name or 'the genomes'} differs after generation {done} ({what})",
                    "keep everything that the next call needs in the state, as arrays",
                )
                return
        mismatch: object = trial.search.mismatch(_stored(state), trial.context(done + 1, 3))
        if mismatch != "":
            yield error("mismatch", f"'' for its own state ({what})", f"{mismatch!r:.60}", "")
            return


def _stored(state: Mapping[str, Any]) -> dict[str, Any]:
    """Write the state to a file, and return it as read from there."""
    file = io.BytesIO()
    np.savez(file, **state)
    file.seek(0)
    with np.load(file) as arrays:
        return dict(arrays)


def _warm_started(trial: Trial, what: str) -> Iterator[Finding]:
    start = trial.space.random(1, np.random.default_rng(9))[0]
    lent = start.copy()
    state = trial.search.initial(trial.context(1, 0, start=lent))
    genomes, _ = trial.search.ask(state, None, trial.context(1, 1, start=lent))
    if not (trial.space.contains(genomes) and len(genomes) == trial.population):
        expected = f"valid genomes after a warm start ({what})"
        yield error("bounds", expected, "invalid genomes", "")
    yield from unchanged("ask()", f"{what}, warm start", start, lent)


def _several(trial: Trial, what: str) -> Iterator[Finding]:
    """Check the shapes and the empty state of a search that handles several populations at once."""
    fix = "return {} as the state, or remove 'several = True'"
    state, last = trial.initial(), None
    for generation in (1, 2):
        context = trial.context(generation, 1, populations=(3,))
        genomes, state = trial.search.ask(state, last, context)
        shape = (3, trial.population, trial.space.genes)
        yield from array("ask()", f"{what}, three populations", genomes, shape, trial.space.dtype)
        if np.shape(genomes) != shape:
            return
        last = trial.evaluated(genomes, generation)
    if state:
        yield error("several", "an empty state, as 'several' requires", ", ".join(state), fix)

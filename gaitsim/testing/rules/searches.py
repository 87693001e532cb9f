"""Rules for a search: what it asks for, that its calls are pure, and that it can be resumed."""

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
            yield error("objection", "a text, '' if there is none", f"{objections[0]!r:.60}", "")
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
            f"work with {POPULATIONS[0]} to {POPULATIONS[-1]} genomes on all spaces in 'spaces'",
            "; ".join(refused),
            "declare in 'spaces' those that it works on: (RealSpace,) or (BitSpace,)",
        )


def _begun(trial: Trial, what: str) -> Iterator[Finding]:
    """Check the state before the first generation."""
    state = trial.initial()
    if (yield from reported(state_rule("initial()", what, state, state))):
        return
    if not same(state, trial.initial()):
        yield error("determinism", f"the same state from initial() ({what})", "another", ANEW)


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
    """Check each call of some generations, each called twice with the same arguments."""
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
                "bounds", f"genomes of the space ({what})", "others", "context.repair(genomes)"
            )
            return
        wrong = yield from reported(state_rule("ask()", what, asked, first))
        wrong |= yield from reported(
            unchanged("ask()", what, [state, parts(last)], [lent, parts(lent_last)])
        )
        again = search.ask(copied(state), last and _lent(last), trial.context(generation, 1))
        if not same([genomes, asked], list(again)):
            yield error("determinism", f"the same from ask() again ({what})", "other bits", ANEW)
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
            yield error("determinism", f"the same from tell() again ({what})", "other bits", ANEW)
            return
        state = copied(state)


def _lent(results: Results) -> Results:
    values = {name: one.copy() for name, one in results.values.items()}
    return Results(results.genomes.copy(), results.scores.copy(), values)


def _resumed(trial: Trial, what: str) -> Iterator[Finding]:
    """Check that a state that was stored continues to the same bits, in another object."""
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
                    "a state that was stored continues to the same bits, as resumed runs must",
                    f"{name or 'the genomes'} differs after generation {done} ({what})",
                    "keep in the state, as arrays, all that the next call needs",
                )
                return
        mismatch: object = trial.search.mismatch(_stored(state), trial.context(done + 1, 3))
        if mismatch != "":
            yield error("mismatch", f"'' for a state of its own ({what})", f"{mismatch!r:.60}", "")
            return


def _stored(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state written to a file and read again."""
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
        yield error("bounds", f"genomes of the space after a warm start ({what})", "others", "")
    yield from unchanged("ask()", f"{what}, warm start", start, lent)


def _several(trial: Trial, what: str) -> Iterator[Finding]:
    """Check a search that takes several populations at once: their shape, and an empty state."""
    fix = "populations are one more axis in front; or remove 'several = True'"
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

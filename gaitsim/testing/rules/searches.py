"""Rules for a search: valid genomes, pure calls, and a state from which it can be resumed."""

import io
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Members, Results, Search
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.testing.report import Finding, advice, any_error, error
from gaitsim.testing.rules.common import (
    STATELESS,
    check_array,
    first_difference,
    measure_rate,
    same,
    supported_spaces,
)
from gaitsim.testing.rules.trials import CASES, GENERATIONS, POPULATIONS, SearchTrial, result_arrays

COPY = "return new arrays: {**state, 'name': new}, and copy() arrays before changing them in place"


def copy_state(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a state, which a search may change without harm."""
    return {name: values.copy() for name, values in state.items()}


def check_state(method: str, what: str, state: Any, first: Any) -> Iterator[Finding]:
    """Check that a checkpoint can store a state, and that its names and dtypes have not changed.

    Args:
        method: method that returned the state, for messages.
        what: description of the trial's genome space and scores, for messages.
        state: returned value.
        first: initial state.
    """
    expected = f"{method} returns arrays of float64, int64, uint8 or bool by name ({what})"
    if not isinstance(state, Mapping):
        yield error("state", expected, f"a {type(state).__name__}", "return a dict")
        return
    for name, values in state.items():
        if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
            yield error(
                "state",
                f"{method} returns an array by a short printable name",
                f"{name!r:.60}",
                "rename the array",
            )
        elif not isinstance(values, np.ndarray):
            yield error(
                "state", expected, f"{name}: a {type(values).__name__}", "convert it: np.array(…)"
            )
        elif values.dtype.str not in STATE_DTYPES:
            yield error(
                "state", expected, f"{name}: {values.dtype}", "encode strings as UTF-8 in uint8"
            )
    kinds = {name: getattr(values, "dtype", None) for name, values in state.items()}
    initial = {name: getattr(values, "dtype", None) for name, values in first.items()}
    if kinds != initial:
        changed = sorted(str(name) for name in kinds.keys() ^ initial.keys()) or sorted(
            name for name in kinds if kinds[name] != initial[name]
        )
        yield error(
            "state",
            "always the names and dtypes that initial() returns; arrays may be empty",
            f"{', '.join(changed)}: changed after {method} ({what})",
            "return all of them from initial()",
        )


def check_unchanged(method: str, what: str, before: Any, after: Any) -> Iterator[Finding]:
    """Check that a call did not change its arguments."""
    if not same(before, after):
        yield error("inputs", f"unchanged arguments ({what})", f"{method} changes them", COPY)


def check_observers(trial: SearchTrial, what: str) -> Iterator[Finding]:
    """Check figures, members and remembered genomes after each generation."""
    search, names = trial.search, None
    for generation, (state, last) in enumerate(trial.run(GENERATIONS), 1):
        has_score = np.isfinite(last.scores).any()
        figures: object = search.figures(copy_state(state))
        if not isinstance(figures, Mapping) or names not in (None, list(figures)):
            yield error(
                "figures",
                f"figures() always returns the same names ({what})",
                f"{figures!r:.60}",
                "",
            )
            return
        names = list(figures)
        for name in names:
            # A best score may be −inf while all individuals have failed.
            if np.isnan(figures[name]) or (has_score and not np.isfinite(figures[name])):
                yield error(
                    "figures",
                    f"figures() returns finite numbers ({what})",
                    f"{name}: {figures[name]}",
                    "",
                )
                return
        if (yield from any_error(_check_members(trial, what, search.members(copy_state(state))))):
            return
        if (yield from any_error(_check_remembered(trial, what, state, generation))):
            return


def _check_members(trial: SearchTrial, what: str, members: object) -> Iterator[Finding]:
    keeps = trial.search.keeps
    if members is None or not keeps:
        if bool(keeps) != (members is not None):
            yield error(
                "members",
                f"members() returns a gaitsim.contracts.Members, because keeps = {keeps!r}"
                if keeps
                else "members() returns None, because keeps = ''",
                f"a {type(members).__name__}",
                "set 'keeps' to 'front' or 'archive' if members() returns any, otherwise to ''",
            )
        return
    if not isinstance(members, Members):
        expected = "members() returns a gaitsim.contracts.Members"
        yield error("members", expected, f"a {type(members).__name__}", "")
        return
    count = len(members.genomes)
    expected = f"members() returns valid genomes, each with a score and values ({what})"
    cells = members.cells
    if not (_are_valid(members.genomes, trial.space) and members.scores.shape == (count,)):
        wrong = "invalid genomes, or scores of the wrong shape"
        yield error(
            "members",
            expected,
            wrong,
            "return genomes of shape (members, genes) and scores of shape (members,)",
        )
    elif any(np.shape(values) != (count,) for values in members.values.values()):
        yield error(
            "members", expected, "values of the wrong shape", "return values of shape (members,)"
        )
    elif (keeps == "front") != (cells is None) or (
        cells is not None and (cells.ndim != 2 or len(cells) != count or cells.dtype != np.int64)
    ):
        yield error(
            "members",
            f"cells (members, axes) of int64 for an archive, None for a front ({what})",
            "None" if cells is None else f"{cells.dtype} {cells.shape}",
            "see the docstring of gaitsim.contracts.Members",
        )


def _are_valid(genomes: Genomes, space: GenomeSpace) -> bool:
    return not len(genomes) or space.contains(genomes)


def _check_remembered(
    trial: SearchTrial, what: str, state: Any, generation: int
) -> Iterator[Finding]:
    genomes: Any = trial.search.remembered(copy_state(state))
    if genomes is None or not len(genomes):
        results = Results(
            trial.space.random(0, np.random.default_rng(0)),
            np.empty(0),
            dict.fromkeys(trial.search.reads(), np.empty(0)),
        )
    elif not _are_valid(genomes, trial.space):
        expected = f"remembered() returns valid genomes, or None ({what})"
        yield error("remembered", expected, "invalid genomes", "")
        return
    else:
        results = trial.evaluate(genomes.copy(), generation)
    argument = copy_state(state)
    again = trial.search.rescored(argument, results, trial.context(generation, 3))
    yield from check_state("rescored()", what, again, state)
    yield from check_unchanged("rescored()", what, dict(state), argument)


SMALL = (1, 2, 3, 4, 5)


def search_rules(search: Search, figures: dict[str, float]) -> Iterator[Finding]:
    """Check all rules for a search with its current options."""
    reads: object = search.reads()
    if not (isinstance(reads, tuple) and all(isinstance(name, str) for name in reads)):
        yield error("reads", "reads() returns a tuple of names", f"{reads!r:.60}", "")
        return
    unsupported = []
    for what, space in supported_spaces(search):
        objections: list[object] = [search.objection(space, size) for size in POPULATIONS + SMALL]
        if not all(isinstance(objection, str) for objection in objections):
            yield error("objection", "objection() returns a string", f"{objections[0]!r:.60}", "")
            return
        supported = [
            size
            for size, objection in zip(POPULATIONS + SMALL, objections, strict=True)
            if not objection
        ]
        if not supported:
            unsupported.append(f"{what}: {objections[0]}")
            continue
        smallest = SearchTrial(search, space, min(supported))
        if (
            yield from any_error(
                _check_generations(smallest, f"{what}, population {min(supported)}", 2)
            )
        ):
            return
        trial = SearchTrial(search, space, supported[0])
        if (yield from any_error(_check_initial_state(trial, what))):
            return
        trial = replace(trial, initial_state=trial.initial())
        if (yield from any_error(_check_space(trial, what))):
            return
        figures["individuals_per_second"] = measure_rate(
            lambda trial: list(trial.run(GENERATIONS)), [trial], GENERATIONS * supported[0]
        )
    if unsupported:
        yield advice(
            "objection",
            f"support for populations of {POPULATIONS[0]} to {POPULATIONS[-1]} genomes of each "
            "class in 'spaces'",
            "; ".join(unsupported),
            "declare only supported spaces in 'spaces': (RealSpace,) or (BitSpace,)",
        )


def _check_initial_state(trial: SearchTrial, what: str) -> Iterator[Finding]:
    """Check the state before the first generation."""
    state = trial.initial()
    if (yield from any_error(check_state("initial()", what, state, state))):
        return
    if not same(state, trial.initial()):
        expected = f"the same state from each call of initial() ({what})"
        yield error("determinism", expected, "different states", STATELESS)


def _check_space(trial: SearchTrial, what: str) -> Iterator[Finding]:
    for case in CASES:
        case_trial, description = replace(trial, case=case), f"{what}, {case}"
        if (yield from any_error(_check_generations(case_trial, description, GENERATIONS))):
            return
        yield from check_observers(case_trial, description)
    if (yield from any_error(_check_resume(trial, what))):
        return
    yield from _check_starts(trial, what)
    if trial.search.several:
        yield from _check_several_populations(trial, what)


def _check_generations(trial: SearchTrial, what: str, generations: int) -> Iterator[Finding]:
    """Check `ask` and `tell` in the first generations; a second call must return the same."""
    search, last = trial.search, None
    state: Any = trial.initial()
    if (yield from any_error(check_state("initial()", what, state, state))):
        return
    first = state
    for generation in range(1, generations + 1):
        lent, lent_last = copy_state(state), last and _copy_results(last)
        answer: Any = search.ask(lent, lent_last, trial.context(generation, 1))
        if not (isinstance(answer, tuple) and len(answer) == 2):
            yield error(
                "ask", "ask() returns genomes and a state", f"a {type(answer).__name__}", ""
            )
            return
        genomes, asked = answer
        shape = (trial.population, trial.space.genes)
        if (yield from any_error(check_array("ask()", what, genomes, shape, trial.space.dtype))):
            return
        if not trial.space.contains(genomes):
            yield error(
                "bounds",
                f"ask() returns valid genomes ({what})",
                "invalid genomes",
                "return context.repair(genomes)",
            )
            return
        wrong = yield from any_error(check_state("ask()", what, asked, first))
        wrong |= yield from any_error(
            check_unchanged(
                "ask()", what, [state, result_arrays(last)], [lent, result_arrays(lent_last)]
            )
        )
        again = search.ask(
            copy_state(state), last and _copy_results(last), trial.context(generation, 1)
        )
        if not same([genomes, asked], list(again)):
            expected = f"the same result from a second call of ask() ({what})"
            yield error("determinism", expected, "different bits", STATELESS)
            return
        asked, last = copy_state(asked), trial.evaluate(genomes.copy(), generation)
        lent, told = copy_state(asked), _copy_results(last)
        state = search.tell(lent, told, trial.context(generation, 2))
        wrong |= yield from any_error(check_state("tell()", what, state, first))
        wrong |= yield from any_error(
            check_unchanged(
                "tell()", what, [asked, result_arrays(last)], [lent, result_arrays(told)]
            )
        )
        if wrong:
            return
        retold = search.tell(copy_state(asked), _copy_results(last), trial.context(generation, 2))
        if not same(state, retold):
            expected = f"the same result from a second call of tell() ({what})"
            yield error("determinism", expected, "different bits", STATELESS)
            return
        state = copy_state(state)


def _copy_results(results: Results) -> Results:
    values = {name: one.copy() for name, one in results.values.items()}
    return Results(results.genomes.copy(), results.scores.copy(), values)


def _check_resume(trial: SearchTrial, what: str) -> Iterator[Finding]:
    """Check that a new search object continues bit for bit from a stored state."""
    whole = list(trial.run(GENERATIONS))
    for done in (1, GENERATIONS // 2):
        state, last = whole[done - 1]
        other = replace(trial, search=type(trial.search).model_validate(trial.search.model_dump()))
        rest = other.run(GENERATIONS, _store_and_load(state), last, done)
        for (state_found, found), (state_expected, expected) in zip(
            rest, whole[done:], strict=True
        ):
            name = first_difference(state_expected, state_found)
            if name or not same(found.genomes, expected.genomes):
                yield error(
                    "resume",
                    "the same bits after saving and loading the state, because runs can be resumed",
                    f"{name or 'genomes'}: different after generation {done} ({what})",
                    "keep everything that the next call needs in the state, as arrays",
                )
                return
        mismatch: object = trial.search.mismatch(_store_and_load(state), trial.context(done + 1, 3))
        if mismatch != "":
            yield error(
                "mismatch",
                f"mismatch() returns '' for the search's state ({what})",
                f"{mismatch!r:.60}",
                "",
            )
            return


def _store_and_load(state: Mapping[str, Any]) -> dict[str, Any]:
    """Write the state to a file, and return the state that is read back."""
    file = io.BytesIO()
    np.savez(file, **state)
    file.seek(0)
    with np.load(file) as arrays:
        return dict(arrays)


def _check_starts(trial: SearchTrial, what: str) -> Iterator[Finding]:
    for count in (1, trial.population + 1):
        starts = trial.space.random(count, np.random.default_rng(9))
        lent = starts.copy()
        state = trial.search.initial(trial.context(1, 0, starts=lent))
        genomes, _ = trial.search.ask(state, None, trial.context(1, 1, starts=lent))
        if not (trial.space.contains(genomes) and len(genomes) == trial.population):
            expected = f"valid genomes around {count} start points ({what})"
            yield error("bounds", expected, "invalid genomes", "")
        yield from check_unchanged("ask()", f"{what}, {count} start points", starts, lent)


def _check_several_populations(trial: SearchTrial, what: str) -> Iterator[Finding]:
    """Check shapes, and that the state is empty, for several populations at once."""
    fix = "return {} as the state, or remove 'several = True'"
    state, last = trial.initial(), None
    for generation in (1, 2):
        context = trial.context(generation, 1, populations=(3,))
        genomes, state = trial.search.ask(state, last, context)
        shape = (3, trial.population, trial.space.genes)
        yield from check_array(
            "ask()", f"{what}, three populations", genomes, shape, trial.space.dtype
        )
        if np.shape(genomes) != shape:
            return
        last = trial.evaluate(genomes, generation)
    if state:
        yield error("several", "an empty state, as 'several' requires", ", ".join(state), fix)

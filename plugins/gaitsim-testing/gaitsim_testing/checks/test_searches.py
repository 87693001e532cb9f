"""Checks of a search: valid genomes, pure calls, and a state from which it can be resumed."""

import io
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from gaitsim.plugin import STATE_DTYPES, Genomes, GenomeSpace, Members, Results, Search
from gaitsim_testing.finding import advise, require, require_array, require_type
from gaitsim_testing.samples import (
    STATELESS,
    first_difference,
    measure_rate,
    same,
    sample_spaces,
)
from gaitsim_testing.trials import CASES, GENERATIONS, POPULATIONS, SearchTrial, result_arrays

KINDS = ("search",)
COPY = "return new arrays: {**state, 'name': new}, and copy() arrays before changing them in place"
SMALL = (1, 2, 3, 4, 5)


def _copy_state(state: Mapping[str, Any]) -> dict[str, Any]:
    return {name: values.copy() for name, values in state.items()}


def _copy_results(results: Results | None) -> Results | None:
    if results is None:
        return None
    values = {name: one.copy() for name, one in results.values.items()}
    return Results(results.genomes.copy(), results.scores.copy(), values)


def _check_state(method: str, what: str, state: Any, first: Any) -> None:
    """Check that a checkpoint can store a state, and that its names and dtypes have not changed.

    Args:
        method: method that returned the state, for messages.
        what: description of the trial's genome space and scores, for messages.
        state: returned value.
        first: initial state.
    """
    expected = f"arrays of float64, int64, uint8 or bool by short printable names ({what})"
    require(isinstance(state, Mapping), f"{method} returns a {type(state).__name__}", expected)
    for name, values in state.items():
        require(
            isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200,
            f"the state from {method} has the name {name!r:.60}",
            expected,
            "rename the array",
        )
        is_array = isinstance(values, np.ndarray)
        require(
            is_array and values.dtype.str in STATE_DTYPES,
            f"the state from {method} has {name}: "
            + (str(values.dtype) if is_array else f"a {type(values).__name__}"),
            expected,
            "convert it: np.array(…); encode strings as UTF-8 in uint8",
        )
    kinds = {name: str(values.dtype) for name, values in state.items()}
    initial = {name: str(getattr(values, "dtype", "")) for name, values in first.items()}
    changed = [name for name in {**kinds, **initial} if kinds.get(name) != initial.get(name)]
    require(
        not changed,
        f"{', '.join(changed)}: changed after {method} ({what})",
        "always the names and dtypes that initial() returns; arrays may be empty",
        "return all of them from initial()",
    )


def _require_kept(kept: bool, method: str, what: str) -> None:
    require(kept, f"{method} changes its arguments", f"unchanged arguments ({what})", COPY)


@pytest.fixture(scope="session")
def search(plugin: Any) -> Search:
    """The search with its options."""
    assert isinstance(plugin, Search)
    reads: object = plugin.reads()
    require(
        isinstance(reads, tuple) and all(isinstance(name, str) for name in reads),
        f"reads() returns {reads!r:.60}",
        "a tuple of names",
    )
    return plugin


@pytest.fixture(scope="session", params=sample_spaces())
def what(request: pytest.FixtureRequest) -> str:
    """The name of a genome space."""
    return str(request.param)


@pytest.fixture(scope="session")
def sizes(search: Search, what: str) -> list[int]:
    """The sizes of populations that the search supports in a genome space."""
    space = sample_spaces()[what]
    if not isinstance(space, search.spaces):
        pytest.skip("the search does not support the genome space")
    objections: list[Any] = [search.objection(space, size) for size in POPULATIONS + SMALL]
    for one in objections:
        require(isinstance(one, str), f"objection() returns {one!r:.60}", "a string")
    supported = zip(POPULATIONS + SMALL, objections, strict=True)
    found = [size for size, objection in supported if not objection]
    advise(
        found,
        f"{what}: {objections[0]}",
        f"support for populations of {POPULATIONS[0]} to {POPULATIONS[-1]} genomes of each "
        "class in 'spaces'",
        "declare only supported spaces in 'spaces': (RealSpace,) or (BitSpace,)",
    )
    if not found:
        pytest.skip("the search does not support the genome space")
    return found


@pytest.fixture(scope="session")
def trial(search: Search, what: str, sizes: list[int]) -> SearchTrial:
    """The search in a genome space, with the same state before the first generation each time."""
    trial = SearchTrial(search, sample_spaces()[what], sizes[0])
    state = trial.initial()
    _check_state("initial()", what, state, state)
    require(
        same(state, trial.initial()),
        f"initial() returns different states ({what})",
        "the same state from each call",
        STATELESS,
    )
    return replace(trial, initial_state=state)


def test_small_population(search: Search, what: str, sizes: list[int]) -> None:
    """The first generations of the smallest population are valid."""
    trial = SearchTrial(search, sample_spaces()[what], min(sizes))
    _check_generations(trial, f"{what}, population {min(sizes)}", 2)


@pytest.mark.parametrize("case", CASES)
def test_generations(trial: SearchTrial, what: str, case: str) -> None:
    """Generations, figures, members and remembered genomes are valid with these scores."""
    trial, what = replace(trial, case=case), f"{what}, {case}"
    _check_generations(trial, what, GENERATIONS)
    names = None
    for generation, (state, last) in enumerate(trial.run(GENERATIONS), 1):
        names = _check_figures(trial, what, state, last, names)
        _check_members(trial, what, trial.search.members(_copy_state(state)))
        _check_remembered(trial, what, state, generation)


def _check_generations(trial: SearchTrial, what: str, generations: int) -> None:
    """Check `ask` and `tell` in the first generations; a second call must return the same."""
    search: Any = trial.search
    last: Results | None = None
    state: Any = trial.initial()
    _check_state("initial()", what, state, state)
    first = state
    for generation in range(1, generations + 1):
        lent, lent_last = _copy_state(state), _copy_results(last)
        recorded: list[tuple[Any, ...]] = []
        context = replace(trial.context(generation, 1), record_parents=partial(_record, recorded))
        answer: Any = search.ask(lent, lent_last, context)
        require(
            isinstance(answer, tuple) and len(answer) == 2,
            f"ask() returns a {type(answer).__name__}",
            "genomes and a state",
        )
        genomes, asked = answer
        shape = (trial.population, trial.space.genes)
        require_array("ask()", what, genomes, shape, trial.space.dtype)
        require(
            trial.space.contains(genomes),
            f"ask() returns invalid genomes ({what})",
            "valid genomes",
            "return context.repair(genomes)",
        )
        _check_state("ask()", what, asked, first)
        _check_parents(trial, what, recorded, state, last)
        kept = same([state, result_arrays(last)], [lent, result_arrays(lent_last)])
        _require_kept(kept, "ask()", what)
        context = trial.context(generation, 1)
        again = search.ask(_copy_state(state), _copy_results(last), context)
        _require_same([genomes, asked], list(again), "ask()", what)
        asked, last = _copy_state(asked), trial.evaluate(genomes.copy(), generation)
        lent, told = _copy_state(asked), _copy_results(last)
        state = search.tell(lent, told, trial.context(generation, 2))
        _check_state("tell()", what, state, first)
        kept = same([asked, result_arrays(last)], [lent, result_arrays(told)])
        _require_kept(kept, "tell()", what)
        context = trial.context(generation, 2)
        _require_same(
            state, search.tell(_copy_state(asked), _copy_results(last), context), "tell()", what
        )
        state = _copy_state(state)


def _record(recorded: list[tuple[Any, ...]], *given: Any) -> None:
    recorded.append(given)


def _check_parents(
    trial: SearchTrial,
    what: str,
    recorded: list[tuple[Any, ...]],
    state: Any,
    last: Results | None,
) -> None:
    """Check the parents that `ask` has recorded, if any."""
    if not recorded:
        return
    remembered = trial.search.remembered(_copy_state(state))
    none = 0 if last is None else len(last.genomes)
    pool = none if remembered is None else len(remembered)
    require(
        len(recorded) == 1,
        f"ask() records parents {len(recorded)} times ({what})",
        "once, or never",
        "call context.record_parents with the parents of all genomes",
    )
    rows, *before = recorded[0]
    require_array("record_parents()", what, rows, (trial.population, 2), np.dtype(np.int64))
    for genomes in before:
        shape = (trial.population, trial.space.genes)
        require_array("record_parents()", what, genomes, shape, trial.space.dtype)
    require(
        bool(((rows >= -1) & (rows < pool)).all()),
        f"ask() records parents that do not exist ({what})",
        f"rows of the {pool} genomes that the search remembers, or −1 for none",
        "see gaitsim.contracts.search.Parents",
    )


def _require_same(one: object, other: object, method: str, what: str) -> None:
    actual = f"a second call of {method} returns different bits ({what})"
    require(same(one, other), actual, "the same result from each call", STATELESS)


def _check_figures(
    trial: SearchTrial, what: str, state: Any, last: Results, names: list[str] | None
) -> list[str]:
    """Check the figures after a generation, and return their names."""
    figures: Any = trial.search.figures(_copy_state(state))
    require(
        isinstance(figures, Mapping) and names in (None, list(figures)),
        f"figures() returns {figures!r:.60} ({what})",
        "always the same names",
    )
    for name, value in figures.items():
        # A best score may be −inf while all individuals have failed.
        finite = np.isfinite(value) or (not np.isnan(value) and not np.isfinite(last.scores).any())
        require(finite, f"figures() returns {name}: {value} ({what})", "finite numbers")
    return list(figures)


def _check_members(trial: SearchTrial, what: str, members: Any) -> None:
    keeps = trial.search.keeps
    if members is None or not keeps:
        require(
            members is None and not keeps,
            f"members() returns a {type(members).__name__}, with keeps = {keeps!r}",
            "a gaitsim.contracts.Members if keeps is 'front' or 'archive', otherwise None",
            "set 'keeps' to 'front' or 'archive' if members() returns any, otherwise to ''",
        )
        return
    require_type("members()", members, Members)
    count, cells = len(members.genomes), members.cells
    require(
        _are_valid(members.genomes, trial.space) and members.scores.shape == (count,),
        f"members() returns invalid genomes, or scores of the wrong shape ({what})",
        "valid genomes, each with a score and values",
        "return genomes of shape (members, genes) and scores of shape (members,)",
    )
    require(
        all(np.shape(values) == (count,) for values in members.values.values()),
        f"members() returns values of the wrong shape ({what})",
        "valid genomes, each with a score and values",
        "return values of shape (members,)",
    )
    fits = cells is None or (cells.ndim == 2 and len(cells) == count and cells.dtype == np.int64)
    require(
        fits and (keeps == "front") == (cells is None),
        f"members() returns the cells {None if cells is None else (cells.dtype, cells.shape)}",
        f"cells (members, axes) of int64 for an archive, None for a front ({what})",
        "see the docstring of gaitsim.contracts.Members",
    )


def _are_valid(genomes: Genomes, space: GenomeSpace) -> bool:
    return not len(genomes) or space.contains(genomes)


def _check_remembered(trial: SearchTrial, what: str, state: Any, generation: int) -> None:
    genomes: Any = trial.search.remembered(_copy_state(state))
    if genomes is None or not len(genomes):
        results = Results(
            trial.space.no_genomes,
            np.empty(0),
            dict.fromkeys(trial.search.reads(), np.empty(0)),
        )
    else:
        require(
            _are_valid(genomes, trial.space),
            f"remembered() returns invalid genomes ({what})",
            "valid genomes, or None",
        )
        results = trial.evaluate(genomes.copy(), generation)
    argument = _copy_state(state)
    again = trial.search.rescored(argument, results, trial.context(generation, 3))
    _check_state("rescored()", what, again, state)
    _require_kept(same(dict(state), argument), "rescored()", what)


def test_resume(trial: SearchTrial, what: str) -> None:
    """A new search object continues bit for bit from a stored state."""
    whole = list(trial.run(GENERATIONS))
    for done in (1, GENERATIONS // 2):
        state, last = whole[done - 1]
        other = replace(trial, search=type(trial.search).model_validate(trial.search.model_dump()))
        rest = other.run(GENERATIONS, _store_and_load(state), last, done)
        for (found_state, found), (expected_state, expected) in zip(
            rest, whole[done:], strict=True
        ):
            name = first_difference(expected_state, found_state)
            require(
                not name and same(found.genomes, expected.genomes),
                f"{name or 'genomes'}: different after generation {done} ({what})",
                "the same bits after saving and loading the state, because runs can be resumed",
                "keep everything that the next call needs in the state, as arrays",
            )
        mismatch: object = trial.search.mismatch(_store_and_load(state), trial.context(done + 1, 3))
        require(
            mismatch == "",
            f"mismatch() returns {mismatch!r:.60} for the search's own state ({what})",
            "''",
        )


def _store_and_load(state: Mapping[str, Any]) -> dict[str, Any]:
    """Write the state to a file, and return the state that is read back."""
    file = io.BytesIO()
    np.savez(file, **state)
    file.seek(0)
    with np.load(file) as arrays:
        return dict(arrays)


def test_starts(trial: SearchTrial, what: str) -> None:
    """A few or many start points are valid, and unchanged."""
    for count in (1, trial.population + 1):
        starts = trial.space.random(count, np.random.default_rng(9))
        lent = starts.copy()
        state = trial.search.initial(trial.context(1, 0, starts=lent))
        genomes, _ = trial.search.ask(state, None, trial.context(1, 1, starts=lent))
        require(
            trial.space.contains(genomes) and len(genomes) == trial.population,
            f"ask() returns invalid genomes around {count} start points ({what})",
            "valid genomes",
        )
        _require_kept(same(starts, lent), "ask()", f"{what}, {count} start points")


def test_several_populations(trial: SearchTrial, what: str) -> None:
    """Shapes fit several populations at once, without a state, if `several` declares them."""
    if not trial.search.several:
        return
    state, last = trial.initial(), None
    for generation in (1, 2):
        context = trial.context(generation, 1, populations=(3,))
        genomes, state = trial.search.ask(state, last, context)
        shape = (3, trial.population, trial.space.genes)
        require_array("ask()", f"{what}, three populations", genomes, shape, trial.space.dtype)
        last = trial.evaluate(genomes, generation)
    require(
        not state,
        f"the state has {', '.join(state)}",
        "an empty state, as 'several' requires",
        "return {} as the state, or remove 'several = True'",
    )


def test_speed(trial: SearchTrial, record_property: Callable[..., None]) -> None:
    """Measure the genomes per second."""
    count = GENERATIONS * trial.population
    rate = measure_rate(lambda trial: list(trial.run(GENERATIONS)), [trial], count)
    record_property("rate", rate)

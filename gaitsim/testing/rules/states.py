"""Rules for the state of a search, its figures and its members."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Members
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.testing.report import Finding, any_error, error
from gaitsim.testing.rules.bits import same
from gaitsim.testing.rules.trials import GENERATIONS, Trial

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


def check_observers(trial: Trial, what: str) -> Iterator[Finding]:
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


def _check_members(trial: Trial, what: str, members: object) -> Iterator[Finding]:
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


def _check_remembered(trial: Trial, what: str, state: Any, generation: int) -> Iterator[Finding]:
    genomes: Any = trial.search.remembered(copy_state(state))
    if genomes is None or not len(genomes):
        return
    if not _are_valid(genomes, trial.space):
        expected = f"remembered() returns valid genomes, or None ({what})"
        yield error("remembered", expected, "invalid genomes", "")
        return
    results = trial.evaluate(genomes.copy(), generation)
    argument = copy_state(state)
    again = trial.search.rescored(argument, results, trial.context(generation, 3))
    yield from check_state("rescored()", what, again, state)
    yield from check_unchanged("rescored()", what, dict(state), argument)

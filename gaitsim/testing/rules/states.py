"""Rules for the state of a search, its figures and its members."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, Members
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.testing.report import Finding, error, reported
from gaitsim.testing.rules.bits import same
from gaitsim.testing.rules.trials import GENERATIONS, Trial

COPY = "return new arrays: {**state, 'name': new}, and copy() arrays before changing them in place"


def copied(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of a state, to pass to a search."""
    return {name: values.copy() for name, values in state.items()}


def state_rule(method: str, what: str, state: Any, first: Any) -> Iterator[Finding]:
    """Check that a state has arrays that a checkpoint can store, with the initial names."""
    expected = f"{method} returns arrays of float64, int64, uint8 or bool by name ({what})"
    if not isinstance(state, Mapping):
        yield error("state", expected, f"a {type(state).__name__}", "return a dict")
        return
    for name, values in state.items():
        if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
            yield error("state", "short printable names", f"{name!r:.60}", "rename it")
        elif not isinstance(values, np.ndarray):
            yield error(
                "state", expected, f"{name}: a {type(values).__name__}", "convert it: np.array(…)"
            )
        elif values.dtype.str not in STATE_DTYPES:
            yield error(
                "state", expected, f"{name}: {values.dtype}", "encode strings as UTF-8 in uint8"
            )
    kinds = {name: getattr(values, "dtype", None) for name, values in state.items()}
    begun = {name: getattr(values, "dtype", None) for name, values in first.items()}
    if kinds != begun:
        changed = sorted(str(name) for name in kinds.keys() ^ begun.keys()) or sorted(
            name for name in kinds if kinds[name] != begun[name]
        )
        yield error(
            "state",
            "always the names and dtypes that initial() returns; arrays may be empty",
            f"{', '.join(changed)}: changed after {method} ({what})",
            "return all of them from initial()",
        )


def unchanged(method: str, what: str, before: Any, after: Any) -> Iterator[Finding]:
    """Check that a call did not change its arguments."""
    if not same(before, after):
        yield error("inputs", f"unchanged arguments ({what})", f"{method} changes them", COPY)


def described(trial: Trial, what: str) -> Iterator[Finding]:
    """Check figures, members and remembered genomes after each generation."""
    search, names = trial.search, None
    for generation, (state, last) in enumerate(trial.run(GENERATIONS), 1):
        scored = np.isfinite(last.scores).any()
        figures: object = search.figures(copied(state))
        if not isinstance(figures, Mapping) or names not in (None, list(figures)):
            yield error("figures", f"always the same names ({what})", f"{figures!r:.60}", "")
            return
        names = list(figures)
        for name in names:
            # A best score may be −inf if there is none yet.
            if np.isnan(figures[name]) or (scored and not np.isfinite(figures[name])):
                yield error("figures", f"finite numbers ({what})", f"{name}: {figures[name]}", "")
                return
        if (yield from reported(_members(trial, what, search.members(copied(state))))):
            return
        if (yield from reported(_remembered(trial, what, state, generation))):
            return


def _members(trial: Trial, what: str, members: object) -> Iterator[Finding]:
    keeps = trial.search.keeps
    if members is None or not keeps:
        if bool(keeps) != (members is not None):
            yield error(
                "members",
                f"a gaitsim.contracts.Members, as keeps = {keeps!r}" if keeps else "None",
                f"a {type(members).__name__}",
                "declare the result of members() in 'keeps': 'front' or 'archive'",
            )
        return
    if not isinstance(members, Members):
        yield error("members", "a gaitsim.contracts.Members", f"a {type(members).__name__}", "")
        return
    count = len(members.genomes)
    expected = f"valid genomes, and scores and values of each ({what})"
    cells = members.cells
    if not (_belong(members.genomes, trial.space) and members.scores.shape == (count,)):
        wrong = "invalid genomes, or scores of a wrong shape"
        yield error("members", expected, wrong, "shapes (members, genes) and (members,)")
    elif any(np.shape(values) != (count,) for values in members.values.values()):
        yield error("members", expected, "values of a wrong shape", "shape (members,) for each")
    elif (keeps == "front") != (cells is None) or (
        cells is not None and (cells.ndim != 2 or len(cells) != count or cells.dtype != np.int64)
    ):
        yield error(
            "members",
            f"cells (members, axes) of int64 for an archive, None for a front ({what})",
            "None" if cells is None else f"{cells.dtype} {cells.shape}",
            "see gaitsim.contracts.Members",
        )


def _belong(genomes: Genomes, space: GenomeSpace) -> bool:
    return not len(genomes) or space.contains(genomes)


def _remembered(trial: Trial, what: str, state: Any, generation: int) -> Iterator[Finding]:
    genomes: Any = trial.search.remembered(copied(state))
    if genomes is None or not len(genomes):
        return
    if not _belong(genomes, trial.space):
        yield error("remembered", f"valid genomes, or None ({what})", "invalid genomes", "")
        return
    results = trial.evaluated(genomes.copy(), generation)
    lent = copied(state)
    again = trial.search.rescored(lent, results, trial.context(generation, 3))
    yield from state_rule("rescored()", what, again, state)
    yield from unchanged("rescored()", what, dict(state), lent)

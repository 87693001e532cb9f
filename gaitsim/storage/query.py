"""Queries of runs: `spider state:finished score>5 -tag:bad`.

This module imports nothing heavy, as `gaitsim runs` needs it.
"""

import math
import operator
import re
import shlex
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gaitsim.errors import GaitsimError, nearest
from gaitsim.registry import KINDS
from gaitsim.storage.overview import LISTED, Overview

Value = str | float | bool | tuple[Any, ...]

TEXTS = ("name", "body", *KINDS[1:], "state", "tag", "note")
"""The keys of texts."""
NUMBERS = ("seed", "generation", "generations", "score", "evaluations", "stage", "time", "age")
"""The keys of numbers."""
KEYS = (*TEXTS, *NUMBERS)
TIMES = ("time", "age")
"""The keys of times, in seconds."""
_ALIASES = {"organism": "body", "best": "score"}

UNITS = {"s": 1, "min": 60, "h": 3600, "d": 86400, "w": 604_800}
"""The units of times, in seconds."""
_TIME = re.compile(rf"([^\sa-z]+) *({'|'.join(UNITS)})?")
_CONDITION = re.compile(r"([^:=<>!]+)(:|=|!=|>=|<=|>|<)(.*)", re.DOTALL)
_ORDERED = (">", "<", ">=", "<=")
_COMPARE: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    ":": operator.eq,
    ">": operator.gt,
    "<": operator.lt,
    ">=": operator.ge,
    "<=": operator.le,
}
_READ: Mapping[str, Callable[[Overview], Value | None]] = {
    "name": lambda run: run.name,
    "body": lambda run: run.plugins.get("organism"),
    "state": lambda run: run.state,
    "tag": lambda run: run.tags,
    "note": lambda run: run.note,
    "seed": lambda run: run.seed,
    "generation": lambda run: run.generation,
    "generations": lambda run: run.generations,
    "score": lambda run: run.best,
    "evaluations": lambda run: run.evaluations,
    "stage": lambda run: run.stage,
    "time": lambda run: run.seconds,
    "age": lambda run: max(0.0, time.time() - run.changed) if run.changed else None,
}


def value_of(run: Overview, key: str) -> Value | None:
    """Return a value of a run by the key of a query; None if the run does not have it.

    Args:
        run: overview of the run.
        key: one of `KEYS`, an option such as `mutation.rate`, or a term of the score.
    """
    key = _ALIASES.get(key, key)
    if read := _READ.get(key):
        return read(run)
    if key in KINDS:
        return run.plugins.get(key)
    value = run.options.get(key, run.terms.get(key))
    return tuple(value) if isinstance(value, list) else value


def check_keys(keys: Iterable[str], runs: Sequence[Overview]) -> None:
    """Check that keys are known, or that one of the runs has an option or term of that name.

    Raises:
        GaitsimError: a key is unknown; without runs, none is.
    """
    for key in (_ALIASES.get(key, key) for key in keys):
        if key in KEYS or not runs or any(key in run.options or key in run.terms for run in runs):
            continue
        known = {name for run in runs for name in (*run.options, *run.terms)}
        raise GaitsimError(
            f"unknown key {key!r:.100}",
            allowed=f"{', '.join(KEYS)}; an option of a run, such as evolution.population; or a "
            "term of the score",
            remedy=nearest(key, [*KEYS, *sorted(known)]),
        )


@dataclass(frozen=True)
class QueryTerm:
    """One word of a query.

    Attributes:
        key: key of the value that is compared; '' for a word to be found anywhere.
        operator: one of `:`, `=`, `!=`, `>`, `<`, `>=` and `<=`.
        text: text that the value is compared with, in lower case.
        number: the text as a number, in seconds for times; None if it is not a number.
        negated: whether the condition must not hold.
    """

    key: str
    operator: str
    text: str
    number: float | None = None
    negated: bool = False

    def matches(self, run: Overview) -> bool:
        """Return whether a run fulfils the condition."""
        return self._holds(run) is not self.negated

    def _holds(self, run: Overview) -> bool:
        if not self.key:
            fields = (run.name, *run.plugins.values(), run.state, run.note, *run.tags)
            return any(self.text in field.casefold() for field in fields)
        value = value_of(run, self.key)
        if value is None:
            return False
        if self.operator == "!=":
            return not self._equals(value, "=")
        if self.operator == ":" and not self.text:
            return value not in ("", ())
        return self._equals(value, self.operator)

    def _equals(self, value: Value, sign: str) -> bool:
        if isinstance(value, tuple):
            return any(self._equals(one, "=" if sign == ":" else sign) for one in value)
        if isinstance(value, bool):
            value = str(value).lower()
        if isinstance(value, str):
            folded = value.casefold()
            if sign == ":" and self.key != "state":
                return self.text in folded
            return sign in ":=" and folded == self.text
        if not isinstance(value, int | float) or self.number is None:
            return False
        return _COMPARE[sign](value, self.number)


@dataclass(frozen=True)
class Query:
    """A query of runs; all its conditions must hold.

    Attributes:
        conditions: the words of the query.
    """

    conditions: tuple[QueryTerm, ...] = ()

    def matches(self, run: Overview) -> bool:
        """Return whether a run fulfils all conditions."""
        return all(condition.matches(run) for condition in self.conditions)

    def select(self, runs: Sequence[Overview]) -> list[Overview]:
        """Return the runs that fulfil all conditions, in the same order.

        Raises:
            GaitsimError: a key is unknown, or a text is compared by size.
        """
        check_keys((one.key for one in self.conditions if one.key), runs)
        for one in self.conditions:
            if one.operator in _ORDERED:
                values = {type(value_of(run, one.key)) for run in runs} - {type(None)}
                if values == {str}:
                    raise _not_ordered(one.key)
        return [run for run in runs if self.matches(run)]


def parse_query(text: str) -> Query:
    """Return the query of a text.

    Words are separated by spaces, and all of them must hold. A word is found in the name, plugins,
    state, note and tags; `key:text` in the value of a key; `key=value`, `key!=value`,
    `key>number`, `key<number`, `key>=number` and `key<=number` compare; `-` negates. Quotes are as
    in a shell; the last one may be missing.

    Raises:
        GaitsimError: a text is compared by size, a number or a state is invalid.
    """
    conditions = []
    for given in _split(text):
        word, negated = given.removeprefix("-"), given.startswith("-")
        if found := _CONDITION.fullmatch(word):
            conditions.append(_condition(found[1].strip(), found[2], found[3].strip(), negated))
        elif word:
            conditions.append(QueryTerm("", ":", word.casefold(), negated=negated))
    return Query(tuple(conditions))


def _condition(key: str, sign: str, text: str, negated: bool) -> QueryTerm:
    key = _ALIASES.get(key.casefold(), key)
    key = key.casefold() if key.casefold() in KEYS else key
    ordered = sign in _ORDERED
    if key in TEXTS and ordered:
        raise _not_ordered(key)
    if key == "state" and text and text.casefold() not in LISTED:
        raise GaitsimError(
            f"unknown state {text!r:.100}",
            allowed=", ".join(LISTED),
            remedy=nearest(text.casefold(), LISTED),
        )
    number = _number(key, text)
    if number is None and (ordered or (key in NUMBERS and text)):
        raise GaitsimError(
            f"{key} is compared with {text!r:.100}, which is not a number",
            allowed="a number with a unit, such as 90s, 2min, 1.5h or 3d"
            if key in TIMES
            else "a number, such as 0.5",
        )
    return QueryTerm(key, sign, text.casefold(), number, negated)


def _number(key: str, text: str) -> float | None:
    """Return a number, in seconds for times; None for other texts."""
    factor = 1
    if key in TIMES and (found := _TIME.fullmatch(text)):
        text, factor = found[1], UNITS.get(found[2], 1)
    try:
        number = float(text) * factor
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def _not_ordered(key: str) -> GaitsimError:
    return GaitsimError(
        f"{key} is a text, which is neither larger nor smaller than another",
        allowed=f"{key}:TEXT, {key}=TEXT or {key}!=TEXT",
    )


def _split(text: str) -> list[str]:
    """Return the words of a text, whose last quote may be missing."""
    for end in ("", '"', "'"):
        try:
            return shlex.split(text + end)
        except ValueError:
            continue
    return text.split()


def sort_runs(runs: Iterable[Overview], key: str) -> list[Overview]:
    """Return runs sorted by the value of a key; `-key` sorts in descending order.

    Runs without the value come last.
    """
    descending, key = key.startswith("-"), key.removeprefix("-")
    with_value, without = [], []
    for run in runs:
        value = value_of(run, key)
        if value is None:
            without.append(run)
        else:
            # Options of the same name may have values of different types.
            text = isinstance(value, str | tuple)
            with_value.append((text, str(value).casefold() if text else value, run))
    with_value.sort(key=lambda item: item[:2], reverse=descending)
    return [run for *_, run in with_value] + without

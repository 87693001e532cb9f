"""Generations and members: the two ways in which individuals of a run are numbered."""

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.individual import Member, Which
from gaitsim.render.series import Series
from gaitsim.tui.screens.replay_loading import LoadedIndividual


def describe(which: Which) -> str:
    """Name an individual of a run."""
    if which is None:
        return "the champion"
    return f"generation {which}" if isinstance(which, int) else str(which)


def options_of(which: Which) -> list[object]:
    """Return the command-line options that select an individual of a run."""
    if which is None:
        return []
    return ["--member" if isinstance(which, Member) else "--generation", number_of(which)]


def number_of(which: int | Member) -> int:
    """Return the number of a generation or member."""
    return which if isinstance(which, int) else which.number


def with_number(which: Which, number: int) -> int | Member:
    """Return member `number` if `which` is a member, else generation `number`."""
    return Member(number) if isinstance(which, Member) else number


def last_of(shown: LoadedIndividual, which: Which) -> int:
    """Return the number of members if `which` is one, else the last generation."""
    if isinstance(which, Member):
        return len(shown.members.scores) if shown.members else 1
    return shown.last


def kind_of(which: Which) -> str:
    """Return the noun for an individual's number, such as 'member'."""
    return "member" if isinstance(which, Member) else "generation"


def parse_which(text: str, which: Which, shown: LoadedIndividual) -> int | Member:
    """Read the number of an existing generation or member, of the kind of `which`."""
    return with_number(which, parse_number(text, kind_of(which), last_of(shown, which)))


def parse_number(text: str, kind: str, last: int) -> int:
    """Read a number from 1 to `last` of a kind, such as 'member'."""
    digits = text.replace(",", "").strip()
    if digits.isdecimal() and len(digits) < 10 and 1 <= int(digits) <= last:
        return int(digits)
    raise GaitsimError(f"there is no {kind} {text}", allowed=f"1 to {last:,}")


def curve_of(shown: LoadedIndividual) -> tuple[str, Series, float]:
    """Return the label of the x axis, a curve, and the position of the individual on it.

    The curve is the best score of each generation. For a member of a front, it is the second
    objective against the first; for a member of an archive, the scores of all members.
    """
    member, members = shown.individual.member, shown.members
    if member is None or members is None:
        best = Series("best score", shown.history["generation"], shown.history["best"])
        return "generation", best, shown.generation
    if members.cells is None:  # a front, sorted by its first objective
        (across, x), (up, y), *_ = members.values.items()
    else:
        across, x = "member", np.arange(1.0, len(members.scores) + 1)
        up, y = "score", members.scores
    return across, Series(up, x, y), float(x[member.number - 1])

"""Parsers of option values shared by several commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.individual import Choice, Individual, Member, Near


def not_combinable(first: str, second: str, allowed: str = "one of the two") -> GaitsimError:
    """Return the error of two options that exclude each other."""
    return GaitsimError(
        f"{first} and {second} cannot be combined", where=f"{first}, {second}", allowed=allowed
    )


def parse_individual(generation: int | None, member: str | None) -> Choice:
    """Return the individual requested by `--generation` or `--member`; None for neither."""
    if member is None:
        return generation
    if generation is not None:
        raise not_combinable(
            "--generation", "--member", "one of the two; members belong to the last generation"
        )
    return _member(member)


def _member(text: str) -> Member | Near:
    from gaitsim.individual import Member, Near

    allowed = "a number from 1, or NAME=VALUE,…, such as 'duty factor L2=0'"
    if text.isascii() and text.isdecimal() and len(text) < 10 and int(text):
        return Member(int(text))
    if "=" not in text:
        raise GaitsimError(f"invalid member: {text!r}", where="--member", allowed=allowed)
    values = parse_pairs(text, "--member", allowed)
    try:
        found = {name: float(value) for name, value in values.items()}
        if not all(map(math.isfinite, found.values())):
            raise ValueError
    except ValueError:
        raise GaitsimError(
            f"a value in {text!r} is not a number", where="--member", allowed=allowed
        ) from None
    return Near(found)


def parse_individuals(
    one: int | None, several: str | None, member: str | None
) -> tuple[Choice, ...]:
    """Return the individuals of `--generation`, `--generations 1,50` or `--member`, in order."""
    choice = parse_individual(one, member)
    if several is None:
        return () if choice is None else (choice,)
    if choice is not None:
        option = "--generation" if member is None else "--member"
        raise not_combinable(option, "--generations")
    return parse_generations(several)


BodyChange = Callable[["Individual"], "Individual"]
"""A function that returns an individual with a changed body."""


def parse_body_changes(
    damage: Sequence[str] | None, world: Sequence[str] | None, engine: str | None = None
) -> BodyChange:
    """Return the change of a body requested by `--damage`, `--world` and `--engine`.

    The returned function raises a GaitsimError if the body does not support the change.
    """
    if not (damage or world or engine):
        return lambda individual: individual
    from gaitsim.evaluation.worlds import parse_world
    from gaitsim.gait.changed import in_engine, with_damage, with_world

    conditions = parse_world(world or (), "--world")

    def changed(individual: Individual) -> Individual:
        if damage:
            individual = with_damage(individual, damage)
        if conditions:
            individual = with_world(individual, conditions)
        return in_engine(individual, engine) if engine else individual

    return changed


def parse_generations(several: str | None) -> tuple[int, ...]:
    """Return the generations of `--generations 1,50`, in order; () for None."""
    if several is None:
        return ()
    parts = [part.strip() for part in several.split(",")]
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"invalid list of generations: {several!r}",
            where="--generations",
            allowed="numbers separated by commas, such as 1,50,300",
        )
    return tuple(dict.fromkeys(int(part) for part in parts))


def choose_format(
    format: str | None, out: Path | None, known: Sequence[str], default: str, what: str
) -> str:
    """Return the format given by `--format`, or else by the extension of `--out`.

    Args:
        format: value of `--format`.
        out: value of `--out`.
        known: the formats, each equal to the extension of its files.
        default: format if neither option is given.
        what: content of the files, in the plural.
    """
    if out is None:
        return format or default
    ending = out.suffix[1:].lower()
    if format is None and ending not in known:
        raise GaitsimError(
            f"unknown extension for {what}: {out}",
            where="--out",
            allowed=", ".join(f".{one}" for one in known),
            remedy="change the extension, or add --format",
        )
    if format is not None and ending in known and ending != format:
        raise GaitsimError(
            f"{out} ends with .{ending}, but --format is {format}",
            remedy="omit one of the two",
        )
    return format or ending


def parse_window(text: str | None) -> tuple[float, float] | None:
    """Return the start and end in seconds of a `--window` such as '2:5'."""
    if text is None:
        return None
    try:
        first, last = (float(part) for part in text.split(":"))
        if not 0 <= first < last < math.inf:
            raise ValueError
    except ValueError:
        raise GaitsimError(
            f"invalid time window: {text!r}",
            where="--window",
            allowed="START:END in seconds, such as 2:5",
        ) from None
    return first, last


def parse_size(text: str | None) -> tuple[int, int] | None:
    """Return the width and height in pixels of a `--size` such as '1280x720'."""
    if text is None:
        return None
    parts = text.lower().replace("×", "x").split("x")
    if len(parts) != 2 or not all(part.isdecimal() and len(part) < 7 for part in parts):
        raise GaitsimError(
            f"invalid size: {text!r}",
            where="--size",
            allowed="WIDTHxHEIGHT in pixels, such as 1280x720",
        )
    return int(parts[0]), int(parts[1])


def parse_pairs(text: str, option: str, allowed: str) -> dict[str, str]:
    """Return the texts of a list NAME=TEXT,… by name; '' for a name without a text."""
    found: dict[str, str] = {}
    for part in text.split(","):
        name, _, value = (one.strip() for one in part.partition("="))
        if not name or name in found:
            what = f"{name!r} is given twice" if name else f"a name is missing in {text!r}"
            raise GaitsimError(what, where=option, allowed=allowed)
        found[name] = value
    return found


def parse_axes(text: str | None) -> dict[str, tuple[float, float] | None] | None:
    """Return the ends of each axis of `--axes NAME=LOW:HIGH,…`; None for a name without ends."""
    if text is None:
        return None
    allowed = "NAME=LOW:HIGH,… with LOW below HIGH, such as forward=0:2"
    found: dict[str, tuple[float, float] | None] = {}
    for name, ends in parse_pairs(text, "--axes", allowed).items():
        try:
            low, high = (float(end) for end in ends.split(":")) if ends else (0.0, 1.0)
            if not -math.inf < low < high < math.inf:
                raise ValueError
        except ValueError:
            raise GaitsimError(
                f"invalid range for the axis {name!r}: {ends!r}", where="--axes", allowed=allowed
            ) from None
        found[name] = (low, high) if ends else None
    return found


def parse_cells(text: str | None) -> int | tuple[int, ...] | None:
    """Return the number of cells of `--cells 5000`, or the counts per axis of `--cells 40x30`."""
    if text is None:
        return None
    parts = text.lower().replace("×", "x").split("x")
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"invalid number of cells: {text!r}",
            where="--cells",
            allowed="a number of Voronoi cells, such as 5000, or one count per axis of a grid, "
            "such as 40x30",
        )
    return int(text) if len(parts) == 1 else tuple(map(int, parts))

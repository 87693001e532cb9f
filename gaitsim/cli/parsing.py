"""Values of options that several commands read alike."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import parse_world
from gaitsim.individual import Asked, Individual, Member, Near


def which(generation: int | None, member: str | None) -> Asked:
    """Return the individual of `--generation` or `--member`; None for neither.

    Raises:
        GaitsimError: both are given, or the member is neither a number nor values by name.
    """
    if member is None:
        return generation
    if generation is not None:
        raise GaitsimError(
            "a generation's best and a member are requested",
            where="--generation, --member",
            allowed="one of the two: members are of the last generation",
        )
    return _member(member)


def _member(text: str) -> Member | Near:
    allowed = "a number from 1, or NAME=VALUE with commas between, as 'duty factor L2=0'"
    if text.isascii() and text.isdecimal() and len(text) < 10 and int(text):
        return Member(int(text))
    if "=" not in text:
        raise GaitsimError(f"{text!r} is not a member", where="--member", allowed=allowed)
    values = by_name(text, "--member", allowed)
    try:
        found = {name: float(value) for name, value in values.items()}
        if not all(map(math.isfinite, found.values())):
            raise ValueError
    except ValueError:
        raise GaitsimError(
            f"{text!r} has a value that is not a number", where="--member", allowed=allowed
        ) from None
    return Near(found)


def asked_individuals(
    one: int | None, several: str | None, member: str | None
) -> tuple[Asked, ...]:
    """Return the individuals of `--generation`, `--generations 1,50` or `--member`, in order.

    Raises:
        GaitsimError: more than one of them are given, or they are not numbers.
    """
    asked = which(one, member)
    if several is None:
        return () if asked is None else (asked,)
    if asked is not None:
        option = "--generation" if member is None else "--member"
        raise GaitsimError(
            f"one {option[2:]} and several generations are requested",
            where=f"{option}, --generations",
            allowed="one of the two",
        )
    return asked_generations(several)


Changing = Callable[[Individual], Individual]
"""Moves an individual on a changed body."""


def asked_body(
    damage: Sequence[str] | None, world: Sequence[str] | None, engine: str | None = None
) -> Changing:
    """Return what changes a body as `--damage`, `--world` and `--engine` ask.

    It raises a GaitsimError if the body cannot be damaged, in this world or in this engine.

    Raises:
        GaitsimError: a condition has no value.
    """
    if not (damage or world or engine):
        return lambda individual: individual
    from gaitsim.gait.changed import in_engine, with_world
    from gaitsim.gait.damaged import with_damage

    conditions = parse_world(world or (), "--world")

    def changed(individual: Individual) -> Individual:
        if damage:
            individual = with_damage(individual, damage)
        if conditions:
            individual = with_world(individual, conditions)
        return in_engine(individual, engine) if engine else individual

    return changed


def asked_generations(several: str | None) -> tuple[int, ...]:
    """Return the generations of `--generations 1,50`, in order; () without.

    Raises:
        GaitsimError: they are not numbers.
    """
    if several is None:
        return ()
    parts = [part.strip() for part in several.split(",")]
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"{several!r} is not a list of generations",
            where="--generations",
            allowed="numbers with commas between them, such as 1,50,300",
        )
    return tuple(dict.fromkeys(int(part) for part in parts))


def file_format(
    format: str | None, out: Path | None, known: Sequence[str], default: str, what: str
) -> str:
    """Return the format of `--format`, or else the one that the name of `--out` ends with.

    Args:
        format: as `--format` gives it.
        out: as `--out` gives it.
        known: the formats, each the ending of its files.
        default: the format where neither is given.
        what: what the files hold, in the plural.

    Raises:
        GaitsimError: the two contradict each other, or the name has another ending.
    """
    if out is None:
        return format or default
    ending = out.suffix[1:].lower()
    if format is None and ending not in known:
        raise GaitsimError(
            f"{out} does not end with a format of {what}",
            where="--out",
            allowed=", ".join(f".{one}" for one in known),
            remedy="give it such an ending, or say which with --format",
        )
    if format is not None and ending in known and ending != format:
        raise GaitsimError(
            f"{out} ends with .{ending}, but --format says {format}",
            remedy="leave one of the two out",
        )
    return format or ending


def seconds(text: str | None) -> tuple[float, float] | None:
    """Return the first and the last second of a `--window` such as '2:5'.

    Raises:
        GaitsimError: it is not a window.
    """
    if text is None:
        return None
    try:
        first, last = (float(part) for part in text.split(":"))
        if not 0 <= first < last < math.inf:
            raise ValueError
    except ValueError:
        raise GaitsimError(
            f"{text!r} is not a part of a motion",
            where="--window",
            allowed="two seconds with a colon between them, the later one last, such as 2:5",
        ) from None
    return first, last


def pixels(text: str | None) -> tuple[int, int] | None:
    """Return the width and the height of a `--size` such as '1280x720'.

    Raises:
        GaitsimError: it is not a size.
    """
    if text is None:
        return None
    parts = text.lower().replace("×", "x").split("x")
    if len(parts) != 2 or not all(part.isdecimal() and len(part) < 7 for part in parts):
        raise GaitsimError(
            f"{text!r} is not the size of a picture",
            where="--size",
            allowed="width x height in pixels, such as 1280x720",
        )
    return int(parts[0]), int(parts[1])


def by_name(text: str, option: str, allowed: str) -> dict[str, str]:
    """Return the texts of a list NAME=TEXT,… by name; '' for a name alone.

    Raises:
        GaitsimError: a name is missing, or is there twice.
    """
    found: dict[str, str] = {}
    for part in text.split(","):
        name, _, value = (one.strip() for one in part.partition("="))
        if not name or name in found:
            what = f"{name!r} is there twice" if name else f"{text!r} lacks a name"
            raise GaitsimError(what, where=option, allowed=allowed)
        found[name] = value
    return found


def axis_ends(text: str | None) -> dict[str, tuple[float, float] | None] | None:
    """Return the ends of each axis of `--axes NAME=LOW:HIGH,…`; None for a name alone.

    Raises:
        GaitsimError: they are not two numbers, the lower one first.
    """
    if text is None:
        return None
    allowed = "NAME=LOW:HIGH, the lower number first, with commas between axes: forward=0:2"
    found: dict[str, tuple[float, float] | None] = {}
    for name, ends in by_name(text, "--axes", allowed).items():
        try:
            low, high = (float(end) for end in ends.split(":")) if ends else (0.0, 1.0)
            if not -math.inf < low < high < math.inf:
                raise ValueError
        except ValueError:
            raise GaitsimError(
                f"{ends!r} are not the ends of the axis {name!r}", where="--axes", allowed=allowed
            ) from None
        found[name] = (low, high) if ends else None
    return found


def counts(text: str | None) -> int | tuple[int, ...] | None:
    """Return the number of cells of `--cells 5000`, or the counts of `--cells 40x30`.

    Raises:
        GaitsimError: it is neither.
    """
    if text is None:
        return None
    parts = text.lower().replace("×", "x").split("x")
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"{text!r} is not a number of cells",
            where="--cells",
            allowed="a number of Voronoi cells, as 5000, or a count for each axis, as 40x30",
        )
    return int(text) if len(parts) == 1 else tuple(map(int, parts))

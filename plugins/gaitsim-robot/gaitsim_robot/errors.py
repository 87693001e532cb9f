"""The error for robots that cannot be used, and its wording."""

from collections.abc import Sequence

from gaitsim.plugin import GaitsimError


class RobotError(GaitsimError):
    """A robot's file cannot be read, or the robot cannot be used."""


def check_count(count: int, most: int, noun: str, where: str = "", remedy: str = "") -> None:
    """Raise an error if a robot has more than `most` of something."""
    if count > most:
        raise RobotError(
            f"the robot has {count:,} {noun}",
            where=where,
            allowed=f"at most {most:,}",
            remedy=remedy,
        )


def shorten(texts: Sequence[str], most: int = 4) -> str:
    """Return the first texts and the number of the others."""
    more = f" and {len(texts) - most} more" if len(texts) > most else ""
    return ", ".join(texts[:most]) + more


def format_names(names: Sequence[str], most: int = 4) -> str:
    """Return the first names in quotes, and the number of the others."""
    return shorten([repr(f"{name[:59]}…" if len(name) > 60 else name) for name in names], most)

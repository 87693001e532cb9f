"""Generations as the command line takes them: one by `--generation`, or `--generations 1,50`."""

from gaitsim.errors import GaitsimError


def asked_generations(one: int | None, several: str | None) -> tuple[int, ...]:
    """The generations that are asked for, in that order; () where none is.

    Raises:
        GaitsimError: both ways are used at once, or they are no numbers.
    """
    if several is None:
        return () if one is None else (one,)
    if one is not None:
        raise GaitsimError(
            "one generation and several are asked for",
            where="--generation, --generations",
            allowed="one of the two",
        )
    parts = [part.strip() for part in several.split(",")]
    if not all(part.isascii() and part.isdecimal() and len(part) < 10 for part in parts):
        raise GaitsimError(
            f"{several!r} are no generations",
            where="--generations",
            allowed="numbers with commas between them, such as 1,50,300",
        )
    return tuple(dict.fromkeys(int(part) for part in parts))

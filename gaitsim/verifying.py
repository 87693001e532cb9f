"""Verify runs, and what packages store, such as studies: everything is found by its files."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from gaitsim.errors import GaitsimError
from gaitsim.registry import VERIFIERS, entries, find
from gaitsim.registry.loading import load_object
from gaitsim.storage.files.folder import holds_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import Verdict, verify_run


class Verifier(NamedTuple):
    """How a package verifies what it stores; the object of an entry point `gaitsim.verifier`.

    Attributes:
        holds: function that returns whether a path holds it.
        verify: function with a path and the keyword arguments of `verify_files`.
    """

    holds: Callable[[Path], bool]
    verify: Callable[..., Verdict]


def find_verifier(subject: str | Path) -> Verifier | None:
    """Return the verifier of a folder or file; None for a run and for all others."""
    path = Path(subject)
    if holds_run(path):
        return None
    verifiers = (load_object(find(VERIFIERS, name)) for name in entries(VERIFIERS))
    return next((one for one in verifiers if one.holds(path)), None)


def verify_files(
    subject: str,
    atlas: str | None = None,
    *,
    everything: bool | None = None,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda steps: None,
) -> Verdict:
    """Compute a run, or what a package stores, again, and compare its files.

    Args:
        subject: name or folder of a run; or folder or file of a package, such as a study.
        atlas: folder or name of the atlas of an adaptation; None for the run that contains it.
        everything: whether to repeat everything; None does so for a quick run, and otherwise
            repeats a random part.
        workers: number of parallel workers.
        begin: callback with the number of steps.
        advance: callback with the number of steps done since the last call.

    Raises:
        GaitsimError: the subject is none of these, or cannot be verified.
    """
    found = find_verifier(subject)
    if found is not None:
        return found.verify(
            Path(subject),
            atlas=atlas,
            everything=bool(everything),
            workers=workers,
            begin=begin,
            advance=advance,
        )
    check_no_atlas(atlas)
    return verify_run(
        RunSnapshot.find(subject),
        everything=everything,
        workers=workers,
        begin=begin,
        advance=advance,
    )


def check_no_atlas(atlas: str | None) -> None:
    """Check that no atlas is given."""
    if atlas is not None:
        raise GaitsimError("only adaptations have an atlas", where="--atlas", remedy="omit it")

"""Verify runs, and files of packages such as studies and adaptations."""

from collections.abc import Callable
from pathlib import Path

from gaitsim.errors import GaitsimError
from gaitsim.registry import VERIFIERS, entries, find
from gaitsim.registry.loading import load_object
from gaitsim.storage.files.folder import holds_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import Verdict, Verifier, verify_run


def verifier_of(subject: str | Path) -> Verifier | None:
    """Return the verifier of a folder or file of a package; None for a run and for all others."""
    path = Path(subject)
    if holds_run(path):
        return None
    found: list[Verifier] = [load_object(find(VERIFIERS, name)) for name in entries(VERIFIERS)]
    return next((one for one in found if one.recognises(path)), None)


def verify_files(
    subject: str,
    atlas: str | None = None,
    *,
    everything: bool | None = None,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda steps: None,
) -> Verdict:
    """Compute a run, or files of a package such as a study, again, and compare its files.

    Args:
        subject: name or folder of a run, or a folder or file that a package verifies.
        atlas: folder or name of the atlas of an adaptation; None for the run that contains it.
        everything: whether to repeat everything; None does so for a quick run, and otherwise
            repeats a random part.
        workers: number of parallel workers.
        begin: callback with the number of steps.
        advance: callback with the number of steps done since the last call.

    Raises:
        GaitsimError: the subject is none of these, or cannot be verified.
    """
    verifier = verifier_of(subject)
    if atlas is not None and (verifier is None or not verifier.of_atlas):
        raise GaitsimError("only adaptations have an atlas", where="--atlas", remedy="omit it")
    if verifier is None:
        run = RunSnapshot.find(subject)
        return verify_run(run, everything=everything, workers=workers, begin=begin, advance=advance)
    more = {"atlas": atlas} if verifier.of_atlas else {}
    return verifier.verify(
        Path(subject),
        everything=bool(everything),
        workers=workers,
        begin=begin,
        advance=advance,
        **more,
    )

"""Verify runs, studies, comparisons and adaptations: everything is found by its files."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.storage.files.folder import ADAPTATIONS, holds_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import Verdict, verify_run


def files_kind(subject: str | Path) -> str:
    """Return the kind of a folder or file; '' for a run and for all others."""
    from gaitsim.adaptation.report import FILE
    from gaitsim.study.file import STUDY
    from gaitsim.study.results import FIRST

    path = Path(subject)
    if holds_run(path):
        return ""
    files = {STUDY: "study", FIRST: "comparison", FILE: "adaptation report"}
    # Unlike pathlib, os.path accepts names that are invalid for files.
    for name, kind in files.items():
        if os.path.lexists(path / name):
            return kind
    return "adaptation" if path.suffix == ".json" and os.path.isfile(path) else ""  # noqa: PTH113


def verify_files(
    subject: str,
    atlas: str | None = None,
    *,
    everything: bool | None = None,
    workers: int | None = None,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda steps: None,
) -> Verdict:
    """Compute a run, a study, a comparison or an adaptation again, and compare its files.

    Args:
        subject: name or folder of a run; folder of a study, a comparison or an adaptation report;
            or file of an adaptation.
        atlas: folder or name of the atlas of an adaptation; None for the run that contains it.
        everything: whether to repeat everything; None does so for a quick run, and otherwise
            repeats a random part.
        workers: number of parallel workers.
        begin: callback with the number of steps.
        advance: callback with the number of steps done since the last call.

    Raises:
        GaitsimError: the subject is none of these, or cannot be verified.
    """
    from gaitsim.adaptation.verification import verify_adaptation, verify_report
    from gaitsim.study.verification import verify_comparison, verify_study

    path = Path(subject)
    kind = files_kind(subject)
    steps: dict[str, Any] = {"workers": workers, "begin": begin, "advance": advance}
    if atlas is not None and not kind.startswith("adaptation"):
        raise GaitsimError("only adaptations have an atlas", where="--atlas", remedy="omit it")
    match kind:
        case "study":
            return verify_study(path, everything=bool(everything), **steps)
        case "comparison":
            return verify_comparison(path, everything=bool(everything), **steps)
        case "adaptation":
            return verify_adaptation(path, RunSnapshot.find(atlas or _atlas_around(path)), **steps)
        case "adaptation report":
            run = RunSnapshot.find(atlas or _atlas_around(path))
            return verify_report(path, run, everything=bool(everything), **steps)
    return verify_run(RunSnapshot.find(subject), everything=everything, **steps)


def _atlas_around(path: Path) -> str:
    """Return the folder of the run whose adaptation is in a file."""
    folder = path.absolute().parent
    if folder.name != ADAPTATIONS or not holds_run(folder.parent):
        raise GaitsimError(
            f"{path} does not say where its atlas is",
            where="--atlas",
            remedy="name the run of the atlas, such as --atlas spider-atlas",
        )
    return os.path.relpath(folder.parent)

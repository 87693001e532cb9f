"""Verify studies, comparisons and adaptations, found by their files."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.storage.accounts import FilesVerdict
from gaitsim.storage.files.folder import ADAPTATIONS, holds_run
from gaitsim.storage.snapshot import RunSnapshot


def files_kind(path: Path) -> str:
    """Return the kind of a folder or file; '' for a run and for all others."""
    from gaitsim_adaptation.report import FILE
    from gaitsim_studies.file import STUDY
    from gaitsim_studies.results import FIRST

    if holds_run(path):
        return ""
    files = {STUDY: "study", FIRST: "comparison", FILE: "adaptation report"}
    # Unlike pathlib, os.path accepts names that are invalid for files.
    for name, kind in files.items():
        if os.path.lexists(path / name):
            return kind
    return "adaptation" if path.suffix == ".json" and os.path.isfile(path) else ""  # noqa: PTH113


def verify_files(
    path: Path,
    atlas: str | None = None,
    *,
    everything: bool = False,
    workers: int | None = None,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[int], None] = lambda steps: None,
) -> FilesVerdict:
    """Verify the folder of a study, a comparison or an adaptation report, or an adaptation's file.

    Args:
        path: the folder or file.
        atlas: folder or name of the atlas of an adaptation; None for the run that contains it.
        everything: whether to repeat everything, rather than a part of it.
        workers: number of parallel workers.
        begin: callback with the number of steps.
        advance: callback with the number of steps done since the last call.

    Raises:
        GaitsimError: the path is none of these, or cannot be verified.
    """
    from gaitsim_adaptation.verification import verify_adaptation, verify_report
    from gaitsim_studies.comparison_verification import verify_comparison
    from gaitsim_studies.verification import verify_study

    kind = files_kind(path)
    steps: dict[str, Any] = {"workers": workers, "begin": begin, "advance": advance}
    if kind in ("study", "comparison"):
        if atlas is not None:
            raise GaitsimError(f"a {kind} has no atlas", where="--atlas", remedy="omit it")
        verify = verify_study if kind == "study" else verify_comparison
        return verify(path, everything=everything, **steps)
    if not kind:
        raise GaitsimError(f"{path} is not a study, a comparison or an adaptation")
    run = RunSnapshot.find(atlas or _atlas_around(path))
    if kind == "adaptation":
        return verify_adaptation(path, run, **steps)
    return verify_report(path, run, everything=everything, **steps)


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

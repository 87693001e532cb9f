"""Rename a run's folder within its parent folder."""

import os
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.runs.files.atomic import sync_folder, writing
from gaitsim.runs.files.folder import resolve_run
from gaitsim.runs.files.lock import RunLock


def rename_run(path: Path, name: str) -> Path:
    """Rename a run; return the new path of its folder."""
    here = resolve_run(path, "rename")
    check_name(here, name)
    target = here.with_name(name)
    lock = RunLock(here)
    try:
        with writing(target):
            here.rename(target)
            sync_folder(target.parent)
    finally:
        lock.release()
    return path.with_name(name) if path.name else target


def check_name(run: Path, name: str) -> None:
    """Check a new name for the folder of a run."""
    if not name or name.startswith((".", "-")) or not name.isprintable() or {*name} & {*"/\\"}:
        raise RunError(
            f"invalid name for a run: {name!r}",
            allowed="a name without / and \\ that does not begin with a dot or a hyphen",
        )
    if os.path.lexists(run.with_name(name)):
        raise RunError(f"{name} already exists in {run.parent}", allowed="an unused name")

"""Annotate, rename and delete runs."""

import os
import shutil
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import is_folder, read_regular
from gaitsim.storage.background import forget_failure
from gaitsim.storage.files.atomic import (
    draft_name,
    locked,
    remove,
    sweep,
    sync_folder,
    write_bytes,
    writing,
)
from gaitsim.storage.files.folder import NOTE, find_run, resolve_run
from gaitsim.storage.lock import RunLock

LARGEST = 50_000  # bytes


def read_note(run: Path) -> str:
    """Return the note of a run; '' without one."""
    path = run / NOTE
    try:
        return read_regular(path, LARGEST).decode().strip()
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not a text file in UTF-8"
        raise RunError(
            f"cannot read {path}: {reason}",
            remedy="delete the file, or write the note again with 'gaitsim note'",
        ) from None


def write_note(run: Path, text: str) -> None:
    """Replace the note of a run, which may be evolving; '' removes the note."""
    path = find_run(str(run)) / NOTE
    text = "\n".join(text.splitlines()).strip()
    try:
        data = f"{text}\n".encode()
    except UnicodeEncodeError:
        raise RunError("the note has invalid characters", allowed="UTF-8") from None
    if len(data) > LARGEST:
        raise RunError(
            f"the note is too long: {len(data):,} bytes", allowed=f"up to {LARGEST:,} bytes"
        )
    if text:
        write_bytes(path, data, follow=False)
        return
    with writing(path):
        path.unlink(missing_ok=True)
        sync_folder(path.parent)


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


def delete_run(path: Path) -> None:
    """Delete a run with all its exports; links in it are removed, but not their targets."""
    path = resolve_run(path, "delete")
    sweep(path.parent)
    lock = RunLock(path)
    with writing(path), locked(path):
        try:
            draft = path.rename(draft_name(path.parent))
        finally:
            lock.release()
        forget_failure(path)
        try:
            remove(draft)
            if is_folder(draft):  # repeat the deletion to get the reason for its failure
                shutil.rmtree(draft)
        except (OSError, RecursionError) as error:
            nested = "its folders are nested too deeply"
            reason = error.strerror if isinstance(error, OSError) else nested
            raise RunError(
                f"the run {path.name} was removed, but some of its files could not be deleted: "
                f"{reason}",
                where=str(draft),
                remedy="delete that folder by hand",
            ) from None

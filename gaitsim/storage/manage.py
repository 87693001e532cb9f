"""Annotate, rename and delete runs.

A deleted run moves to the trash, `.trash/TIME/NAME` in the folder of the run, where TIME is that of
the deletion in UTC.
"""

import os
import shutil
import time
import unicodedata
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
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
from gaitsim.storage.files.folder import (
    NOTE,
    TAGS,
    create_subfolder,
    find_run,
    free_name,
    list_runs,
    resolve_run,
)
from gaitsim.storage.lock import RunLock

LARGEST = 50_000  # bytes
LONGEST_TAG, MOST_TAGS = 40, 100
TRASH = ".trash"
KEPT = timedelta(days=30).total_seconds()
"""Time for which a run stays in the trash, seconds."""
_TIME = "%Y-%m-%dT%H-%M-%S.%f"


def read_note(run: Path) -> str:
    """Return the note of a run; '' without one."""
    return _read(run / NOTE, "note")


def write_note(run: Path, text: str) -> None:
    """Replace the note of a run, which may be evolving; '' removes the note."""
    text = "\n".join(text.splitlines()).strip()
    try:
        data = f"{text}\n".encode()
    except UnicodeEncodeError:
        raise RunError("the note has invalid characters", allowed="UTF-8") from None
    if len(data) > LARGEST:
        raise RunError(
            f"the note is too long: {len(data):,} bytes", allowed=f"up to {LARGEST:,} bytes"
        )
    _write(find_run(str(run)) / NOTE, data if text else b"")


def read_tags(run: Path) -> tuple[str, ...]:
    """Return the tags of a run, sorted; lines of its file that are not tags are ignored."""
    tags = set()
    for line in _read(run / TAGS, "tag").splitlines():
        with suppress(RunError):
            tags.add(check_tag(line.strip()))
    return tuple(sorted(tags)[:MOST_TAGS])


def write_tags(run: Path, tags: Iterable[str]) -> tuple[str, ...]:
    """Replace the tags of a run, which may be evolving; return them, sorted."""
    found = sorted({check_tag(tag) for tag in tags})
    if len(found) > MOST_TAGS:
        raise RunError(f"too many tags: {len(found)}", allowed=f"up to {MOST_TAGS} tags per run")
    _write(find_run(str(run)) / TAGS, "".join(f"{tag}\n" for tag in found).encode())
    return tuple(found)


def check_tag(tag: str) -> str:
    """Return a tag with its letters in composed form (NFC), after checking it."""
    tag = unicodedata.normalize("NFC", tag)
    wrong = any(char.isspace() or not char.isprintable() or char in ",\"'" for char in tag)
    if not tag or wrong or tag[0] in "-+" or len(tag) > LONGEST_TAG:
        raise RunError(
            f"invalid tag: {tag!r:.100}",
            allowed=f"1 to {LONGEST_TAG} letters, digits or signs without spaces, commas and "
            "quotes, that do not begin with - or +",
        )
    return tag


def _read(path: Path, command: str) -> str:
    try:
        return read_regular(path, LARGEST).decode().strip()
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not a text file in UTF-8"
        raise RunError(
            f"cannot read {path}: {reason}",
            remedy=f"delete the file, or write it again with 'gaitsim {command}'",
        ) from None


def _write(path: Path, data: bytes) -> None:
    """Replace a file of a run; without data, remove it."""
    if data:
        write_bytes(path, data, follow=False)
        return
    with writing(path):
        path.unlink(missing_ok=True)
        sync_folder(path.parent)


def rename_run(path: Path, name: str) -> Path:
    """Rename a run; return the new path of its folder."""
    here = resolve_run(path, "rename")
    check_name(here, name)
    _move(here, here.with_name(name))
    return path.with_name(name) if path.name else here.with_name(name)


def _move(run: Path, target: Path) -> None:
    """Rename the folder of a run that no process writes."""
    lock = RunLock(run)
    try:
        with writing(target):
            run.rename(target)
            sync_folder(target.parent)
    finally:
        lock.release()


def check_name(run: Path, name: str) -> None:
    """Check a new name for the folder of a run."""
    if not name or name.startswith((".", "-")) or not name.isprintable() or {*name} & {*"/\\"}:
        raise RunError(
            f"invalid name for a run: {name!r}",
            allowed="a name without / and \\ that does not begin with a dot or a hyphen",
        )
    _check_unused(run.with_name(name))


def _check_unused(path: Path) -> None:
    if os.path.lexists(path):
        raise RunError(
            f"{path.name} already exists in {path.parent}",
            allowed=f"an unused name, such as {free_name(path).name}",
        )


def delete_run(path: Path) -> None:
    """Delete a run with all its exports; links in it are removed, but not their targets."""
    path = resolve_run(path, "delete")
    sweep(path.parent)
    lock = RunLock(path)
    try:
        with _deleting(path, path.name) as draft:
            path.rename(draft)
            lock.release()
            forget_failure(path)
    finally:
        lock.release()


@contextmanager
def _deleting(path: Path, name: str) -> Iterator[Path]:
    """Yield a path in the same folder, and delete the folder that has been renamed to it.

    A program that is killed leaves a draft, which the next sweep removes.
    """
    with writing(path), locked(path):
        draft = draft_name(path.parent)
        yield draft
        try:
            remove(draft)
            if is_folder(draft):  # repeat the deletion to get the reason for its failure
                shutil.rmtree(draft)
        except (OSError, RecursionError) as error:
            nested = "its folders are nested too deeply"
            reason = error.strerror if isinstance(error, OSError) else nested
            raise RunError(
                f"the run {name} was removed, but some of its files could not be deleted: {reason}",
                where=str(draft),
                remedy="delete that folder by hand",
            ) from None


@dataclass(frozen=True)
class TrashedRun:
    """A run in the trash.

    Attributes:
        path: folder of the run in the trash.
        deleted: time of its deletion, seconds since 1970.
    """

    path: Path
    deleted: float

    @property
    def name(self) -> str:
        """The name of the run."""
        return self.path.name

    @property
    def root(self) -> Path:
        """The folder from which the run was deleted."""
        return self.path.parents[2]


def trash_run(path: Path) -> TrashedRun:
    """Move a run to the trash, and delete the runs that have been there for more than 30 days."""
    here = resolve_run(path, "delete")
    try:
        trash = create_subfolder(here.parent, TRASH)
        with writing(trash):
            while True:
                deleted = time.time()
                entry = trash / datetime.fromtimestamp(deleted, UTC).strftime(_TIME)
                with suppress(FileExistsError):
                    entry.mkdir()
                    break
        try:
            _move(here, entry / here.name)
        except BaseException:
            with suppress(OSError):
                entry.rmdir()
            raise
    except RunError as error:
        if isinstance(error.__cause__, OSError):
            error.remedy = f"{error.remedy}; or delete the run permanently"
        raise
    with suppress(RunError):  # the run itself is in the trash
        empty_trash(here.parent, KEPT)
    return TrashedRun(entry / here.name, deleted)


def list_trash(root: Path) -> list[TrashedRun]:
    """Return the runs that were deleted from a folder, latest first."""
    found = [
        TrashedRun(run, deleted)
        for entry, deleted in _trash_entries(root)
        for run in list_runs(entry)
    ]
    return sorted(found, key=lambda run: run.deleted, reverse=True)


def restore_run(trashed: TrashedRun, name: str = "") -> Path:
    """Move a run from the trash back to its folder; return its path there.

    Args:
        trashed: run in the trash.
        name: new name of the run; '' for its own.

    Raises:
        RunError: the name is taken or invalid, or the run is no longer in the trash.
    """
    here = resolve_run(trashed.path, "restore")
    target = trashed.root / trashed.name
    if name:
        check_name(target, name)
        target = target.with_name(name)
    _check_unused(target)
    _move(here, target.resolve())
    with suppress(OSError):
        here.parent.rmdir()
    return target


def empty_trash(root: Path, older_than: float = 0.0) -> list[TrashedRun]:
    """Delete the runs permanently that have been in the trash for long; return them.

    Args:
        root: folder from which the runs were deleted.
        older_than: shortest time in the trash, seconds; 0 deletes all.

    Raises:
        RunError: files could not be deleted; the other runs have been deleted.
    """
    latest = time.time() - older_than
    problem, emptied = None, []
    sweep(root / TRASH)
    for entry, deleted in _trash_entries(root):
        if older_than and deleted > latest:
            continue
        runs = [TrashedRun(run, deleted) for run in list_runs(entry)]
        try:
            with _deleting(entry, ", ".join(run.name for run in runs)) as draft:
                entry.rename(draft)
        except RunError as error:
            if os.path.lexists(entry):  # otherwise another process has just deleted it
                problem = error
        else:
            emptied += runs
    if problem is not None:
        raise problem
    return emptied


def _trash_entries(root: Path) -> list[tuple[Path, float]]:
    """Return the folders in the trash with the times of deletion."""
    trash, found = root / TRASH, []
    try:
        for entry in filter(is_folder, trash.iterdir() if is_folder(trash) else ()):
            with suppress(ValueError, OverflowError):
                at = datetime.strptime(entry.name, _TIME).replace(tzinfo=UTC)
                found.append((entry, at.timestamp()))
    except OSError as error:
        raise RunError(f"cannot list {trash}: {error.strerror}") from None
    return found

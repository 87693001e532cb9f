"""Atomic writes: files that are complete or absent, however the program ends."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import is_folder
from gaitsim.runs.files.drafts import draft_file, draft_name, locked, remove, sweep

_FULL = "free some space on the disk, or choose another folder"
_FORBIDDEN = "choose another folder, or allow writing to this one"
_NO_FOLDER = "choose another path: a part of this one is a file, not a folder"
_REMEDIES = {
    errno.ENOSPC: _FULL,
    errno.EDQUOT: _FULL,
    errno.EFBIG: _FULL,
    errno.EROFS: _FORBIDDEN,
    errno.EACCES: _FORBIDDEN,
    errno.EPERM: _FORBIDDEN,
    errno.ENOENT: "create the folder first, or choose an existing one",
    errno.ENOTDIR: _NO_FOLDER,
    errno.EEXIST: _NO_FOLDER,
    errno.EISDIR: "rename or move the folder of that name",
    errno.ELOOP: "remove the link, and restore the file from a copy of the run",
    errno.EMLINK: "replace the file with a copy: it has a second name (a hard link), which would "
    "change, too",
}
_NO_FOLDER_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.EACCES}


def write_bytes(path: Path, data: bytes, *, follow: bool = True) -> None:
    """Write `data` to `path` atomically: after a crash, the file has its new or its old content.

    Args:
        path: path of the file.
        data: new content.
        follow: whether to write to the target of a link, as for files named by the user. Links
            in a run folder are replaced instead, as their target may be anywhere.
    """
    with replacing(path, follow=follow) as partial:
        partial.write_bytes(data)


def write_rotating(path: Path, previous: Path, data: bytes) -> None:
    """Write `data` to `path`, and keep the old file as `previous`, in the same folder.

    At every moment, existing files at `path` and `previous` are complete. If `path` does not
    exist yet, `previous` does not change.
    """
    with writing(path), _partial(path.parent, data) as partial:
        if path.is_file() and not path.is_symlink():
            with _second_name(path) as second:
                second.replace(previous)
        partial.replace(path)
        sync_folder(path.parent)


@contextmanager
def replacing(path: Path, *, follow: bool = True) -> Iterator[Path]:
    """Yield a temporary file beside `path`, which replaces `path` if the block succeeds.

    This is for files too large for memory. If the block fails, `path` does not change, and the
    temporary file is removed.

    Args:
        path: path of the file.
        follow: whether to write to the target of a link, rather than to replace the link.
    """
    with writing(path):
        # Folders of runs and studies are swept once by their writer, when it opens them.
        if follow:
            path = _target(path)
            sweep(path.parent)
        with draft_file(path.parent) as partial:
            yield partial
            with partial.open("rb+") as file:
                os.fsync(file.fileno())
            partial.replace(path)
            sync_folder(path.parent)


def set_aside(path: Path, word: str) -> Path:
    """Rename `a.pickle` to the first free name of `a.<word>-1.pickle`, `a.<word>-2.pickle`, …"""
    with writing(path):
        number = 1
        while True:
            target = path.with_name(f"{path.stem}.{word}-{number}{path.suffix}")
            try:
                # An empty file or folder reserves the name, so that nothing is overwritten.
                target.mkdir() if is_folder(path) else target.open("xb").close()
                break
            except FileExistsError:
                number += 1
        try:
            path.replace(target)
        except BaseException:
            target.rmdir() if is_folder(target) else target.unlink()
            raise
        sync_folder(path.parent)
    return target


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Convert system errors in the block, which writes `path`, to a `RunError`."""
    try:
        yield
    except OSError as error:
        raise RunError(
            f"cannot write {path.name or path}: {error.strerror or error}",
            where=str(path),
            remedy=_REMEDIES.get(error.errno or 0, "check the disk and the path, then try again"),
        ) from error


def _target(path: Path) -> Path:
    """Return the path to write to: the target of a link, never a device or a pipe."""
    if path.is_symlink():
        path = path.resolve()
    if path.exists() and not path.is_file() and not path.is_dir():
        raise RunError(
            f"{path} is a device or a pipe, not a file",
            allowed="the name of a file, which is replaced if it exists",
        )
    return path


@contextmanager
def _partial(folder: Path, data: bytes) -> Iterator[Path]:
    """Create a draft in `folder` with `data` flushed to disk; remove it afterwards."""
    with draft_file(folder) as partial:
        with partial.open("rb+") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        yield partial


@contextmanager
def _second_name(path: Path) -> Iterator[Path]:
    """Create a second name for a file, or a copy if the file system lacks hard links."""
    second = draft_name(path.parent)
    with locked(path):  # also locks the second name
        try:
            os.link(path, second)
        except OSError:
            with _partial(path.parent, path.read_bytes()) as copy:
                yield copy
            return
        try:
            yield second
        finally:
            # After a crash between the two renames of a rotation, `path` and `previous` are names
            # of one file. POSIX then renames nothing, and the second name remains.
            remove(second)


def sync_folder(folder: Path) -> None:
    """Make renames in `folder` survive a power failure, if the system supports it."""
    if os.name == "nt":
        return
    try:
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        if error.errno not in _NO_FOLDER_SYNC:
            raise

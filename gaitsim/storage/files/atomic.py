"""Atomic writes: files that are complete or absent, however the program ends.

They are written as drafts: files and folders under a temporary name, until they are complete or
deleted. Each process locks its drafts. The system releases the lock however the process ends, so
that `sweep` can tell abandoned drafts from those still being written.
"""

import errno
import os
import shutil
import stat
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.opening import is_folder

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

_PREFIX, _SUFFIX = ".gaitsim-", ".partial"
_OLD = 3600  # seconds after which a draft is abandoned on file systems without locks


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

    With `follow`, the target of a link is written; otherwise, the link is replaced.
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


if sys.platform != "win32":  # Windows cannot rename open files
    import fcntl


def draft_name(folder: Path) -> Path:
    """Return a free name for a draft in `folder`."""
    return folder / f"{_PREFIX}{os.urandom(8).hex()}{_SUFFIX}"


@contextmanager
def draft_file(folder: Path) -> Iterator[Path]:
    """Create an empty file in `folder`; remove it afterwards unless it was renamed."""
    with ExitStack() as resources:
        yield _create(folder, lambda path: path.touch(exist_ok=False), resources)


@contextmanager
def draft_folder(folder: Path) -> Iterator[Path]:
    """Create an empty folder in `folder`; remove it afterwards unless it was renamed."""
    with ExitStack() as resources:
        yield _create(folder, Path.mkdir, resources)


def _create(folder: Path, create: Callable[[Path], None], resources: ExitStack) -> Path:
    while True:
        path = draft_name(folder)
        resources.callback(remove, path)
        create(path)
        with suppress(FileNotFoundError):  # another process swept it before it was locked
            resources.enter_context(locked(path))
            path.lstat()
            return path


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Keep other processes from sweeping a file or folder during the block, under any name."""
    if sys.platform == "win32":
        yield
        return
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def sweep(folder: Path) -> None:
    """Remove the drafts in `folder` that killed programs left, but not those in use."""
    for draft in folder.glob(f"{_PREFIX}*{_SUFFIX}"):
        with suppress(OSError):
            _remove_abandoned(draft)


def _remove_abandoned(draft: Path) -> None:
    found = draft.lstat()
    if not (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode)):
        draft.unlink()  # a link or a pipe, which gaitsim never creates
        return
    old = time.time() - found.st_mtime > _OLD
    if sys.platform == "win32":
        if old:
            remove(draft)
        return
    descriptor = os.open(draft, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        except OSError:
            if not old:
                return
        remove(draft)
    finally:
        os.close(descriptor)


def remove(draft: Path) -> None:
    """Remove a draft, as far as possible."""
    with suppress(OSError, RecursionError):  # rmtree recurses into nested folders
        if draft.is_dir() and not draft.is_symlink():
            shutil.rmtree(draft, ignore_errors=True)
        else:
            draft.unlink(missing_ok=True)

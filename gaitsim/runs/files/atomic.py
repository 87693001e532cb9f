"""Files that are complete or absent, whatever stops the program."""

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
_NO_FOLDER = "choose a folder: part of this path is a file"
_REMEDIES = {
    errno.ENOSPC: _FULL,
    errno.EDQUOT: _FULL,
    errno.EFBIG: _FULL,
    errno.EROFS: _FORBIDDEN,
    errno.EACCES: _FORBIDDEN,
    errno.EPERM: _FORBIDDEN,
    errno.ENOENT: "make the folder first, or choose one that exists",
    errno.ENOTDIR: _NO_FOLDER,
    errno.EEXIST: _NO_FOLDER,
    errno.EISDIR: "move the folder of that name away",
    errno.ELOOP: "remove the link, and restore the file from a copy of the run",
    errno.EMLINK: "replace it by a copy: otherwise, its other name would change, too",
}
_NO_FOLDER_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.EACCES}


def write_bytes(path: Path, data: bytes, *, follow: bool = True) -> None:
    """Write `data` to `path`, which even after a crash has either its new or its old content.

    Args:
        path: the file.
        data: its content.
        follow: whether to write to the target of a link, as where a user names the file. A link
            in a run folder is replaced instead: its target may be anywhere.

    Raises:
        RunError: the file cannot be written; `path` is whole, and most likely unchanged.
    """
    with replacing(path, follow=follow) as partial:
        partial.write_bytes(data)


def write_rotating(path: Path, previous: Path, data: bytes) -> None:
    """Put `data` at `path` and keep what stood there as `previous`, in the same folder.

    A `path` that exists is complete at every moment in between, and so is a
    `previous`. Without a `path` so far, `previous` is left alone.

    Raises:
        RunError: the files cannot be written; both are whole, and most likely as they were.
    """
    with writing(path), _partial(path.parent, data) as partial:
        if path.is_file() and not path.is_symlink():
            with _twin(path) as twin:
                twin.replace(previous)
        partial.replace(path)
        sync_folder(path.parent)


@contextmanager
def replacing(path: Path, *, follow: bool = True) -> Iterator[Path]:
    """A temporary file beside `path` for others to write; it becomes `path` where all goes well.

    For what is too long to hold in memory. Whatever ends the block early leaves `path` as
    it was, and no temporary file.

    Args:
        path: the file.
        follow: whether to write to the target of a link, rather than to replace the link.

    Raises:
        RunError: the file cannot be written; `path` is whole, and most likely as it was.
    """
    with writing(path):
        # Not in a run's or a study's own folders: their writer sweeps them once, as it begins.
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
    """Rename `a.pickle` to the first free one of `a.<word>-1.pickle`, `a.<word>-2.pickle`, …

    Raises:
        RunError: the file cannot be renamed.
    """
    with writing(path):
        number = 1
        while True:
            target = path.with_name(f"{path.stem}.{word}-{number}{path.suffix}")
            try:
                # An empty file, or folder, reserves the name, so that nothing is ever overwritten.
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
    """Turn errors of the system while `path` is written into a `RunError`."""
    try:
        yield
    except OSError as error:
        raise RunError(
            f"{path.name or path} cannot be written: {error.strerror or error}",
            where=str(path),
            remedy=_REMEDIES.get(error.errno or 0, "check the disk and the path, then try again"),
        ) from error


def _target(path: Path) -> Path:
    """Return the path to write to: the target of a link, never a device or a pipe."""
    if path.is_symlink():
        path = path.resolve()
    if path.exists() and not path.is_file() and not path.is_dir():
        raise RunError(
            f"{path} is not a file, but a device or a pipe",
            allowed="the name of a file, which is replaced if it is there",
        )
    return path


@contextmanager
def _partial(folder: Path, data: bytes) -> Iterator[Path]:
    """Create a draft in `folder` with `data` on the disk; remove it afterwards."""
    with draft_file(folder) as partial:
        with partial.open("rb+") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        yield partial


@contextmanager
def _twin(path: Path) -> Iterator[Path]:
    """Create a second name for a file, or a copy where the file system has no hard links."""
    twin = draft_name(path.parent)
    with locked(path):  # by its second name, too
        try:
            os.link(path, twin)
        except OSError:
            with _partial(path.parent, path.read_bytes()) as copy:
                yield copy
            return
        try:
            yield twin
        finally:
            # Renaming over another name of the same file, as after a crash between the
            # two renames of a rotation, does nothing by POSIX: the twin is still there.
            remove(twin)


def sync_folder(folder: Path) -> None:
    """Make renames in `folder` survive a power cut, where the system can."""
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

"""Drafts: files and folders under a temporary name, until they are complete or deleted.

Each process locks its drafts. The system releases the lock however the process ends, so that
`sweep` can tell abandoned drafts from those still being written.
"""

import os
import shutil
import stat
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

if sys.platform != "win32":  # Windows cannot rename open files
    import fcntl

_PREFIX, _SUFFIX = ".gaitsim-", ".partial"
_OLD = 3600  # seconds after which a draft is abandoned on file systems without locks


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

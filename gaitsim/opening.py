"""Open files that someone else may have made.

A pipe blocks its reader, a device may have no end, a link leads out of a folder, and a file may be
longer than the memory. So a file is opened without waiting and without following links, checked by
its descriptor, and refused unless it is a regular file of a bounded size.
"""

import errno
import os
import stat
from itertools import islice
from pathlib import Path
from typing import BinaryIO

# Windows has neither pipes in folders nor these flags, but text files.
_FLAGS = sum(getattr(os, name, 0) for name in ("O_NONBLOCK", "O_CLOEXEC", "O_BINARY", "O_NOCTTY"))
_NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0)
_PART = 2**20  # bytes


def open_descriptor(path: Path, flags: int, *, follow: bool = False) -> int:
    """Open a regular file, and return its descriptor.

    Args:
        path: the file.
        flags: of `os.open`, such as `os.O_RDWR | os.O_CREAT`.
        follow: whether `path` may be a link, as one that a user names may.

    Raises:
        OSError: it is not a regular file, or cannot be opened; `strerror` says why.
    """
    try:
        descriptor = os.open(path, flags | _FLAGS | (0 if follow else _NO_FOLLOW), 0o644)
    except OSError as error:
        if error.errno == errno.ELOOP and not follow:
            raise _refused(errno.ELOOP, "it is a symbolic link", path) from None
        if error.errno == errno.ENXIO:  # a socket, or a pipe without a reader
            raise _refused(errno.EINVAL, "it is not a regular file", path) from None
        raise
    try:
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            raise _refused(errno.EISDIR, os.strerror(errno.EISDIR), path)
        if not stat.S_ISREG(status.st_mode):
            raise _refused(errno.EINVAL, "it is not a regular file", path)
        if flags & (os.O_WRONLY | os.O_RDWR) and status.st_nlink > 1:
            raise _refused(errno.EMLINK, "it is a hard link: it has another name, too", path)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def open_regular(path: Path, largest: int, *, follow: bool = False) -> BinaryIO:
    """Open a regular file of at most `largest` bytes for reading.

    Raises:
        OSError: it is another kind of file, is larger, or cannot be opened; `strerror` says why.
    """
    file = os.fdopen(open_descriptor(path, os.O_RDONLY, follow=follow), "rb")
    if (size := _size(file)) > largest:
        file.close()
        raise _too_large(path, f"{size:,}", largest)
    return file


def read_regular(path: Path, largest: int, *, follow: bool = False) -> bytes:
    """Return the content of a regular file of at most `largest` bytes.

    Raises:
        OSError: it is another kind of file, is larger, or cannot be read; `strerror` says why.
    """
    with open_regular(path, largest, follow=follow) as file:
        # A single read would reserve memory for all that it is asked for.
        parts = iter(lambda: file.read(_PART), b"")
        data = b"".join(islice(parts, largest // _PART + 2))
    if len(data) > largest:  # it grew meanwhile, or its system does not say how long it is
        raise _too_large(path, "more", largest)
    return data


def is_folder(path: Path) -> bool:
    """Whether a path is a folder, and not a link to one."""
    try:
        return stat.S_ISDIR(os.lstat(path).st_mode)
    except (OSError, ValueError):
        return False


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size


def _too_large(path: Path, size: str, largest: int) -> OSError:
    return _refused(errno.EFBIG, f"it is too large: {size} bytes of at most {largest:,}", path)


def _refused(number: int, reason: str, path: Path) -> OSError:
    return OSError(number, reason, str(path))

"""Open untrusted files.

A pipe blocks its reader, a device may be endless, a link may lead out of a folder, and a file may
exceed the memory. Therefore files are opened without blocking and without following links, checked
through their descriptor, and rejected unless they are regular files of bounded size.
"""

import errno
import os
import stat
from itertools import islice
from pathlib import Path
from typing import BinaryIO

# Windows lacks pipes in folders and most of these flags; O_BINARY disables its text mode.
_FLAGS = sum(getattr(os, name, 0) for name in ("O_NONBLOCK", "O_CLOEXEC", "O_BINARY", "O_NOCTTY"))
_NO_FOLLOW = getattr(os, "O_NOFOLLOW", 0)
_PART = 2**20  # bytes


def open_descriptor(path: Path, flags: int, *, follow: bool = False) -> int:
    """Open a regular file, and return its descriptor.

    Args:
        path: path of the file.
        flags: flags for `os.open`, such as `os.O_RDWR | os.O_CREAT`.
        follow: whether `path` may be a link, as for files named by the user.
    """
    try:
        descriptor = os.open(path, flags | _FLAGS | (0 if follow else _NO_FOLLOW), 0o644)
    except OSError as error:
        if error.errno == errno.ELOOP and not follow:
            raise _file_error(errno.ELOOP, "it is a symbolic link", path) from None
        if error.errno == errno.ENXIO:  # a socket, or a pipe without a reader
            raise _file_error(errno.EINVAL, "it is not a regular file", path) from None
        if error.errno == errno.ENOENT and not flags & os.O_CREAT:
            raise _file_error(errno.ENOENT, "file not found", path) from None
        raise
    try:
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            raise _file_error(errno.EISDIR, os.strerror(errno.EISDIR), path)
        if not stat.S_ISREG(status.st_mode):
            raise _file_error(errno.EINVAL, "it is not a regular file", path)
        if flags & (os.O_WRONLY | os.O_RDWR) and status.st_nlink > 1:
            raise _file_error(errno.EMLINK, "it has several names (hard links)", path)
    except BaseException:
        os.close(descriptor)
        raise
    return descriptor


def open_regular(path: Path, largest: int, *, follow: bool = False) -> BinaryIO:
    """Open a regular file of at most `largest` bytes for reading."""
    file = os.fdopen(open_descriptor(path, os.O_RDONLY, follow=follow), "rb")
    if (size := _size(file)) > largest:
        file.close()
        raise _too_large(path, f"{size:,}", largest)
    return file


def read_regular(path: Path, largest: int, *, follow: bool = False) -> bytes:
    """Return the content of a regular file of at most `largest` bytes."""
    with open_regular(path, largest, follow=follow) as file:
        # A single read would allocate memory for the requested size at once.
        parts = iter(lambda: file.read(_PART), b"")
        data = b"".join(islice(parts, largest // _PART + 2))
    if len(data) > largest:  # the file has grown, or its file system reports no size
        raise _too_large(path, "more", largest)
    return data


def is_folder(path: Path) -> bool:
    """Return whether a path is a folder, and not a link to one."""
    try:
        return stat.S_ISDIR(os.lstat(path).st_mode)
    except (OSError, ValueError):
        return False


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size


def _too_large(path: Path, size: str, largest: int) -> OSError:
    return _file_error(errno.EFBIG, f"it is too large: {size} bytes, at most {largest:,}", path)


def _file_error(number: int, reason: str, path: Path) -> OSError:
    return OSError(number, reason, str(path))

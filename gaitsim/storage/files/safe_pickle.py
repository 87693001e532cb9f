"""The file format of checkpoints: a header, followed by an untrusted pickle.

=========  =====  ============================================
offset     bytes  content
=========  =====  ============================================
0          8      magic, `GAITSIM` and a zero byte
8          4      schema version, unsigned, little-endian
12         8      length of the pickle, unsigned, little-endian
20         32     SHA-256 of all other bytes of the file
52         rest   pickle, protocol 5
=========  =====  ============================================

This layout is the same in all schema versions. Any Python can load the pickle with
`pickle.loads(data[52:])`. It contains dicts with string keys, lists, str, int of 64 bits, float,
bool, None and bytes, without references. It uses only 24 opcodes, none of which imports, calls or
memoises anything.

A correct checksum shows that a file is undamaged, not that it is harmless. Therefore all opcodes
are checked before any is executed.
"""

import hashlib
import io
import os
import pickle
import pickletools
import struct
from pathlib import Path
from typing import Any, BinaryIO, NoReturn

from gaitsim.errors import CheckpointError, RunError
from gaitsim.opening import open_regular

MAX_DEPTH = 16
"""Maximum depth of nested containers."""

# A value that an opcode puts on the unpickler's stack: its type, and its depth in containers.
_Value = tuple[type, int]
_PUSHES: dict[str, _Value] = {
    "EMPTY_DICT": (dict, 1),
    "EMPTY_LIST": (list, 1),
    **dict.fromkeys(("SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8"), (str, 0)),
    **dict.fromkeys(("SHORT_BINBYTES", "BINBYTES", "BINBYTES8"), (bytes, 0)),
    **dict.fromkeys(("BININT", "BININT1", "BININT2", "LONG1"), (int, 0)),
    **dict.fromkeys(("NONE", "NEWTRUE", "NEWFALSE", "BINFLOAT"), (object, 0)),
}
# Opcodes that move values from the stack into the container below them: the type of the
# container, and for two of them the number of values. A mark gives the start for the others.
_FILLS: dict[str, type] = {"APPEND": list, "APPENDS": list, "SETITEM": dict, "SETITEMS": dict}
_WIDTHS = {"APPEND": 1, "SETITEM": 2}

MAGIC = b"GAITSIM\0"
VERSION = 6  # runs have scores.bin
HEADER = 52
"""Length of the header, bytes."""
MAX_BYTES = 2**30
"""Maximum length of a file, bytes."""
MAX_TEXT = 2**26
"""Maximum number of characters in all strings; each takes up to four bytes of memory."""
MAX_OPCODES = 1_000_000
_FIELDS = struct.Struct("<8sIQ")
_DIGEST = slice(_FIELDS.size, HEADER)


class RejectedPickleError(Exception):
    """Raised for a pickle that is rejected; the message is the reason."""


class OpcodeStack:
    """The unpickler's stack, with the type and depth of each value instead of the value."""

    def __init__(self) -> None:
        self.values: list[_Value] = []
        self.marks: list[int] = []

    def follow(self, name: str) -> None:
        """Apply the effect of an opcode to the stack."""
        if name in _PUSHES:
            self.values.append(_PUSHES[name])
        elif name == "MARK":
            self.marks.append(len(self.values))
        elif name in _WIDTHS:
            self._fill(_FILLS[name], len(self.values) - _WIDTHS[name])
        elif name in _FILLS:
            self._fill(_FILLS[name], self.marks.pop() if self.marks else 0)
        elif name not in ("FRAME", "STOP"):
            raise RejectedPickleError(f"it contains the opcode {name}, which no checkpoint has")

    def _fill(self, container: type, start: int) -> None:
        """Move the values from `start` on into the container below them."""
        if start < 1 or self.values[start - 1][0] is not container:
            raise RejectedPickleError(f"it fills a {container.__name__} that does not exist")
        items = self.values[start:]
        if container is dict and (len(items) % 2 or any(kind is not str for kind, _ in items[::2])):
            raise RejectedPickleError("a key is not a string")
        depth = max([self.values[start - 1][1], *(inner + 1 for _, inner in items)])
        if depth > MAX_DEPTH:
            raise RejectedPickleError(f"its containers are nested more than {MAX_DEPTH} deep")
        self.values[start - 1 :] = [(container, depth)]


class SchemaVersionError(CheckpointError):
    """Raised for an intact checkpoint in the format of an older or newer gaitsim."""


class NewerVersionError(SchemaVersionError):
    """Raised for an intact checkpoint in the format of a newer gaitsim."""


class _Reader(pickle.Unpickler):
    """An unpickler that builds only builtins, even if the scan missed something."""

    def find_class(self, module: str, name: str) -> NoReturn:
        raise RejectedPickleError(f"it imports {name!r} from {module!r}, which no checkpoint does")


def dumps(content: dict[str, Any]) -> bytes:
    """Return the bytes of a file, header and pickle, with the given content.

    Equal content, with keys in the same order, gives equal bytes.
    """
    file = io.BytesIO()
    file.write(bytes(HEADER))
    pickler = pickle.Pickler(file, protocol=5)
    # Without a memo, the bytes depend only on values, not on the identity of objects, and
    # contain no references.
    pickler.fast = True
    try:
        pickler.dump(content)
        with file.getbuffer() as view:
            _FIELDS.pack_into(view, 0, MAGIC, VERSION, len(view) - HEADER)
            digest = hashlib.sha256(view[: _DIGEST.start])
            digest.update(view[_DIGEST.stop :])
            view[_DIGEST] = digest.digest()
        if not _is_plain(content):  # a scan takes a fifth of the time to record a generation
            _scan(file)
        data = file.getvalue()
    except Exception as error:  # the pickler can raise any error
        raise ValueError(f"a checkpoint cannot contain this: {error}") from error
    if len(data) > MAX_BYTES:
        raise ValueError(f"a checkpoint has at most {MAX_BYTES:,} bytes, not {len(data):,}")
    return data


def load(path: Path) -> dict[str, Any]:
    """Read the file at `path`."""
    try:
        with open_regular(path, MAX_BYTES) as file:
            return _load(file, path)
    except FileNotFoundError as error:
        raise _read_error(path, "file not found", "check the path") from error
    except PermissionError as error:
        raise RunError(
            f"cannot read {path.name}: permission denied",
            where=str(path),
            remedy="change its permissions",
        ) from error
    except (OSError, MemoryError) as error:
        raise _read_error(path, _reason(error)) from error


def loads(data: bytes, path: Path) -> dict[str, Any]:
    """Read the bytes of a file; `path` names it in errors."""
    return _load(io.BytesIO(data), path)


def _load(file: BinaryIO, path: Path) -> dict[str, Any]:
    """Read a file, loading it into memory only if its header and checksum are correct."""
    header = file.read(HEADER)
    if not header:
        raise _read_error(path, "it is empty")
    if not header.startswith(MAGIC):
        raise _read_error(path, "it is a different kind of file", "give the path of a checkpoint")
    if len(header) < HEADER:
        raise _read_error(path, "it is damaged: the header is cut off")
    _, version, length = _FIELDS.unpack_from(header)
    found = file.seek(0, os.SEEK_END) - HEADER
    if length != found:
        raise _read_error(path, f"it is damaged: it has {found:,} bytes instead of {length:,}")
    if _digest(file) != header[_DIGEST]:
        raise _read_error(path, "it is damaged: its checksum is wrong")
    if version > VERSION:
        raise NewerVersionError(
            f"{path.name} was written by a newer gaitsim, in format {version}",
            where=str(path),
            allowed=f"format {VERSION}",
            remedy="update gaitsim: pip install --upgrade gaitsim",
        )
    if version < 1:
        raise _read_error(path, f"there is no schema version {version}")
    try:
        file.seek(0)
        stream = io.BytesIO(file.read(HEADER + length))
        _scan(stream)
        stream.seek(HEADER)
        content: dict[str, Any] = _Reader(stream).load()
    except Exception as error:  # hostile bytes can make the unpickler raise any error
        raise _read_error(path, _reason(error)) from error
    if version < VERSION:
        raise _older_format_error(path, version, content)
    return content


def _older_format_error(path: Path, version: int, content: dict[str, Any]) -> SchemaVersionError:
    """Return the error of a file written by an older gaitsim, which it names."""
    versions = content.get("versions")
    found = versions.get("gaitsim") if isinstance(versions, dict) else None
    writer = f"gaitsim {found if isinstance(found, str) else '?'}"[:40]
    return SchemaVersionError(
        f"{path.name} was written by {writer} in the older format {version}",
        where=str(path),
        allowed=f"format {VERSION}",
        remedy="open it with the version of gaitsim that wrote it, or start a new run with the "
        "experiment.toml of its folder: gaitsim run FOLDER/experiment.toml",
    )


def _digest(file: BinaryIO) -> bytes:
    file.seek(0)
    digest = hashlib.sha256(file.read(_DIGEST.start))
    file.seek(_DIGEST.stop)
    while part := file.read(2**20):
        digest.update(part)
    return digest.digest()


def _scan(stream: io.BytesIO) -> None:
    """Check every opcode of a file without building anything."""
    # genops reads from a stream, which allocates no more than its length.
    end = stream.seek(0, os.SEEK_END)
    stream.seek(HEADER)
    stack = OpcodeStack()
    text = 0
    for count, (opcode, arg, _) in enumerate(pickletools.genops(stream)):
        text += _text_length(arg)
        if count >= MAX_OPCODES:
            raise RejectedPickleError(f"it has more than {MAX_OPCODES:,} opcodes")
        if text > MAX_TEXT:
            raise RejectedPickleError(f"it has more than {MAX_TEXT:,} characters of text")
        if opcode.name == "FRAME" and (arg or 0) > end - stream.tell():
            raise RejectedPickleError("a frame is longer than the file")
        if count > 0:
            stack.follow(opcode.name)
        elif (opcode.name, arg) != ("PROTO", 5):
            raise RejectedPickleError("it is not a pickle of protocol 5")
    if stack.marks or [kind for kind, _ in stack.values] != [dict]:
        raise RejectedPickleError("it does not contain exactly one dict")
    if stream.tell() != end:
        raise RejectedPickleError("bytes follow the end of the pickle")


def _is_plain(content: object) -> bool:
    """Return whether content is so small and plain that `_scan` always accepts its pickle."""
    level, text, depth = [content], 0, 0
    while level and depth < MAX_DEPTH and len(level) < MAX_OPCODES / 100:
        inner: list[object] = []
        for value in level:
            if type(value) is dict:
                if not all(type(key) is str for key in value):
                    return False
                inner += [*value, *value.values()]
            elif type(value) is list:
                inner += value
            elif type(value) in (str, int):
                text += _text_length(value)
            elif type(value) not in (bytes, float, bool, type(None)):
                return False
        level, depth = inner, depth + 1
    return not level and text <= MAX_TEXT


def _text_length(arg: object) -> int:
    """Check the argument of an opcode, and return its number of characters."""
    if isinstance(arg, int) and not -(2**63) <= arg < 2**63:
        raise RejectedPickleError("a whole number needs more than 64 bits")
    if not isinstance(arg, str):
        return 0
    arg.encode()  # surrogates can be read but not printed
    return len(arg)


def _reason(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "it needs more memory than is available"
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return str(error) or type(error).__name__


def _read_error(
    path: Path,
    reason: str,
    remedy: str = "use an older copy of the file: this one cannot be repaired",
    allowed: str = "",
) -> CheckpointError:
    return CheckpointError(
        f"cannot read {path.name} as a checkpoint: {reason}",
        where=str(path),
        allowed=allowed or "a checkpoint written by gaitsim",
        remedy=remedy,
    )

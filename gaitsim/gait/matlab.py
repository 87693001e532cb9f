"""Read numbers and texts from MATLAB files that may be damaged or hostile.

SciPy's reader trusts the types and sizes in a file: a changed byte can crash the process, and the
size of unpacked data is not limited. This reader supports only the types that a gait needs: full,
real, two-dimensional matrices, and texts. Source of the format: "MAT-File Format", The MathWorks.
"""

import struct
import zlib
from collections.abc import Collection, Iterator
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

Fields = dict[str, NDArray[Any]]
Variables = Iterator[tuple[str, NDArray[Any]]]

VARIABLES = 1000  # limit for variables in a file, and for texts in a cell array
_LONGEST = 50_000  # bytes of a string
_DAMAGED = "it is cut off, or damaged"
_HEADER = 128  # bytes before the first variable of version 5
_HEAD = 512  # bytes of a packed variable that hold its name
_MATRIX, _COMPRESSED = 14, 15
_CELL, _CHAR = 1, 4
_REAL = range(6, 16)  # classes: double, single and the integers
_COMPLEX = 0x800  # flag
_NUMBERS = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"
}  # fmt: skip
_TEXTS = {1: "utf-8", 2: "utf-8", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_NUMBERS_4 = ("f8", "f4", "i4", "i2", "u2", "u1")


def read_matlab(data: bytes, names: Collection[str], largest: int) -> Fields:
    """Return the variables with given names; others are skipped.

    Args:
        data: content of the file.
        names: names of the variables.
        largest: limit for the unpacked size of these variables, bytes.
    """
    try:
        return dict(_variables(data, names, largest))
    except (struct.error, zlib.error):
        raise ValueError(_DAMAGED) from None


def _variables(data: bytes, names: Collection[str], largest: int) -> Variables:
    if 0 in data[:4]:  # version 5 starts with text
        return _version_4(memoryview(data), names)
    if data[126:128] not in (b"IM", b"MI"):
        raise ValueError("it has no MATLAB header")
    order = "<" if data[126:128] == b"IM" else ">"
    if struct.unpack_from(f"{order}H", data, 124)[0] != 0x100:
        raise ValueError("it is a MATLAB file of version 7.3; save it with '-v7'")
    return _version_5(memoryview(data)[_HEADER:], order, names, largest)


def _version_5(data: memoryview, order: str, names: Collection[str], largest: int) -> Variables:
    for place, (kind, body) in enumerate(_elements(data, order)):
        if place == VARIABLES:
            raise ValueError(f"it holds more than {VARIABLES:,} variables")
        if kind == _COMPRESSED:
            # Unpack only the start, so that large variables with other names cost nothing.
            name = _name(_unpack(body, order, _HEAD, cut=True), order)
            if name in names:
                matrix = _unpack(body, order, largest)
                largest -= len(matrix)
                yield name, _matrix(matrix, order)
        elif kind == _MATRIX:
            name = _name(body, order)
            if name in names:
                yield name, _matrix(body, order)


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield the type and content of each element."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        begin = at + 8
        if kind >> 16:  # at most four bytes, stored in the tag itself
            kind, size, begin = kind & 0xFFFF, kind >> 16, at + 4
            at += 8
        else:
            at = begin + size + (-size % 8 if kind != _COMPRESSED else 0)
        if begin + size > min(at, len(data)):
            raise ValueError(_DAMAGED)
        yield kind, data[begin : begin + size]


def _unpack(body: memoryview, order: str, largest: int, *, cut: bool = False) -> memoryview:
    """Return the content of a packed matrix; with `cut`, only the first `largest` bytes."""
    unpacker = zlib.decompressobj()
    data = unpacker.decompress(body, max(1, largest))  # 0 would mean no limit
    if unpacker.unconsumed_tail and not cut:
        raise ValueError("it unpacks to too many bytes")
    kind, size = struct.unpack_from(f"{order}II", data)
    if kind != _MATRIX or (len(data) - 8 < size and not cut):
        raise ValueError(_DAMAGED)
    return memoryview(data)[8 : 8 + size]


def _head(body: memoryview, order: str) -> tuple[int, list[int], str, Iterator[Any]]:
    """Return the flags, dimensions and name of a matrix, and its other elements."""
    parts = _elements(body, order)
    head = list(islice(parts, 3))
    if [kind for kind, _ in head] != [6, 5, 1] or len(head[0][1]) != 8:
        raise ValueError("a variable has no header")
    (_, flags), (_, sizes), (_, name) = head
    dimensions = [int(size) for size in np.frombuffer(sizes, f"{order}i4")]
    return struct.unpack_from(f"{order}I", flags)[0], dimensions, str(name, "latin-1"), parts


def _name(body: memoryview, order: str) -> str:
    return _head(body, order)[2]


def _matrix(body: memoryview, order: str) -> NDArray[Any]:
    flags, dimensions, name, parts = _head(body, order)
    if len(dimensions) != 2 or min(dimensions) < 0:
        raise ValueError(f"{name or 'a part'} has the dimensions {dimensions[:9]}")
    rows, columns = dimensions
    kind = flags & 0xFF
    if kind == _CELL:
        if rows * columns > VARIABLES:
            raise ValueError(f"{name} has {rows * columns:,} cells")
        cells = islice(parts, rows * columns)
        return np.array([_text(part, order) for _, part in cells])
    stored, content = next(parts)
    if kind == _CHAR and stored in _TEXTS:
        text = _decode(content, stored, order)
        return _rows(np.array(list(text)), rows, columns)
    if kind not in _REAL or flags & _COMPLEX or stored not in _NUMBERS:
        raise ValueError(f"{name} is neither a real matrix nor text")
    values = np.frombuffer(content, order + _NUMBERS[stored])
    return values.reshape(rows, columns, order="F")


def _text(body: memoryview, order: str) -> str:
    """Return the text in a cell."""
    flags, _, _, parts = _head(body, order)
    stored, content = next(parts, (16, memoryview(b"")))
    if flags & 0xFF != _CHAR or stored not in _TEXTS:
        raise ValueError("a cell holds no text")
    return _decode(content, stored, order)


def _decode(content: memoryview, stored: int, order: str) -> str:
    if len(content) > _LONGEST:
        raise ValueError(f"a string has more than {_LONGEST:,} bytes")
    wide = "" if _TEXTS[stored] == "utf-8" else {"<": "-le", ">": "-be"}[order]
    return str(content, _TEXTS[stored] + wide)


def _rows(characters: NDArray[Any], rows: int, columns: int) -> NDArray[Any]:
    """Return the text in each row of a matrix of characters, column by column."""
    if rows > _LONGEST:  # of no columns, they take no bytes in the file
        raise ValueError(f"a text has {rows:,} rows; at most {_LONGEST:,} are allowed")
    lines = characters.reshape(rows, columns, order="F").tolist()
    return np.array(["".join(line).rstrip() for line in lines])


def _version_4(data: memoryview, names: Collection[str]) -> Variables:
    at = 0
    for _ in range(VARIABLES):
        if at >= len(data):
            return
        order = "<" if struct.unpack_from("<i", data, at)[0] in range(53) else ">"
        form, rows, columns, imaginary, length = struct.unpack_from(f"{order}5i", data, at)
        # In decimal: the byte order, 0, the type of the numbers, and full, text or sparse.
        number, kind = form // 10 % 100, form % 10
        if number >= len(_NUMBERS_4) or kind > 2 or min(rows, columns) < 0 or length < 1:
            raise ValueError("a variable has no header")
        begin, stored = at + 20 + length, np.dtype(order + _NUMBERS_4[number])
        size = rows * columns * stored.itemsize
        at = begin + (2 * size if imaginary else size)
        if at > len(data):
            raise ValueError(_DAMAGED)
        name = str(data[begin - length : begin], "latin-1").rstrip("\0")
        if name not in names:
            continue
        if imaginary or kind == 2:
            raise ValueError(f"{name} is neither a real matrix nor text")
        values = np.frombuffer(data[begin : begin + size], stored)
        if kind == 1 and len(values) > _LONGEST:
            raise ValueError(f"a string has more than {_LONGEST:,} letters")
        if kind == 1:
            yield name, _rows(np.array([chr(int(code)) for code in values]), rows, columns)
        else:
            yield name, values.reshape(rows, columns, order="F")
    raise ValueError(f"it holds {VARIABLES:,} variables or more")

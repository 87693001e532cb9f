"""Parse untrusted XML without entities, with limits on depth and number of elements."""

import re
from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from gaitsim_robot.errors import RobotError

Floats = NDArray[np.float64]

DEPTH = 256  # nested elements
ELEMENTS = 300_000
LARGEST = 1e6  # absolute value of a number
LARGEST_INERTIA = 1e15  # absolute value in a file, which may state g·mm² instead of kg·m²

_RAW = "download the file itself: on GitHub, open it and press 'Raw'"

# Files that people mistake for a robot or a mesh: pattern of the beginning, name, remedy.
_OTHERS = (
    (rb"<!doctype\s+html|<html[\s/>]", "a web page", _RAW),
    (rb"\Aversion https://git-lfs", "a Git LFS pointer", "fetch the file itself: git lfs pull"),
    (rb"\A404: ", "the text of a failed download", "check the address of the file"),
    (rb"\A(#usda|PXR-USDC)", "a USD file", "convert it to URDF or MJCF"),
    (rb"\APK\x03\x04", "a ZIP archive", "unpack it"),
)


def mistaken_file(data: bytes) -> tuple[str, str] | None:
    """Return the kind of a file that is often mistaken for a robot or a mesh, and a remedy."""
    head = data[:1000].removeprefix(b"\xef\xbb\xbf").lstrip()
    for pattern, kind, remedy in _OTHERS:
        if re.search(pattern, head, re.IGNORECASE):
            return kind, remedy
    return None


def check_elements(count: int, depth: int, where: str) -> None:
    """Check the number and the depth of elements."""
    if depth > DEPTH or count > ELEMENTS:
        raise RobotError(
            "the XML has too many elements",
            where=where,
            allowed=f"at most {ELEMENTS:,} elements, nested at most {DEPTH} deep",
        )


def parse(data: bytes, where: str, encoding: str | None = None) -> Element:
    """Return the root element of an XML document.

    Args:
        data: the document.
        where: the file, for messages.
        encoding: encoding instead of the document's own. Without it, `_repaired` changes the data
            first; with it, the result describes exactly these data, for other parsers to read.
    """
    builder = TreeBuilder()
    depth = count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth += 1
        count += 1
        check_elements(count, depth, where)
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def doctype(*_: Any) -> None:
        if mistaken_file(data):
            raise ValueError
        raise RobotError(
            "the XML declares a document type or entities, which gaitsim does not read",
            where=where,
            remedy="remove the <!DOCTYPE …> declaration",
        )

    try:
        if encoding is None:
            data, encoding = _repaired(data)
        parser = expat.ParserCreate(encoding)
        parser.buffer_text = True
        parser.StartElementHandler = start
        parser.EndElementHandler = end
        parser.CharacterDataHandler = builder.data
        parser.StartDoctypeDeclHandler = doctype
        parser.EntityDeclHandler = doctype
        parser.Parse(data, True)
        return builder.close()
    except (expat.ExpatError, LookupError, ValueError) as error:
        kind, remedy = mistaken_file(data) or ("", "")
        if b"xacro" in data[:2000]:
            remedy = EXPAND
        raise RobotError(
            f"this is {kind}, not a robot" if kind else f"not XML: {error}",
            where=where,
            allowed="a robot as URDF (<robot>) or MJCF (<mujoco>)",
            remedy=remedy,
        ) from None


EXPAND = "expand a xacro file first: xacro robot.xacro > robot.urdf"
_BEGINNINGS = {
    b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16", b"<\0": "utf-16-le", b"\0<": "utf-16-be",
}  # fmt: skip
_DECLARED = re.compile(
    rb"<\?xml[^>]{,99}encoding=[\"'](gb2312|gbk|gb18030|big5|shift_jis|euc-jp|euc-kr)[\"']", re.I
)


def _repaired(data: bytes) -> tuple[bytes, str | None]:
    """Return a document that expat can read, and its encoding if it is not the declared one.

    A document may be UTF-16 although it declares a different encoding, as Windows PowerShell writes
    it. Some files have text before the XML declaration, or zeros after the end.
    """
    declared = _DECLARED.match(data)
    if found := declared[1].decode() if declared else _BEGINNINGS.get(data[:2]):
        data = data.decode(found).encode()
    data = data.rstrip(b"\0")
    at = data.find(b"<?xml", 0, 4096)
    if at > 0 and b"<" not in data[:at].replace(b"<!--", b""):
        data = data[at:]
    return data, "utf-8" if found else None


def numbers(
    text: str | None, count: int, default: str, where: str, largest: float = LARGEST
) -> Floats:
    """Return the numbers of an attribute, (count,)."""
    words = (default if text is None or not text.strip() else text).replace(",", " ").split()
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        values = np.full(1, np.nan)
    if len(values) != count or not (np.abs(values) <= largest).all():
        bounds = f" within ±{largest:,.0f}" if largest < np.inf else ""
        raise RobotError(
            f"invalid value {(text or '')[:80]!r}",
            where=where,
            allowed=f"{count} number{'s' if count > 1 else ''}{bounds}",
        )
    return values


def number(text: str | None, default: float, where: str, largest: float = LARGEST) -> float:
    """Return the number of an attribute."""
    return float(numbers(text, 1, str(default), where, largest)[0])

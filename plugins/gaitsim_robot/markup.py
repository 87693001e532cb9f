"""Parse untrusted XML without entities, with limits on depth and number of elements."""

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


def parse(data: bytes, where: str, encoding: str | None = None) -> Element:
    """Return the root element of an XML document."""
    builder = TreeBuilder()
    depth = count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, count
        depth += 1
        count += 1
        if depth > DEPTH or count > ELEMENTS:
            raise RobotError(
                "the XML has too many elements",
                where=where,
                allowed=f"at most {ELEMENTS:,} elements, nested at most {DEPTH} deep",
            )
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def doctype(*_: Any) -> None:
        raise RobotError(
            "the XML declares a document type or entities, which gaitsim does not read",
            where=where,
            remedy="remove the <!DOCTYPE …> declaration",
        )

    parser = expat.ParserCreate(encoding)
    parser.buffer_text = True
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = doctype
    parser.EntityDeclHandler = doctype
    try:
        parser.Parse(_trimmed(data), True)
        return builder.close()
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise RobotError(
            f"not XML: {error}",
            where=where,
            allowed="a robot as URDF (<robot>) or MJCF (<mujoco>)",
            remedy="convert a xacro file with `xacro robot.xacro > robot.urdf`"
            if b"xacro" in data[:2000]
            else "",
        ) from None


def _trimmed(data: bytes) -> bytes:
    """Remove text before the XML declaration and zeros after the end, as found in some files."""
    data = data.rstrip(b"\0")
    at = data.find(b"<?xml", 0, 4096)
    return data[at:] if at > 0 and b"<" not in data[:at].replace(b"<!--", b"") else data


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
        raise RobotError(
            f"invalid value {(text or '')[:80]!r}",
            where=where,
            allowed=f"{count} number{'s' if count > 1 else ''} within ±{largest:,.0f}",
        )
    return values


def number(text: str | None, default: float, where: str, largest: float = LARGEST) -> float:
    """Return the number of an attribute."""
    return float(numbers(text, 1, str(default), where, largest)[0])

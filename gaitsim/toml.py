"""Reading and printing TOML, with bounds on size and nesting."""

import hashlib
import json
import re
from collections import deque
from collections.abc import Mapping
from copy import deepcopy
from datetime import date, datetime, time
from functools import lru_cache
from typing import Any

import tomli

from gaitsim.errors import GaitsimError

LARGEST = 2_000_000  # bytes of an experiment file, which may include a robot with its meshes
DEEPEST = 20  # levels of nested tables and lists
MOST_VALUES = 20_000  # values in all tables and lists together
LONG = 200  # characters; longer texts are shortened
_QUOTED = re.compile(
    r'''
    """(?:[^"\\]|\\.|"{1,2}(?!"))*+(?:""")?
    | \'{3}(?:[^\']|\'{1,2}(?!\'))*+(?:\'{3})?
    | "(?:[^"\\\n]|\\.)*+"?
    | \'[^\'\n]*+\'?
    | \#[^\n]*+
    ''',
    re.VERBOSE | re.DOTALL,
)
"""Quoted strings and comments."""
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_DOTTED = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")


def parse(text: str, source: str) -> dict[str, Any]:
    """Return the values of a TOML text, which is parsed once if a command reads it repeatedly.

    Args:
        text: text to parse.
        source: origin of the text, for messages.
    """
    try:
        return deepcopy(_parse(text))
    except GaitsimError as error:
        error.where = f"{source}{error.where}"
        raise


@lru_cache(maxsize=8)
def _parse(text: str) -> dict[str, Any]:
    """Return the values of a text; errors lack its origin."""
    # The running time of tomli is quadratic in the parts of a dotted key.
    if _DOTTED.search(_QUOTED.sub("x", text)):
        raise _too_deep("")
    try:
        data = tomli.loads(text)
    except tomli.TOMLDecodeError as error:  # unlike tomllib's, it has line and column numbers
        raise GaitsimError(
            f"not valid TOML: {error.msg}",
            where=f", line {error.lineno}, column {error.colno}",
            allowed='each key and section once, strings in quotes such as "sine", numbers such '
            "as 0.1",
        ) from None
    except RecursionError:
        raise _too_deep("") from None
    except ValueError:  # raised by int() for thousands of digits
        raise GaitsimError(
            "not valid TOML: a whole number is too long", allowed=_INTEGERS
        ) from None
    waiting = deque((key, value, 1) for key, value in data.items())
    number = 0
    while waiting:  # without recursion, which has a depth limit
        key, value, depth = waiting.popleft()
        number += 1
        if number > MOST_VALUES:
            raise GaitsimError("too many values", allowed=f"at most {MOST_VALUES:,}")
        if depth > DEEPEST:
            raise _too_deep(f", key {key[:40]}")
        if isinstance(value, dict):
            waiting += [(f"{key}.{name}", item, depth + 1) for name, item in value.items()]
        elif isinstance(value, list):
            waiting += [(key, item, depth + 1) for item in value]
        if isinstance(value, int) and not -(2**63) <= value < 2**63:
            raise GaitsimError(
                "not valid TOML: a whole number is too long",
                where=f", key {key}",
                allowed=_INTEGERS,
            )
    return data


_INTEGERS = "whole numbers from −2^63 to 2^63 − 1"


def _too_deep(key: str) -> GaitsimError:
    return GaitsimError(
        "tables or lists are nested too deeply",
        where=key,
        allowed=f"at most {DEEPEST} levels",
    )


def flatten(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Return the values of nested tables by dotted key, such as `mutation.rate`.

    Args:
        table: table that may contain tables.
        before: beginning of all keys.
    """
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            found |= flatten(value, f"{before}{key}.")
        else:
            found[f"{before}{key}"] = value
    return found


def literal(value: Any) -> str:
    """Return a value in TOML syntax for messages, shortened if long."""
    return brief(value) if is_long(value) else shortened(text(value))


def is_long(value: Any) -> bool:
    """Return whether a value is a text of several lines or more than `LONG` characters."""
    return isinstance(value, str) and (len(value) > LONG or "\n" in value)


def brief(value: Any) -> str:
    """Return a value as text; for a long text, its beginning, size and checksum."""
    if isinstance(value, dict | list | tuple):
        return text(value)
    if not is_long(value):
        return str(value)
    data = value.encode(errors="replace")
    size = f"{len(data):,} bytes" if len(data) < 1000 else f"{len(data) / 1000:,.0f} kB"
    start = next((line.strip() for line in value.splitlines() if line.strip()), "")
    return f"{shortened(start, 40)} ({size} of text, SHA-256 {checksum(value)[:8]})"


def checksum(text: str) -> str:
    """Return the SHA-256 hash of a text in UTF-8, as hexadecimal digits."""
    return hashlib.sha256(text.encode(errors="replace")).hexdigest()


def shortened(text: str, longest: int = 60) -> str:
    """Return a text, truncated to a length that suits messages."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def text(value: Any) -> str:
    """Return a value in TOML syntax, on one line."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, date | time | datetime):
        return value.isoformat()
    if isinstance(value, dict):
        pairs = ", ".join(f"{_key(key)} = {text(item)}" for key, item in value.items())
        return f"{{{pairs}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(text(item) for item in value)}]"
    return "none" if value is None else str(value)


def _key(name: str) -> str:
    """Return a key in TOML syntax, quoted if necessary."""
    return name if _BARE.fullmatch(name) else text(name)

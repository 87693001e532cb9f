"""Mutations of valid files, as caused by damage, editors or attackers."""

import math
import random
import re
from copy import deepcopy

WORDS = (
    *("nan", "inf", "-inf", "1e400", "-1", "0", "1.5", "", "null", "true", "[]", "{}", '"', ","),
    *("9" * 5000, "9" * 19, "x" * 70_000, "[" * 3000, '{"a":' * 3000, "\n" * 5000, "#", "\r", "\0"),
    *("é", "\u202e", "\x1b]52;c;eA==\x07", "generation", "1e308", "2020-01-01", "''", "\t"),
)
"""Words that can break a parser."""

VALUES = (
    *(None, True, -1, 0, 1, 3, 2**62, -(2**63), 1.5, -0.0, 1e308, math.nan, math.inf, -math.inf),
    *("", "x" * 300, "nan", "[" * 3000, "\x1b[2J", b"", bytes(8), bytes(960), [], [[]], {}),
)
"""Values that can break a reader of plain values."""

_TOKEN = re.compile(rb"[\w.+:-]+")


def changed_bytes(data: bytes, chance: random.Random) -> bytes:
    """Return a copy of a file, changed in one to three places."""
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        data = chance.choice(_CHANGES)(data, chance)
    return data


def changed_values(content, chance: random.Random):
    """Return a copy of nested dicts and lists with one to three values replaced or removed."""
    changed = deepcopy(content)
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        if isinstance(changed, dict | list):
            _change_value(changed, chance)
    return changed


def _change_value(content, chance):
    places = [(content, at) for at in _keys(content)]
    for container, key in places:  # which grows
        inner = container[key]
        if isinstance(inner, dict | list):
            places += [(inner, at) for at in _keys(inner)]
    if not places:
        return
    container, key = chance.choice(places)
    match chance.randrange(8):
        case 0:
            del container[key]
        case 1:
            other, at = chance.choice(places)
            container[key] = deepcopy(other[at])
        case 2 if isinstance(container, dict):
            container[chance.choice(("more", "", "\x1b", "x" * 300))] = chance.choice(VALUES)
        case _:
            container[key] = deepcopy(chance.choice(VALUES))


def _keys(content):
    return content if isinstance(content, dict) else range(len(content))


def _span(data, chance):
    start = chance.randrange(len(data) + 1)
    return start, min(len(data), start + chance.choice((1, 1, 8, 96, 1000)))


def _flip(data, chance):
    changed = bytearray(data or b"\0")
    changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def _overwrite(data, chance):
    start, end = _span(data, chance)
    filling = chance.choice((bytes(end - start), b"\xff" * (end - start), chance.randbytes(8)))
    return data[:start] + filling + data[end:]


def _truncate(data, chance):
    return data[: chance.randrange(len(data) + 1)]


def _delete(data, chance):
    start, end = _span(data, chance)
    return data[:start] + data[end:]


def _repeat(data, chance):
    start, end = _span(data, chance)
    return data[:end] + data[start:end] * chance.choice((1, 1, 300)) + data[end:]


def _tokens(data):
    return [*_TOKEN.finditer(data[:100_000])]


def _insert_word(data, chance):
    at = chance.randrange(len(data) + 1)
    return data[:at] + chance.choice(WORDS).encode() + data[at:]


def _replace_word(data, chance):
    found = chance.choice(_tokens(data) or [re.search(b"", data)])
    return data[: found.start()] + chance.choice(WORDS).encode() + data[found.end() :]


def _swap_words(data, chance):
    tokens = _tokens(data)
    if len(tokens) < 2:
        return data
    one, two = sorted(chance.sample(tokens, 2), key=lambda token: token.start())
    between = data[one.end() : two.start()]
    return data[: one.start()] + two[0] + between + one[0] + data[two.end() :]


def _change_lines(data, chance):
    lines = data.splitlines(keepends=True) or [b""]
    one, two = chance.randrange(len(lines)), chance.randrange(len(lines))
    match chance.randrange(3):
        case 0:
            lines[one], lines[two] = lines[two], lines[one]
        case 1:
            del lines[one]
        case _:
            lines.insert(two, lines[one])
    return b"".join(lines)


_CHANGES = (
    *(_flip, _overwrite, _truncate, _delete, _repeat, _insert_word, _swap_words, _change_lines),
    *[_replace_word] * 4,
)

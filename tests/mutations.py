"""Mutations of valid files: what damage, editors and ill will make of them."""

import random
import re

WORDS = (
    *("nan", "inf", "-inf", "1e400", "-1", "0", "1.5", "", "null", "true", "[]", "{}", '"', ","),
    *("9" * 5000, "9" * 19, "x" * 70_000, "[" * 3000, '{"a":' * 3000, "\n" * 5000, "#", "\r", "\0"),
    *("é", "\ud7ff\u202e", "\x1b]52;c;eA==\x07", "generation", "1e308", "2020-01-01", "''", "\t"),
)
_TOKEN = re.compile(rb"[\w.+:-]+")


def mutations(data: bytes, count: int, seed: int = 0):
    """Yield mutated copies of a file, each changed in one to three places."""
    chance = random.Random(seed)
    for _ in range(count):
        changed = data
        for _ in range(chance.choice((1, 1, 1, 2, 3))):
            changed = chance.choice(_CHANGES)(changed, chance)
        yield changed


def _place(data, chance):
    return chance.randrange(len(data) + 1)


def _span(data, chance):
    start = _place(data, chance)
    return start, min(len(data), start + chance.choice((1, 1, 8, 96, 1000)))


def _flip(data, chance):
    at = _place(data, chance)
    return (
        data[:at]
        + bytes(byte ^ 1 << chance.randrange(8) for byte in data[at : at + 1])
        + data[at + 1 :]
    )


def _overwrite(data, chance):
    start, end = _span(data, chance)
    filling = chance.choice((bytes(end - start), b"\xff" * (end - start), chance.randbytes(8)))
    return data[:start] + filling + data[end:]


def _cut(data, chance):
    return data[: _place(data, chance)]


def _delete(data, chance):
    start, end = _span(data, chance)
    return data[:start] + data[end:]


def _repeat(data, chance):
    start, end = _span(data, chance)
    return data[:end] + data[start:end] * chance.choice((1, 1, 300)) + data[end:]


def _word(data, chance):
    """Replace a token, or insert one."""
    tokens = [*_TOKEN.finditer(data[:100_000])]
    word = chance.choice(WORDS).encode()
    if not tokens or chance.random() < 0.2:
        at = _place(data, chance)
        return data[:at] + word + data[at:]
    found = chance.choice(tokens)
    return data[: found.start()] + word + data[found.end() :]


def _swap_tokens(data, chance):
    tokens = [*_TOKEN.finditer(data[:100_000])]
    if len(tokens) < 2:
        return data
    one, two = sorted(chance.sample(tokens, 2), key=lambda token: token.start())
    between = data[one.end() : two.start()]
    return data[: one.start()] + two[0] + between + one[0] + data[two.end() :]


def _lines(data, chance):
    """Swap, drop or double lines."""
    lines = data.splitlines(keepends=True)
    if len(lines) < 2:
        return data
    one, two = chance.randrange(len(lines)), chance.randrange(len(lines))
    match chance.randrange(3):
        case 0:
            lines[one], lines[two] = lines[two], lines[one]
        case 1:
            del lines[one]
        case _:
            lines.insert(two, lines[one])
    return b"".join(lines)


_CHANGES = (_flip, _overwrite, _cut, _delete, _repeat, _word, _word, _word, _swap_tokens, _lines)

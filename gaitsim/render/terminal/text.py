"""Text for terminals: numbers, and what plugins, files and users wrote, made safe to print."""

import unicodedata

STEERING = ("Cc", "Cf", "Cs")
"""The categories of control and format characters, and of lone surrogates."""


def number(value: float, digits: int = 3) -> str:
    """Return a number with a true minus sign, such as '−0.123'."""
    return f"{value:z.{digits}f}".replace("-", "−")


def visible(text: str) -> str:
    """Return a text on one line whose control characters, which could steer the terminal, are
    escaped.
    """
    if text.isprintable():
        return text
    return "".join(
        _escape(char) if unicodedata.category(char) in STEERING else char for char in text
    )


def _escape(char: str) -> str:
    if "\x80" <= char <= "\x9f":  # TOML, whose texts may hold these, does not know \\x85
        return f"\\u{ord(char):04x}"
    return char.encode("unicode_escape").decode()


def visible_lines(text: str) -> str:
    """Return the same for a text of several lines, which stay."""
    return "\n".join(map(visible, text.split("\n")))

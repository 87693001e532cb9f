"""Text from plugins, files and users, made safe to print in a terminal."""

import unicodedata

_ESCAPED = ("Cc", "Cf", "Cs")  # control and format characters, and lone surrogates


def visible(text: str) -> str:
    """Return a text on one line whose control characters, which could steer the terminal, are
    escaped.
    """
    if text.isprintable():
        return text
    return "".join(
        char.encode("unicode_escape").decode() if unicodedata.category(char) in _ESCAPED else char
        for char in text
    )


def visible_lines(text: str) -> str:
    """Return the same for a text of several lines, which stay."""
    return "\n".join(map(visible, text.split("\n")))

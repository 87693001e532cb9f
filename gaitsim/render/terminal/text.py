"""Text for terminals: numbers, and strings of plugins, files and users made safe to print."""

import unicodedata

STEERING = ("Cc", "Cf", "Cs")
"""The Unicode categories of control characters, format characters and lone surrogates."""


def number(value: float, digits: int = 3) -> str:
    """Return a number with a true minus sign, such as '−0.123'."""
    return f"{value:z.{digits}f}".replace("-", "−")


def visible(text: str) -> str:
    """Return text on one line, with the characters that could control the terminal escaped."""
    if text.isprintable():
        return text
    return "".join(
        _escape(char) if unicodedata.category(char) in STEERING else char for char in text
    )


def _escape(char: str) -> str:
    if "\x80" <= char <= "\x9f":  # TOML allows these characters, but not escapes such as \\x85
        return f"\\u{ord(char):04x}"
    return char.encode("unicode_escape").decode()


def visible_lines(text: str) -> str:
    """Return text with all control characters escaped like in `visible`, except line breaks."""
    return "\n".join(map(visible, text.split("\n")))

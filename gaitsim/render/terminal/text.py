"""Text for terminals: numbers, and strings of plugins, files and users made safe to print."""

import unicodedata

STEERING = ("Cc", "Cf", "Cs")
"""The Unicode categories of control characters, format characters and lone surrogates."""

MINUTE, HOUR, DAY = 60, 3600, 86400
# The units of an age: name, seconds, and the smallest age for which the unit is used.
AGES = (
    ("y", 365 * DAY, 365 * DAY),
    ("w", 7 * DAY, 100 * DAY),
    ("d", DAY, DAY),
    ("h", HOUR, HOUR),
    ("min", MINUTE, MINUTE),
)


def number(value: float, digits: int = 3) -> str:
    """Return a number with a true minus sign, such as '−0.123'."""
    return f"{value:z.{digits}f}".replace("-", "−")


def percent(share: float) -> str:
    """Format a share from 0 to 1 with more digits if it is small: '0.12%', '1.2%', '12%'."""
    return f"{share:.{(share < 0.1) + (share < 0.01)}%}"


def age(seconds: float) -> str:
    """Format an age in at most six characters: 'now', '12 s', '5 min', '3 h', '2 d', '14 w'."""
    if seconds < 5:
        return "now"
    for unit, length, least in AGES:
        if seconds >= least:
            return f"{int(seconds // length)} {unit}"
    return f"{int(seconds)} s"


def ago(seconds: float) -> str:
    """Format the time since an event in at most ten characters: 'now', '12 min ago'."""
    text = age(seconds)
    return text if text == "now" else f"{text} ago"


def duration(seconds: float) -> str:
    """Format a time span: '0.4 s', '12 s', '3 min 5 s', '2 h 3 min'."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = int(seconds)
    if whole < MINUTE:
        return f"{whole} s"
    minutes, rest = divmod(whole, MINUTE)
    if whole < HOUR:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


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

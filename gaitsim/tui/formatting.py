"""Formats of numbers, times and names in the UI."""

from rich.cells import cell_len, set_cell_size

from gaitsim.render.terminal.text import visible

MINUTE, HOUR, DAY = 60, 3600, 86400
# The units of an age: name, seconds, and the smallest age for which the unit is used.
AGES = (
    ("y", 365 * DAY, 365 * DAY),
    ("w", 7 * DAY, 100 * DAY),
    ("d", DAY, DAY),
    ("h", HOUR, HOUR),
    ("min", MINUTE, MINUTE),
)


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


def percentage(share: float) -> str:
    """Format a share from 0 to 1 in five characters: '  3 %', '100 %'."""
    return f"{100 * share:3.0f} %"


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


def clip(text: str, width: int) -> str:
    """Clip a string to `width` cells, with '…'; escape control characters."""
    text = visible(text)
    return text if cell_len(text) <= width else set_cell_size(text, max(0, width - 1)) + "…"


def clip_name(name: str, width: int) -> str:
    """Clip a name in the middle, because names often differ at their ends."""
    name = visible(name)
    if cell_len(name) <= width:
        return name
    end = name[::-1]
    tail = set_cell_size(end, max(0, width - 1) // 2).rstrip()[::-1]
    return set_cell_size(name, max(0, width - 1 - cell_len(tail))) + "…" + tail


def file_size(count: int) -> str:
    """Format a number of bytes: '812 B', '12.3 kB', '4.0 MB'."""
    if count < 1000:
        return f"{count} B"
    if count < 999_950:
        return f"{count / 1e3:.1f} kB"
    return f"{count / 1e6:.1f} MB"

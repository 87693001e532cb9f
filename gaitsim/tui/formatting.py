"""Formats of numbers, times and names in the UI."""

from rich.cells import cell_len, set_cell_size

from gaitsim.render.terminal.text import visible

MINUTE, HOUR, DAY = 60, 3600, 86400


def age(seconds: float) -> str:
    """Format an age in at most four characters: 'now', '12 s', '5 m', '3 h', '2 d'."""
    if seconds < 5:
        return "now"
    for unit, length in (("d", DAY), ("h", HOUR), ("m", MINUTE)):
        if seconds >= length:
            return f"{int(seconds // length)} {unit}"
    return f"{int(seconds)} s"


def duration(seconds: float) -> str:
    """Format a time span: '0.4 s', '12 s', '3:05 min', '2:03:10 h'."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = int(seconds)
    if whole < MINUTE:
        return f"{whole} s"
    minutes, rest = divmod(whole, MINUTE)
    if whole < HOUR:
        return f"{minutes}:{rest:02} min"
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02} h"


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

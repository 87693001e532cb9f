"""Formats of numbers, times and names in the UI."""

from rich.cells import cell_len, set_cell_size

from gaitsim.render.terminal.text import visible

NOTIFIED = 100  # columns of a command or an error in a notification; a code takes thousands


def percentage(share: float) -> str:
    """Format a share from 0 to 1 in five characters: '  3 %', '100 %'."""
    return f"{100 * share:3.0f} %"


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

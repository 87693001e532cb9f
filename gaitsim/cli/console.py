"""Where text goes: results to standard output, notices and errors to standard error."""

import json
import sys
from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from gaitsim.render.terminal.text import visible_lines

PIPED_WIDTH = 1000  # columns: rows are not broken for a program


def output() -> Console:
    """Standard output. Piped, it is as wide as its lines; NO_COLOR and TERM are honoured."""
    width = None if sys.stdout.isatty() else PIPED_WIDTH
    return Console(highlight=False, emoji=False, width=width)


def errors() -> Console:
    """Standard error."""
    return Console(stderr=True, highlight=False, emoji=False, soft_wrap=True)


def notice(text: str) -> None:
    """Say something that is not a result."""
    errors().print(visible_lines(text), style="yellow", markup=False)


def print_json(values: Mapping[str, Any]) -> None:
    """One object on one line; what is not a finite number is null."""
    print(json.dumps(finite(values), ensure_ascii=False), flush=True)


def finite(value: Any) -> Any:
    """The same with null for NaN and infinities, which JSON does not have."""
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not -1e308 < value < 1e308:
        return None
    return value


def table(*columns: str, title: str = "", numbers: tuple[str, ...] = ()) -> Table:
    """An empty table in the house style; columns in `numbers` are aligned right."""
    made = Table(
        box=None, title=title or None, title_justify="left", pad_edge=False, header_style="bold"
    )
    for name in columns:
        made.add_column(name, justify="right" if name in numbers else "left", no_wrap=False)
    return made


def number(value: float, digits: int = 3) -> str:
    """A number with a true minus sign aligned for people, such as '−0.123'."""
    return f"{value:z.{digits}f}".replace("-", "−")

"""Where text goes: results to standard output, notices and errors to standard error.

With `GAITSIM_PROGRESS=json`, standard error is JSON lines for programs: one object a line, whose
`kind` is `progress`, `notice`, `result` or `error`.
"""

import json
import sys
from collections.abc import Container, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import TextType

from gaitsim.cli.streams import machine_readable, results
from gaitsim.render.terminal.text import visible_lines

PIPED_WIDTH = 1000  # columns: rows are not broken for a program


def output() -> Console:
    """Standard output. Piped, it is as wide as its lines; NO_COLOR and TERM are honoured."""
    width = None if results().isatty() else PIPED_WIDTH
    return Console(file=results(), highlight=False, emoji=False, width=width)


def errors() -> Console:
    """Standard error; never a terminal where programs read it."""
    terminal = False if machine_readable() else None
    return Console(
        stderr=True, highlight=False, emoji=False, soft_wrap=True, force_terminal=terminal
    )


def status(text: str) -> AbstractContextManager[object]:
    """Show a line in a terminal, as long as the block takes."""
    console = errors()
    return console.status(text) if console.is_terminal else nullcontext()


def record(kind: str, **values: Any) -> None:
    """Print a record for programs to standard error, as one line of JSON."""
    print(json.dumps({"kind": kind, **finite(values)}), file=sys.stderr, flush=True)  # noqa: T201


def wrote(*paths: Path) -> None:
    """Report the files that a command has written; people read of them in its output."""
    if machine_readable():
        record("result", files=[str(path) for path in paths])


def notice(text: str) -> None:
    """Say something that is not a result."""
    if machine_readable():
        record("notice", text=text)
        return
    errors().print(visible_lines(text), style="yellow", markup=False)


def echo(text: object, end: str = "\n") -> None:
    """Write plain text to standard output; `print` would write it to where plugins print."""
    print(text, end=end, file=results(), flush=True)


def print_json(values: Mapping[str, Any]) -> None:
    """Print one object on one line, with null for NaN and infinities."""
    echo(json.dumps(finite(values), ensure_ascii=False))


def finite(value: Any) -> Any:
    """The same with null for NaN and infinities, which JSON does not have."""
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not -1e308 < value < 1e308:
        return None
    return value


def print_table(
    columns: Iterable[TextType], rows: Iterable[Sequence[TextType]], numbers: Container[str] = ()
) -> None:
    """Print a table to standard output; columns in `numbers` are aligned right."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in columns:
        table.add_column(name, justify="right" if str(name) in numbers else "left")
    for row in rows:
        table.add_row(*row)
    output().print(table, markup=False)

"""Printing: results to standard output, notices and errors to standard error.

With `GAITSIM_PROGRESS=json`, standard error is JSON lines for programs: one object per line,
whose `kind` is `progress`, `notice`, `result` or `error`.
"""

import json
import os
import sys
import time
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import typer
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text, TextType

from gaitsim.console.streams import machine_readable, results
from gaitsim.errors import GaitsimError
from gaitsim.render.terminal.text import visible, visible_lines

MOST_WRAPPED = 1_000  # rows of a table, as Rich takes a millisecond for each
PIPED_WIDTH = 1000  # columns, so that rows are not wrapped for programs


class PlainConsole(Console):
    """A console that escapes control characters and ignores markup.

    Names, messages and documentation may come from untrusted files and plugins; all are printed
    with this class or `echo`. Styles and colours come from gaitsim alone.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(highlight=False, emoji=False, markup=False, **settings)

    def render_str(self, text: str, **settings: Any) -> Text:
        """Escape a string before layout."""
        return super().render_str(visible_lines(text), **settings)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """Escape styled text."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield segment._replace(text=visible_lines(segment.text))


def output() -> Console:
    """Return a console for standard output, wide enough for any row if piped.

    It honours NO_COLOR and TERM, and for the terminal UI, COLUMNS.
    """
    own = results().isatty() or (machine_readable() and "COLUMNS" in os.environ)
    width = None if own else PIPED_WIDTH
    return PlainConsole(file=results(), width=width)


def errors() -> Console:
    """Return a console for standard error, without terminal features if programs read it."""
    terminal = False if machine_readable() else None
    return PlainConsole(stderr=True, soft_wrap=True, force_terminal=terminal)


def status(text: str) -> AbstractContextManager[object]:
    """Show a line with the elapsed time in a terminal while the block runs."""
    console = errors()
    return console.status(_Elapsed(text)) if console.is_terminal else nullcontext()


class _Elapsed:
    """A text with the time since it was created, shown after the first second."""

    def __init__(self, text: str) -> None:
        self._text, self._begun = text, time.monotonic()

    def __rich__(self) -> Text:
        seconds = int(time.monotonic() - self._begun)
        # Rich would parse a string as markup.
        return Text(f"{self._text} {seconds} s" if seconds else self._text)


def agrees(what: str, *, yes: bool) -> bool:
    """Return whether the user agrees to a change, such as 'delete 2 runs'; `yes` does not ask."""
    if yes:
        return True
    if not sys.stdin.isatty():
        raise GaitsimError(
            f"cannot {what}: there is no terminal to confirm it",
            remedy="add --yes to change runs without asking",
        )
    if typer.confirm(visible_lines(f"{what[0].upper()}{what[1:]}?")):
        return True
    notice("Nothing was changed.")
    return False


def print_record(kind: str, **values: Any) -> None:
    """Print one line of JSON for programs to standard error."""
    print(json.dumps({"kind": kind, **replace_non_finite(values)}), file=sys.stderr, flush=True)  # noqa: T201


def report_files(*paths: Path) -> None:
    """Report written files to programs; people see them in the output of the command."""
    if machine_readable():
        print_record("result", files=[str(path) for path in paths])


def notice(text: str) -> None:
    """Print a message that is not a result."""
    if machine_readable():
        print_record("notice", text=text)
        return
    errors().print(text, style="yellow")


def echo(text: object, end: str = "\n") -> None:
    """Write plain text to the stream for results; `print` would write where plugins do."""
    print(visible_lines(str(text)), end=end, file=results(), flush=True)


def print_json(values: Mapping[str, Any]) -> None:
    """Print one object on one line, with null for NaN and infinities."""
    echo(as_json(values))


def as_json(values: Mapping[str, Any]) -> str:
    """Return one object on one line, with null for NaN and infinities."""
    line = json.dumps(replace_non_finite(values), ensure_ascii=False)
    if not line.isprintable():
        line = "".join(char if char.isprintable() else json.dumps(char)[1:-1] for char in line)
    return line


def replace_non_finite(value: Any) -> Any:
    """Return a value with None for NaN and infinities at any depth, as JSON lacks them."""
    if isinstance(value, Mapping):
        return {key: replace_non_finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [replace_non_finite(item) for item in value]
    if isinstance(value, float) and not -1e308 < value < 1e308:
        return None
    return value


def print_table(
    columns: Iterable[TextType], rows: Iterable[Sequence[TextType]], numbers: Container[str] = ()
) -> None:
    """Print a table to standard output with one-line cells.

    Columns in `numbers` are aligned right. In a narrow terminal, cells wrap, unless there are many
    rows.
    """
    console = output()
    head = list(columns)
    body = [[visible(cell) if isinstance(cell, str) else cell for cell in row] for row in rows]
    right = [str(name) in numbers for name in head]
    plain = [[cell for cell in row if isinstance(cell, str)] for row in (head, *body)]
    if all(len(row) == len(head) for row in plain):
        first, *others = _lines(plain, right)
        if cell_len(first) <= console.width or len(body) > MOST_WRAPPED:
            text = Text.assemble((first, "bold"), *(f"\n{line}" for line in others))
            console.print(text, soft_wrap=True)
            return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name, number in zip(head, right, strict=True):
        table.add_column(name, justify="right" if number else "left")
    for row in body:
        table.add_row(*row)
    console.print(table)


def _lines(rows: Sequence[Sequence[str]], right: Sequence[bool]) -> list[str]:
    """Return the lines of a table of plain cells.

    A row of six cells takes 0.04 ms; Rich's layout, for tables that may not fit, takes 0.4 ms.
    """
    widths = [max(map(cell_len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = []
        for cell, width, number in zip(row, widths, right, strict=True):
            space = " " * (width - cell_len(cell))
            cells.append(f"{space}{cell}" if number else f"{cell}{space}")
        lines.append("  ".join(cells).rstrip())
    return lines


def print_facts(facts: Mapping[str, Mapping[str, str]]) -> None:
    """Print facts about a body, by heading and name; long values wrap within their column."""
    console = output()
    for at, (heading, lines) in enumerate(facts.items()):
        if at:
            console.print()
        console.print(heading, style="bold")
        table = Table(box=None, pad_edge=False, show_header=False, padding=(0, 2, 0, 0))
        for name, value in lines.items():
            table.add_row(f"  {visible(name)}", *([visible(value)] if value else []))
        console.print(table)

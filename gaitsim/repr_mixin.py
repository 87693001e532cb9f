"""Representations of objects: lines or tables in Python and Rich, tables in notebooks."""

import html
from collections.abc import Iterator, Mapping, Sequence
from shutil import get_terminal_size
from typing import Generic, TypeVar, overload

ReprField = int | float | str | Mapping[str, float]


class ReprMixin:
    """A mixin that represents an object by named fields: numbers, texts and groups of numbers.

    Subclasses define `_repr_fields`. Fields equal to `''` or `{}` are omitted.
    """

    def _repr_fields(self) -> Mapping[str, ReprField]:
        """Return the fields by name, most important first."""
        raise NotImplementedError

    def _repr_details(self) -> Mapping[str, ReprField]:
        """Return the fields of the table, which may be more and slower to compute."""
        return self._repr_fields()

    def __repr__(self) -> str:
        # Groups would make the line too long to print in a loop.
        shown = [
            f"{name}={_short(field)}"
            for name, field in self._repr_fields().items()
            if field != "" and not isinstance(field, Mapping)
        ]
        return f"{type(self).__name__}({', '.join(shown)})"

    def __rich_repr__(self) -> Iterator[tuple[str, object]]:
        for name, field in self._repr_fields().items():
            if isinstance(field, Mapping) and field:
                yield name, {key: _rounded(value) for key, value in field.items()}
            elif field not in ("", {}):
                yield name, _rounded(field)

    def _repr_html_(self) -> str:
        rows = "".join(
            f'<tr><th style="text-align:left;vertical-align:top">{html.escape(name)}</th>'
            f'<td style="text-align:left">{_cell(field)}</td></tr>'
            for name, field in self._repr_details().items()
            if field not in ("", {})
        )
        return (
            f"<table><thead><tr><th colspan='2' style='text-align:left'>"
            f"{html.escape(type(self).__name__)}</th></tr></thead><tbody>{rows}</tbody></table>"
        )


class TableMixin:
    """A mixin that represents an object by a table, in Python as in notebooks.

    Subclasses define `_repr_title` and `_repr_rows`.
    """

    def _repr_title(self) -> str:
        """Return the line above the table."""
        raise NotImplementedError

    def _repr_rows(self) -> Sequence[Mapping[str, object]]:
        """Return the cells of each row by the name of the column."""
        raise NotImplementedError

    def __repr__(self) -> str:
        rows = self._repr_rows()
        columns = [[name, *(_plain(row[name]) for row in rows)] for name in (rows or [{}])[0]]
        widths = [max(map(len, column)) for column in columns]
        most = max(20, get_terminal_size().columns)
        lines = (
            "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
            for line in zip(*columns, strict=True)
        )
        shown = (line if len(line) <= most else f"{line[: most - 1]}…" for line in lines)
        return "\n".join([self._repr_title(), *shown])

    def _repr_html_(self) -> str:
        rows = self._repr_rows()
        head = "".join(f"<th>{html.escape(name)}</th>" for name in (rows or [{}])[0])
        body = "".join(
            f"<tr>{''.join(f'<td>{html.escape(_plain(cell))}</td>' for cell in row.values())}</tr>"
            for row in rows
        )
        title = f"<caption>{html.escape(self._repr_title())}</caption>"
        return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


_Item = TypeVar("_Item")


class Table(TableMixin, Sequence[_Item], Generic[_Item]):
    """A sequence that is shown as a table, with a row for each item.

    Args:
        title: what the items are.
        items: the items.
        rows: cells of each item by the name of the column.
    """

    def __init__(
        self, title: str, items: Sequence[_Item], rows: Sequence[Mapping[str, object]]
    ) -> None:
        self._title, self._items, self._rows = title, tuple(items), rows

    @overload
    def __getitem__(self, index: int) -> _Item: ...
    @overload
    def __getitem__(self, index: slice) -> "Table[_Item]": ...
    def __getitem__(self, index: int | slice) -> "_Item | Table[_Item]":
        if isinstance(index, slice):
            return Table(self._title, self._items[index], self._rows[index])
        return self._items[index]

    def __len__(self) -> int:
        return len(self._items)

    def _repr_title(self) -> str:
        return f"{self._title}: {len(self)}"

    def _repr_rows(self) -> Sequence[Mapping[str, object]]:
        return self._rows


def _plain(cell: object) -> str:
    if isinstance(cell, float):
        return f"{cell:.4g}"
    text = "" if cell is None else str(cell)
    return text if text.isprintable() else repr(text)[1:-1]


def _rounded(field: object) -> object:
    return float(f"{field:.4g}") if isinstance(field, float) else field


def _short(field: ReprField) -> str:
    return f"{field:.4g}" if isinstance(field, float) else repr(field)


def _cell(field: ReprField) -> str:
    if isinstance(field, Mapping):
        return "<br>".join(f"{html.escape(key)} {value:.4g}" for key, value in field.items())
    return f"{field:.4g}" if isinstance(field, float) else html.escape(str(field))

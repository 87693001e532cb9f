"""Representations of objects: one line in Python, fields in Rich, a table in notebooks."""

import html
from collections.abc import Iterator, Mapping

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


def _rounded(field: object) -> object:
    return float(f"{field:.4g}") if isinstance(field, float) else field


def _short(field: ReprField) -> str:
    return f"{field:.4g}" if isinstance(field, float) else repr(field)


def _cell(field: ReprField) -> str:
    if isinstance(field, Mapping):
        return "<br>".join(f"{html.escape(key)} {value:.4g}" for key, value in field.items())
    return f"{field:.4g}" if isinstance(field, float) else html.escape(str(field))

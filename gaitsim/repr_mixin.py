"""How objects show themselves: a line in Python, fields to Rich, a table in a notebook."""

import html
from collections.abc import Iterator, Mapping

ReprField = int | float | str | Mapping[str, float]


class ReprMixin:
    """Shown by facts: numbers and texts by name, and groups of numbers.

    A subclass says what they are in `_facts`. A fact that is `''` or `{}` is left out.
    """

    def _repr_fields(self) -> Mapping[str, ReprField]:
        """What is to be shown, by name, the most telling first."""
        raise NotImplementedError

    def _repr_details(self) -> Mapping[str, ReprField]:
        """What a table has room for; it may take longer to work out."""
        return self._repr_fields()

    def __repr__(self) -> str:
        # Groups would make the line too long to read in a loop that prints it.
        shown = [
            f"{name}={_short(fact)}"
            for name, fact in self._repr_fields().items()
            if fact != "" and not isinstance(fact, Mapping)
        ]
        return f"{type(self).__name__}({', '.join(shown)})"

    def __rich_repr__(self) -> Iterator[tuple[str, object]]:
        for name, fact in self._repr_fields().items():
            if isinstance(fact, Mapping) and fact:
                yield name, {key: _rounded(value) for key, value in fact.items()}
            elif fact not in ("", {}):
                yield name, _rounded(fact)

    def _repr_html_(self) -> str:
        rows = "".join(
            f'<tr><th style="text-align:left;vertical-align:top">{html.escape(name)}</th>'
            f'<td style="text-align:left">{_cell(fact)}</td></tr>'
            for name, fact in self._repr_details().items()
            if fact not in ("", {})
        )
        return (
            f"<table><thead><tr><th colspan='2' style='text-align:left'>"
            f"{html.escape(type(self).__name__)}</th></tr></thead><tbody>{rows}</tbody></table>"
        )


def _rounded(fact: object) -> object:
    return float(f"{fact:.4g}") if isinstance(fact, float) else fact


def _short(fact: ReprField) -> str:
    return f"{fact:.4g}" if isinstance(fact, float) else repr(fact)


def _cell(fact: ReprField) -> str:
    if isinstance(fact, Mapping):
        return "<br>".join(f"{html.escape(key)} {value:.4g}" for key, value in fact.items())
    return f"{fact:.4g}" if isinstance(fact, float) else html.escape(str(fact))

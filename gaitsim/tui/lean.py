"""What a terminal is sent: only the cells that differ, with as few bytes as they take.

The screen may be at the far end of an SSH connection. Textual sends a row of a widget from its
beginning where a cell of it changed, and Rich begins and ends both colours of each piece of text.
"""

import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

from rich.cells import cell_len
from textual.driver import Driver

_TOKEN = re.compile(
    r"\x1b\[(?P<row>\d+);(?P<column>\d+)H|\x1b\[(?P<style>[\d;]*)m|(?P<line>\r?\n)(?=\x1b\[\d+;\d+H)"
    r"|(?P<text>[^\x00-\x1f\x7f]+)|(?P<other>.)",
    re.DOTALL,
)
_UPDATE = re.compile(r"\x1b\[\?2026[hl]")  # the beginning or the end of a synchronised update
_COLOURS = {**dict.fromkeys([*range(30, 40), *range(90, 98)], "foreground"),
            **dict.fromkeys([*range(40, 50), *range(100, 108)], "background")}  # fmt: skip
_FOLLOWING = {"2": 3, "5": 1}  # parameters of a colour behind 38 or 48
_NARROW = re.compile("[ -~\u00a1-\u02ff\u2010-\u2027\u2190-\u2319\u2400-\u25fc\u2800-\u28ff]*")
GAP = 3  # unchanged cells that are sent rather than a move over them


class Pen(NamedTuple):
    """How a terminal writes: parameters of attributes and colours; '' is its own."""

    attributes: str = ""
    foreground: str = ""
    background: str = ""


PLAIN = Pen()
LOST = (-1, -1)
Cell = tuple[str, Pen]


class Mirror:
    """The cells that a terminal shows, as far as they are known.

    Attributes:
        sent: bytes so far.
    """

    def __init__(self) -> None:
        self.sent = 0
        self.forget()

    def forget(self) -> None:
        """Know no cell, as after the terminal was resized or cleared."""
        self._rows: dict[int, list[Cell | None]] = {}
        self._at = self._cursor = LOST  # where the terminal writes, and was left
        self._pen = PLAIN

    def reduce(self, data: str) -> str:
        """Return what shows the same, for a terminal whose styles are reset before and after."""
        reduced = data if _UPDATE.fullmatch(data) else "".join(self._reduced(data))
        self.sent += len(reduced.encode())
        return reduced

    def _reduced(self, data: str) -> Iterator[str]:
        tokens = [*_TOKEN.finditer(data)]
        lost = self._cursor == LOST and (not tokens or tokens[0]["row"] is None)
        if lost or any(token.lastgroup == "other" for token in tokens):
            self.forget()
            yield data
            return
        pen, at = PLAIN, self._cursor
        for token in tokens:
            if token["style"] is not None:
                pen = _after(pen, token["style"])
            elif token["row"] is not None:
                at = int(token["row"]), int(token["column"])
            elif token["text"] is not None:
                yield from self._write(at, token["text"], pen)
                at = at[0], _column(at, token["text"])
        yield self._take(PLAIN)
        yield self._move(at)
        self._cursor = at

    def _write(self, at: tuple[int, int], text: str, pen: Pen) -> Iterator[str]:
        """Yield what writes those characters that differ."""
        row, first = at
        shown = self._rows.setdefault(row, [])
        end = first + len(text)
        shown.extend([None] * (end - len(shown)))
        if not _NARROW.fullmatch(text):  # some take no column, or two
            del shown[max(first - 1, 0) :]
            yield self._move(at) + self._take(pen) + text
            self._at = row, _column(at, text)
            return
        space = " ", pen if pen.attributes else pen._replace(foreground="")  # it does not show
        cells: list[Cell | None] = [space if letter == " " else (letter, pen) for letter in text]
        before = shown[first:end]
        if before == cells:
            return
        shown[first:end] = cells
        changed = [index for index in range(len(cells)) if before[index] != cells[index]]
        start = changed[0]
        for index, following in zip(changed, [*changed[1:], end], strict=True):
            if following - index <= GAP and following != end:
                continue
            piece = text[start : index + 1]
            yield self._move((row, first + start))
            plain = not (piece.strip() or pen.attributes or self._pen.attributes)
            yield self._take(pen._replace(foreground=self._pen.foreground) if plain else pen)
            yield piece
            self._at = row, first + index + 1
            start = following

    def _move(self, place: tuple[int, int]) -> str:
        (row, column), before = place, self._at
        self._at = place
        if place == before:
            return ""
        if row == before[0] and column > before[1] >= 0:
            return f"\x1b[{column - before[1]}C"
        return f"\x1b[{row};{column}H"

    def _take(self, pen: Pen) -> str:
        """Return the sequence that changes the pen."""
        now = self._pen
        if pen == now:
            return ""
        self._pen = pen
        if pen == PLAIN:
            return "\x1b[0m"
        if now.attributes and now.attributes != pen.attributes:
            return f"\x1b[{';'.join(['0', *filter(None, pen)])}m"
        parts = [one for one, before in zip(pen, now, strict=True) if one and one != before]
        parts += ["39"] if now.foreground and not pen.foreground else []
        parts += ["49"] if now.background and not pen.background else []
        return f"\x1b[{';'.join(parts)}m"


def _column(at: tuple[int, int], text: str) -> int:
    """Return the column behind a text."""
    return at[1] + (len(text) if _NARROW.fullmatch(text) else cell_len(text))


@lru_cache(4096)
def _after(pen: Pen, style: str) -> Pen:
    """Return the pen after a sequence of parameters."""
    numbers = iter((style or "0").split(";"))
    for number in numbers:
        kind = _COLOURS.get(int(number or 0), "attributes")
        if number in ("", "0"):
            pen = PLAIN
        elif kind == "attributes":
            pen = pen._replace(attributes=f"{pen.attributes};{number}".strip(";"))
        elif number in ("39", "49"):
            pen = pen._replace(**{kind: ""})
        else:
            pen = pen._replace(**{kind: ";".join([number, *_colour(number, numbers)])})
    return pen


def _colour(number: str, numbers: Iterator[str]) -> list[str]:
    """Return the parameters that belong to a colour."""
    if number not in ("38", "48"):
        return []
    how = next(numbers, "")
    return [how, *(next(numbers, "") for _ in range(_FOLLOWING.get(how, 0)))]


def lean(driver: type[Driver], mirror: Mirror) -> type[Driver]:
    """Return a driver that sends only what differs from a mirror of its terminal."""

    class LeanDriver(driver):  # type: ignore[misc, valid-type]
        def write(self, data: str) -> Any:
            return super().write(mirror.reduce(data))

    return LeanDriver

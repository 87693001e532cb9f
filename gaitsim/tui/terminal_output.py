"""Output to the terminal: readable text, no control characters of others, only changed cells.

The terminal may be at the far end of an SSH connection. Textual resends a whole row of a widget
when one cell changes, and Rich sets and resets both colours of each piece of text. Sending only
changed cells, in as few bytes as possible, takes a fifth of the bytes for a moving body.
"""

import re
import unicodedata
from collections import defaultdict
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

from rich.cells import cell_len
from rich.color import Color as RichColor
from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.driver import Driver
from textual.filter import LineFilter

from gaitsim.render.terminal.text import STEERING

_UPDATE = re.compile(r"\x1b\[\?2026[hl]")  # start or end of a synchronised update
_MOVE = re.compile(r"\x1b\[(\d+);(\d+)H")
_PIECE = re.compile(r"((?:\x1b\[[\d;]*m)*)([^\x00-\x1f]*)")  # styles, and a text with these styles
# Pieces and moves, with or without a line break before each move.
_KNOWN = re.compile(
    r"(?:[^\x00-\x1f\x7f]++|\x1b\[(?:[\d;]*+m|\d++;\d++H)|\r?\n(?=\x1b\[\d+;\d+H))*+"
)
_NARROW = re.compile(
    "[\r\n\x1b -~\u00a1-\u02ff\u2010-\u2027\u2190-\u2319\u2400-\u25fc\u2800-\u28ff]*"
)
_COLOURS = {**dict.fromkeys([*range(30, 40), *range(90, 98)], "foreground"),
            **dict.fromkeys([*range(40, 50), *range(100, 108)], "background")}  # fmt: skip
_FOLLOWING = {"2": 3, "5": 1}  # parameters of a colour after 38 or 48
GAP = 4  # bytes of unchanged cells that are resent instead of moving over them


class ControlCharacterFilter(LineFilter):
    r"""Removes control characters from each drawn line.

    Most widgets already escape them with `visible`, such as to `\x1b`; this covers the rest.
    """

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Return the segments with unchanged widths."""
        if "".join([segment.text for segment in segments]).isprintable():
            return segments
        return [segment._replace(text=_without_controls(segment.text)) for segment in segments]


def _without_controls(text: str) -> str:
    return "".join(
        "\N{REPLACEMENT CHARACTER}" * cell_len(char)
        if unicodedata.category(char) in STEERING
        else char
        for char in text
    )


CONTRAST = 4.5  # minimum ratio of text and its background (WCAG 2.1, level AA)
_DIM = 0.6  # share of the foreground in dim text
_DRAWING = re.compile(r"[\s\u2500-\u259f\u2800-\u28ff]*")  # lines, blocks and braille dots
_PLAIN = Style(dim=False)


class ContrastFilter(LineFilter):
    """Raises the contrast of text with its background to `CONTRAST`, in every theme.

    Dim text gets an explicit colour, because each terminal dims differently.
    """

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Return the segments; those that are text have readable colours."""
        return [
            segment
            if segment.style is None or _DRAWING.fullmatch(segment.text)
            else Segment(segment.text, _readable(segment.style, background), segment.control)
            for segment in segments
        ]


@lru_cache(4096)
def _readable(style: Style, background: Color) -> Style:
    fore, back = style.color, style.bgcolor
    if fore is None or fore.triplet is None:  # a colour of the terminal
        return style
    ground = background if back is None or back.triplet is None else Color.from_rich_color(back)
    colour = Color.from_rich_color(fore)
    if style.dim:
        colour = ground.blend(colour, _DIM)
    legible = raise_contrast(colour.rgb, ground.rgb)
    return style + Style(color=RichColor.from_rgb(*legible)) + _PLAIN


def raise_contrast(colour: tuple[int, ...], ground: tuple[int, ...]) -> tuple[int, ...]:
    """Return the colour closest to `colour` with enough contrast, lighter or else darker.

    Args:
        colour: red, green and blue of a text, each 0 to 255.
        ground: those of its background.
    """
    if contrast(colour, ground) >= CONTRAST:
        return colour
    lighter = luminance(colour) >= luminance(ground)
    ends = [(255, 255, 255), (0, 0, 0)] if lighter else [(0, 0, 0), (255, 255, 255)]
    end = next(one for one in ends if contrast(one, ground) >= CONTRAST)
    for percent in range(1, 101):
        mixed = tuple(round(a + (b - a) * percent / 100) for a, b in zip(colour, end, strict=True))
        if contrast(mixed, ground) >= CONTRAST:
            return mixed
    return end


def contrast(one: tuple[int, ...], other: tuple[int, ...]) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2.1)."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def luminance(colour: tuple[int, ...]) -> float:
    """Return the relative luminance of red, green and blue from 0 to 255 (WCAG 2.1)."""
    parts = (part / 255 for part in colour)
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
              for part in parts]  # fmt: skip
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


class Pen(NamedTuple):
    """Current style of a terminal: parameters of attributes and colours; '' is the default."""

    attributes: str = ""
    background: str = ""
    foreground: str = ""


PLAIN = Pen()
LOST = (-1, -1)  # unknown position of the cursor
Cell = tuple[str, Pen]
Run = tuple[int, int, str]  # the row and column at which a text starts, and the text


class TerminalMirror:
    """The known cells of a terminal.

    Attributes:
        sent: number of bytes sent so far.
    """

    def __init__(self) -> None:
        self.sent = 0
        self._columns: int | None = None
        self.forget()

    def resize(self, columns: int) -> None:
        """Forget all cells; omit text beyond the new width.

        Until the screen has its new size, widgets are drawn where they were. A terminal would draw
        their text beyond its edge in its last column.
        """
        self._columns = columns
        self.forget()

    def forget(self) -> None:
        """Forget all cells, such as after the terminal is cleared."""
        self._rows: dict[int, list[Cell | None]] = {}
        self._at = LOST  # row and column of the terminal's cursor
        self._pen = PLAIN

    def reduce(self, data: str) -> str:
        """Return shorter output with the same effect; styles are reset before and after."""
        reduced = data if _UPDATE.fullmatch(data) else "".join(self._reduced(data))
        self.sent += len(reduced.encode())
        return reduced

    def _reduced(self, data: str) -> Iterator[str]:
        head, *parts = _MOVE.split(data)
        if head or not _KNOWN.fullmatch(data):
            self.forget()
            yield data
            return
        pen, row, column = PLAIN, *LOST
        runs: defaultdict[Pen, list[Run]] = defaultdict(list)
        ends: dict[int, int] = {}  # end of the text written in each row
        for down, right, body in zip(parts[::3], parts[1::3], parts[2::3], strict=True):
            row, column = int(down), int(right)
            narrow = _NARROW.fullmatch(body) is not None
            if not narrow or column < ends.get(row, 0):  # overwrites cells that are not sent yet
                yield from self._send(runs)
                runs.clear()
            if not narrow:  # some characters are 0 or 2 columns wide
                self._rows.pop(row, None)
                yield self._move((row, column)) + self._change_pen(pen) + body.rstrip("\r\n")
                self._at = row, column = LOST
            for styles, text in _PIECE.findall(body):
                pen = _after(pen, styles) if styles else pen
                if narrow and text:
                    self._compare(row, column, text, pen, runs)
                    column += len(text)
            self._pen = self._pen if narrow else pen
            ends[row] = column
        yield from self._send(runs)
        yield self._change_pen(PLAIN)
        if (row, column) != LOST:
            yield self._move((row, column))

    def _compare(
        self, row: int, first: int, text: str, pen: Pen, runs: defaultdict[Pen, list[Run]]
    ) -> None:
        """Add the characters that differ to the runs of their pen."""
        if self._columns is not None:
            text = text[: max(0, self._columns + 1 - first)]
        shown = self._rows.setdefault(row, [])
        end = first + len(text)
        if len(shown) < end:
            shown.extend([None] * (end - len(shown)))
        space = " ", _blank(pen)
        cells: list[Cell | None] = [space if letter == " " else (letter, pen) for letter in text]
        before = shown[first:end]
        if before == cells:
            return
        shown[first:end] = cells
        changed = [index for index in range(len(cells)) if before[index] != cells[index]]
        start, last = changed[0], changed[0]
        for index in [*changed[1:], -1]:
            if index - last == 1 or (index > 0 and len(text[last + 1 : index].encode()) <= GAP):
                last = index
                continue
            piece = text[start : last + 1]
            runs[space[1] if piece.isspace() else pen].append((row, first + start, piece))
            start = last = index

    def _send(self, runs: dict[Pen, list[Run]]) -> Iterator[str]:
        """Yield the output of the runs, grouped by pen, as a move is shorter than a colour."""
        for pen, following in pairwise([*sorted(runs), PLAIN]):
            blank = not pen.attributes and all(text.isspace() for _, _, text in runs[pen])
            if blank and following[:2] == pen[:2] and pen != following in runs:
                runs[following] = sorted([*runs[pen], *runs[following]])  # blanks fit any colour
                continue
            for row, column, text in runs[pen]:
                yield self._move((row, column)) + self._change_pen(pen) + text
                self._at = row, column + len(text)

    def _move(self, place: tuple[int, int]) -> str:
        (row, column), before = place, self._at
        self._at = place
        if place == before:
            return ""
        if row == before[0] and column > before[1] >= 0:
            return f"\x1b[{column - before[1]}C"
        return f"\x1b[{row};{column}H"

    def _change_pen(self, pen: Pen) -> str:
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


@lru_cache(4096)
def _blank(pen: Pen) -> Pen:
    """Return the pen of a space, whose foreground is invisible unless underlined."""
    return pen if pen.attributes else pen._replace(foreground="")


@lru_cache(4096)
def _after(pen: Pen, styles: str) -> Pen:
    """Return the pen after sequences of parameters."""
    numbers = iter(";".join(one or "0" for one in re.findall(r"\[([\d;]*)m", styles)).split(";"))
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


def mirroring_driver(driver: type[Driver], mirror: TerminalMirror) -> type[Driver]:
    """Return a driver that sends only the differences from a mirror of its terminal."""

    class MirroringDriver(driver):  # type: ignore[misc, valid-type]
        def write(self, data: str) -> Any:
            return super().write(mirror.reduce(data))

    return MirroringDriver

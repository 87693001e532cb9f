"""Filters of each line before it is drawn: readable text without control characters."""

import re
import unicodedata
from functools import lru_cache

from rich.cells import cell_len
from rich.color import Color as RichColor
from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.filter import LineFilter

from gaitsim.render.terminal.text import STEERING


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

"""A filter that prevents untrusted text from controlling the terminal, in every widget."""

import unicodedata

from rich.cells import cell_len
from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

from gaitsim.render.terminal.text import STEERING


class PlainText(LineFilter):
    r"""Removes control characters from each drawn line.

    Most widgets already escape them with `visible`, such as to `\x1b`; this covers the rest.
    """

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Return the segments with unchanged widths."""
        if "".join([segment.text for segment in segments]).isprintable():
            return segments
        return [segment._replace(text=_plain(segment.text)) for segment in segments]


def _plain(text: str) -> str:
    return "".join(
        "\N{REPLACEMENT CHARACTER}" * cell_len(char)
        if unicodedata.category(char) in STEERING
        else char
        for char in text
    )

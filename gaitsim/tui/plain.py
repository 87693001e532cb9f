"""Keep texts of others from steering the terminal, whichever widget shows them."""

import unicodedata

from rich.cells import cell_len
from rich.segment import Segment
from textual.color import Color
from textual.filter import LineFilter

from gaitsim.render.terminal.text import STEERING


class PlainText(LineFilter):
    r"""Removes control characters from each line that is drawn.

    Most widgets show them as `\x1b`, by `visible`. This holds for all of them.
    """

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        """Return the segments, each as wide as before."""
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

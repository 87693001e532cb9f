"""Reduced output to a terminal, which shows the same as the full output."""

import re

from hypothesis import given, strategies as st
from rich.cells import cell_len

from gaitsim.tui.terminal_output import TerminalMirror

COLUMNS, ROWS = 12, 4


class Terminal:
    """A terminal that understands Textual's output: moves, styles and text."""

    def __init__(self):
        self.cells = {}
        self.at = 1, 1
        self.style = {}

    def write(self, data):
        for move, right, style, text in re.findall(
            r"\x1b\[(\d+;\d+)H|\x1b\[(\d+)C|\x1b\[([\d;]*)m|([^\x1b\n]+)", data
        ):
            row, column = self.at
            if move:
                self.at = tuple(map(int, move.split(";")))
            elif right:
                self.at = row, column + int(right)
            elif text:
                for letter in text:
                    width = cell_len(letter)
                    self.cells[row, column] = letter, self._visible_style(letter)
                    for beyond in range(1, width):
                        self.cells[row, column + beyond] = "", None
                    column += width
                self.at = row, column
            else:
                self._restyle(style or "0")

    def _visible_style(self, letter):
        hidden = letter == " " and not self.style.get("attributes")
        return tuple(
            sorted(
                (kind, value) for kind, value in self.style.items() if kind != "fg" or not hidden
            )
        )

    def _restyle(self, style):
        parts = style.split(";")
        while parts:
            one = parts.pop(0)
            if one == "0":
                self.style = {}
            elif one in ("38", "48"):
                count = 4 if parts[0] == "2" else 2
                kind = "fg" if one == "38" else "bg"
                self.style[kind], parts = (one, *parts[:count]), parts[count:]
            elif one in ("39", "49"):
                self.style.pop("fg" if one == "39" else "bg", None)
            elif 30 <= int(one) < 50:
                self.style["fg" if int(one) < 40 else "bg"] = one
            else:
                self.style["attributes"] = (*self.style.get("attributes", ()), one)


styles = st.sampled_from(
    ["", "1", "4", "31", "38;2;1;2;3", "38;2;1;2;3;48;2;9;9;9", "1;38;5;7;48;2;9;9;9", "48;5;3"]
)
texts = st.text(st.sampled_from("ab  ⢠●宽★"), min_size=1, max_size=8)
moves = st.tuples(st.integers(1, ROWS), st.integers(1, COLUMNS))
updates = st.lists(
    st.tuples(moves, st.lists(st.tuples(styles, texts), min_size=1, max_size=4)), max_size=5
)


def written(update):
    """Return an update as Textual and Rich write it."""
    pieces = []
    for (row, column), texts in update:
        styled = (f"\x1b[{style}m{text}\x1b[0m" if style else text for style, text in texts)
        pieces.append(f"\x1b[{row};{column}H" + "".join(styled))
    return "\n".join([*pieces, "\x1b[1;1H"])


@given(st.lists(updates, min_size=1, max_size=5), st.integers(0, 5))
def test_the_terminal_shows_the_same(updates, resized):
    mirror, full, reduced = TerminalMirror(), Terminal(), Terminal()
    for number, update in enumerate(updates):
        if number == resized:
            mirror.forget()
        full.write(written(update))
        reduced.write(mirror.reduce(written(update)))
        assert reduced.cells == full.cells
        assert reduced.at == full.at
        assert reduced.style == {}
        again = mirror.reduce(written(update))
        if len(update) < 2 and written(update).isascii():  # no cell is written twice
            assert again == ""


def test_only_differences_are_sent():
    mirror = TerminalMirror()
    plain, red = "\x1b[38;2;9;9;9m", "\x1b[38;2;200;0;0m"
    mirror.reduce(f"\x1b[3;1H{plain}generation 99  \x1b[0m{red}●\x1b[0m\x1b[1;1H")
    sent = mirror.reduce(f"\x1b[3;1H{plain}generation 100 \x1b[0m{red}●\x1b[0m\x1b[1;1H")
    assert sent == f"\x1b[3;12H{plain}100\x1b[0m\x1b[1;1H"
    assert mirror.sent > len(sent)


def test_everything_is_sent_after_an_unknown_sequence():
    mirror, update = TerminalMirror(), "\x1b[1;1Hwalk\x1b[2;1H"
    mirror.reduce(update)
    assert mirror.reduce("\x1b[?2026h") == "\x1b[?2026h"
    assert mirror.reduce(update) == ""
    assert mirror.reduce("\x1b[2J") == "\x1b[2J"
    assert mirror.reduce("walk") == "walk"
    assert mirror.reduce(update) == update


@given(st.lists(updates, min_size=1, max_size=5), st.integers(1, COLUMNS - 1))
def test_nothing_is_written_beyond_a_narrower_terminal(updates, columns):
    mirror, terminal = TerminalMirror(), Terminal()
    mirror.resize(columns)
    for update in updates:
        data = written(update)
        if not data.isascii():  # wide characters are written as they are
            continue
        terminal.write(mirror.reduce(data))
        assert all(column <= columns for _, column in terminal.cells)


def test_a_frame_at_the_old_width_leaves_no_dots_in_the_last_column():
    mirror = TerminalMirror()
    mirror.reduce("\x1b[1;1H\u28ff\u28ff\u28ff\u28ff\x1b[1;1H")
    mirror.resize(2)
    assert mirror.reduce("\x1b[1;3H\u28ff\u28ff\x1b[1;1H") == "\x1b[1;1H"  # still the old layout
    assert mirror.reduce("\x1b[1;1H  \x1b[1;1H") == "  \x1b[1;1H"

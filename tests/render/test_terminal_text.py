"""Characters that could control a terminal are escaped."""

import pytest

from gaitsim.render.terminal.text import visible, visible_lines


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("α − β", "α − β"),
        ("\x1b[31mred", "\\x1b[31mred"),
        ("a\u202eb", "a\\u202eb"),
        ("file\udcff", "file\\udcff"),
        ("one\r\ntwo", "one\\r\\ntwo"),
    ],
)
def test_control_characters_are_escaped(text, shown):
    assert visible(text) == shown


def test_line_breaks_are_kept():
    assert visible_lines("one\x07\n\ntwo\n") == "one\\x07\n\ntwo\n"

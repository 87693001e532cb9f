"""Text of others is shown without what steers a terminal."""

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


def test_lines_stay_lines():
    assert visible_lines("one\x07\n\ntwo\n") == "one\\x07\n\ntwo\n"

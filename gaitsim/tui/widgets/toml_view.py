"""An experiment file, its sections and comments told apart."""

import re

from rich.text import Text

_SECTION = re.compile(r"\[\w+\]$")
_KEY = re.compile(r"\w+(?= = )")
# A comment after a value; a text in quotes that holds ' # ' is coloured too early, no more.
_COMMENT = re.compile(r"(^| )# .*$")


def coloured(toml: str, section: str, key: str) -> Text:
    """The text with its sections and keys in these colours, comments dim."""
    whole = Text(no_wrap=True)
    for line in toml.splitlines():
        text = Text(line)
        if _SECTION.match(line):
            text.stylize(f"bold {section}")
        else:
            text.highlight_regex(_KEY, style=key)
            text.highlight_regex(_COMMENT, style="dim")
        whole.append_text(text).append("\n")
    return whole

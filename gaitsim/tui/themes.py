"""The themes that gaitsim adds to Textual's, and colours by their names in a theme."""

from collections.abc import Mapping
from typing import Any

from rich.style import Style
from textual.color import Color
from textual.theme import BUILTIN_THEMES, Theme

from gaitsim.errors import unknown


def _theme(name: str, *, border: str, cursor: str = "", **colours: Any) -> Theme:
    """Return a theme with borders in the primary colour and keys in the accent colour.

    Args:
        name: name of the theme.
        border: colour of borders without the focus.
        cursor: colour of text under the cursor in a light theme; '' makes the theme dark.
        colours: other colours of the theme.
    """
    variables = {
        "footer-key-foreground": colours["accent"],
        "block-cursor-foreground": cursor or colours["background"],
        "border": colours["primary"],
        "border-blurred": border,
    }
    if not cursor:
        variables["block-cursor-text-style"] = "bold"
    return Theme(name=name, dark=not cursor, variables=variables, **colours)


DARK = _theme(
    "gaitsim-dark",
    primary="#4DB6AC", secondary="#7E9CD8", accent="#F2B84B",
    warning="#F2B84B", error="#EE6D75", success="#8BC97A",
    foreground="#D7DEE6", background="#0F151B", surface="#151D25", panel="#1E2933",
    border="#2B3946",
)  # fmt: skip

LIGHT = _theme(
    "gaitsim-light",
    primary="#00796B", secondary="#3B5BA5", accent="#A55D00",
    warning="#A55D00", error="#B3261E", success="#2E7D32",
    foreground="#1C242B", background="#F7F8F6", surface="#ECEFEC", panel="#DDE3E0",
    border="#C2CBC7", cursor="#FFFFFF",
)  # fmt: skip

# Okabe & Ito (2008): eight colours that people with any colour vision can distinguish.
OKABE_ITO = _theme(
    "gaitsim-okabe-ito",
    primary="#56B4E9", secondary="#CC79A7", accent="#F0E442",
    warning="#E69F00", error="#D55E00", success="#009E73",
    foreground="#F2F2F2", background="#000000", surface="#101418", panel="#1C2228",
    border="#3A4650",
)  # fmt: skip

INKS = ("primary", "secondary", "accent", "warning", "error", "success", "foreground")
"""Variables of a theme that texts use as styles, such as `$error`, resolved when drawn."""


def ink_styles(variables: Mapping[str, str]) -> dict[str, Style]:
    """Return the styles of a theme that `INKS` names, alone or after 'bold'."""
    styles = {}
    for name in INKS:
        colour = Color.parse(variables[name]).rich_color
        styles[f"${name}"] = Style(color=colour)
        styles[f"bold ${name}"] = Style(color=colour, bold=True)
    return styles


THEMES = (DARK, LIGHT, OKABE_ITO)
DEFAULT = DARK.name


def is_ours(name: str) -> bool:
    """Return whether gaitsim adds the theme."""
    return name.startswith("gaitsim-")


def check_theme(name: str, *, where: str, key: str = "") -> str:
    """Check and return the name of a theme."""
    known = sorted([*(ours.name for ours in THEMES), *BUILTIN_THEMES])
    if name not in known:
        raise unknown("theme", name, known, where=where, key=key)
    return name

"""The app's own themes, beside those that Textual brings."""

from textual.theme import BUILTIN_THEMES, Theme

from gaitsim.errors import unknown

DARK = Theme(
    name="gaitsim-dark",
    primary="#4DB6AC",
    secondary="#7E9CD8",
    accent="#F2B84B",
    warning="#F2B84B",
    error="#EE6D75",
    success="#8BC97A",
    foreground="#D7DEE6",
    background="#0F151B",
    surface="#151D25",
    panel="#1E2933",
    variables={
        "footer-key-foreground": "#F2B84B",
        "block-cursor-foreground": "#0F151B",
        "block-cursor-text-style": "bold",
        "border": "#4DB6AC",
        "border-blurred": "#2B3946",
    },
)

LIGHT = Theme(
    name="gaitsim-light",
    primary="#00796B",
    secondary="#3B5BA5",
    accent="#A55D00",
    warning="#A55D00",
    error="#B3261E",
    success="#2E7D32",
    foreground="#1C242B",
    background="#F7F8F6",
    surface="#ECEFEC",
    panel="#DDE3E0",
    dark=False,
    variables={
        "footer-key-foreground": "#A55D00",
        "block-cursor-foreground": "#FFFFFF",
        "border": "#00796B",
        "border-blurred": "#C2CBC7",
    },
)

# Okabe & Ito (2008): eight colours that people with any colour vision tell apart.
OKABE_ITO = Theme(
    name="gaitsim-okabe-ito",
    primary="#56B4E9",
    secondary="#CC79A7",
    accent="#F0E442",
    warning="#E69F00",
    error="#D55E00",
    success="#009E73",
    foreground="#F2F2F2",
    background="#000000",
    surface="#101418",
    panel="#1C2228",
    variables={
        "footer-key-foreground": "#F0E442",
        "block-cursor-foreground": "#000000",
        "block-cursor-text-style": "bold",
        "border": "#56B4E9",
        "border-blurred": "#3A4650",
    },
)

THEMES = (DARK, LIGHT, OKABE_ITO)
DEFAULT = DARK.name


def check_theme(name: str, *, where: str, key: str = "") -> str:
    """Return the name of a theme.

    Raises:
        GaitsimError: there is no such theme.
    """
    known = sorted([*(ours.name for ours in THEMES), *BUILTIN_THEMES])
    if name not in known:
        raise unknown("theme", name, known, where=where, key=key)
    return name

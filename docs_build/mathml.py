"""Equations for the site: convert ```math blocks to MathML, which browsers draw natively."""

import re
from typing import Any

import font
from latex2mathml.converter import convert
from pymdownx.superfences import SuperFencesException

NARROW = '<mspace width="0.17em"></mspace>'
NAME = "(?<!<msub>)<m[io]>(sin|cos|tanh|clip|rms|arg|min)</m[io]>"
SIGN = "<m[io]>([−±∓])</m[io]>"
CORRECTIONS = (
    # A bar as wide as the expression below it, and dots close to their letter.
    ('<mo accent="true">―', '<mo stretchy="true">‾'),
    ("<mover>(<mi>.</mi>|<mrow><mi>.</mi></mrow>)<mo>", r'<mover accent="true">\1<mo>'),
    ("<mi>~</mi>", "<mo>∼</mo>"),
    # Space on both sides of a function name, except before "(".
    (f"{NAME}(?!<mo)", rf"{NARROW}<mi>\1</mi>{NARROW}"),
    (f"{NAME}(?=<mo)", rf"{NARROW}<mi>\1</mi>"),
    # The variable of a minimum is set below "min".
    ("<msub><mo>min</mo>(.*?)</msub>", rf"<munder><mi>min</mi>\1</munder>{NARROW}"),
    # A sign without a left operand is a prefix.
    (
        rf"(<mo[^>]*>[(\[=,←]</mo>(?:<mspace[^>]*>)?|<mrow>|<mtd>){SIGN}",
        r'\1<mo form="prefix" lspace="0" rspace="0">\2</mo>',
    ),
    (SIGN, r"<mo>\1</mo>"),
    ("<mo>=</mo></mtd>", '<mo form="infix">=</mo></mtd>'),
    ('<mo stretchy="false">[|]', '<mo stretchy="false" lspace="0" rspace="0">|'),
)
"""Pairs of a pattern and its replacement, for MathML that browsers space or stretch badly."""


def block(
    source: str, language: str, css_class: str, options: dict[str, Any], md: Any, **more: Any
) -> str:
    """Return the HTML of a fenced block of LaTeX; a formatter for pymdownx.superfences.

    Raises:
        SuperFencesException: the LaTeX cannot be converted, or needs a character outside the font.
    """
    mathml = convert(source, display="block")
    mathml = re.sub("&#x(?!0003C|0003E|00026)(.{5});", lambda code: chr(int(code[1], 16)), mathml)
    for pattern, replacement in CORRECTIONS:
        mathml = re.sub(pattern, replacement, mathml)
    if "\\" in mathml:
        # After any other exception, the block would silently be shown as code.
        raise SuperFencesException(f"unsupported LaTeX: {source}")
    if missing := font.missing_characters(mathml):
        raise SuperFencesException(
            f"characters missing in the font (see docs_build/font.py): {missing} in {source}"
        )
    return f'<div class="equation">{mathml}</div>'

"""Equations for the site: ```math blocks become MathML, which browsers draw by themselves."""

import re
from typing import Any

import font
from latex2mathml.converter import convert
from pymdownx.superfences import SuperFencesException

NARROW = '<mspace width="0.17em"></mspace>'
NAME = "(?<!<msub>)<m[io]>(sin|cos|tanh|clip|rms|arg|min)</m[io]>"
SIGN = "<m[io]>([−±∓])</m[io]>"
BETTER = (
    # A bar that grows with what is below it, and dots that are near their letter.
    ('<mo accent="true">―', '<mo stretchy="true">‾'),
    ("<mover>(<mi>.</mi>|<mrow><mi>.</mi></mrow>)<mo>", r'<mover accent="true">\1<mo>'),
    ("<mi>~</mi>", "<mo>∼</mo>"),
    # A factor, a function and a variable have space between them, a function and "(" none.
    (f"{NAME}(?!<mo)", rf"{NARROW}<mi>\1</mi>{NARROW}"),
    (f"{NAME}(?=<mo)", rf"{NARROW}<mi>\1</mi>"),
    # What minimises stands below.
    ("<msub><mo>min</mo>(.*?)</msub>", rf"<munder><mi>min</mi>\1</munder>{NARROW}"),
    # A sign belongs to what is after it, where nothing is before it that it could follow.
    (
        rf"(<mo[^>]*>[(\[=,←]</mo>(?:<mspace[^>]*>)?|<mrow>|<mtd>){SIGN}",
        r'\1<mo form="prefix" lspace="0" rspace="0">\2</mo>',
    ),
    (SIGN, r"<mo>\1</mo>"),
    ("<mo>=</mo></mtd>", '<mo form="infix">=</mo></mtd>'),
    ('<mo stretchy="false">[|]', '<mo stretchy="false" lspace="0" rspace="0">|'),
)
"""What browsers would draw otherwise than a typesetter does, and what they draw as it does."""


def block(
    source: str, language: str, css_class: str, options: dict[str, Any], md: Any, **more: Any
) -> str:
    """The HTML of a fenced block that holds LaTeX; as Python-Markdown asks for it."""
    made = convert(source, display="block")
    made = re.sub("&#x(?!0003C|0003E|00026)(.{5});", lambda code: chr(int(code[1], 16)), made)
    for pattern, replacement in BETTER:
        made = re.sub(pattern, replacement, made)
    if "\\" in made:
        # Of other errors there would only be a block of code where the equation should be.
        raise SuperFencesException(f"LaTeX that cannot be set: {source}")
    if missing := font.missing(made):
        raise SuperFencesException(f"not in the font of docs_build/font.py: {missing} in {source}")
    return f'<div class="equation">{made}</div>'

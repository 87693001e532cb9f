"""Equations for the site: ```math blocks become MathML, which browsers draw by themselves."""

import re
from typing import Any

from latex2mathml.converter import convert
from pymdownx.superfences import SuperFencesException

FUNCTION = re.compile(r"<mi>(sin|cos|tanh)</mi>")
BAR = '<mo stretchy="false">&#x0007C;</mo>'


def block(
    source: str, language: str, css_class: str, options: dict[str, Any], md: Any, **more: Any
) -> str:
    """The HTML of a fenced block that holds LaTeX; as Python-Markdown asks for it."""
    made = convert(source, display="block")
    # Browsers set a factor and the function after it without a space between them.
    made = FUNCTION.sub(r'<mspace width="0.17em"></mspace><mi>\1</mi>', made)
    made = made.replace(BAR, BAR.replace("<mo ", '<mo lspace="0" rspace="0" '))
    if "\\" in made:
        # Of other errors there would only be a block of code where the equation should be.
        raise SuperFencesException(f"LaTeX that cannot be set: {source}")
    return f'<div class="equation">{made}</div>'

"""Subset the font of the equations: `python docs_build/font.py FONT.woff`.

The input is `files/stix-two-math-latin-400-normal.woff` of the npm package
`@fontsource/stix-two-math` 5.3.0. The output, docs_build/fonts/stix-two-math.woff, keeps letters,
Greek, operators, arrows, mathematical alphabets, and brackets in all sizes, with the pieces of
which larger brackets are composed. The same input gives the same glyphs, so the file is
reproducible.
"""

import html
import re
import sys
import unicodedata
from functools import cache
from pathlib import Path

from fontTools.subset import Options, Subsetter
from fontTools.ttLib import TTFont

FONT = Path(__file__).parent / "fonts" / "stix-two-math.woff"
KEPT = (
    (0x20, 0x17F),  # Latin
    (0x2C6, 0x338),  # accents
    (0x370, 0x3FF),  # Greek
    (0x2010, 0x205F),  # punctuation and spaces
    (0x20D0, 0x20DC),  # accents of symbols, such as three dots
    (0x2100, 0x214F),  # letterlike: ℎ, ℝ
    (0x2190, 0x21FF),  # arrows
    (0x2200, 0x22FF),  # operators
    (0x2308, 0x230B),  # floor and ceiling
    (0x23B4, 0x23E1),  # braces above and below
    (0x27C2, 0x27FF),  # brackets, long arrows
    (0x2A00, 0x2A0C),  # large operators
    (0x1D400, 0x1D4CF),  # bold, italic and script letters
    (0x1D538, 0x1D56B),  # double-struck letters: ℂ
    (0x1D6A4, 0x1D6E1),  # dotless letters, bold Greek
    (0x1D6E2, 0x1D71B),  # italic Greek
)
LETTER = re.compile(r"<mi>(.)</mi>")
ITALIC = {"h": "ℎ"} | {
    chr(int(unicodedata.decomposition(chr(code)).split()[1], 16)): chr(code)
    for code in (*range(0x1D434, 0x1D468), *range(0x1D6E2, 0x1D71C))
    if unicodedata.decomposition(chr(code))
}
"""Letter of a variable -> italic character that browsers draw for it."""


def write_subset(source: Path) -> None:
    """Write the subset of a font that the site needs."""
    font = TTFont(source, recalcTimestamp=False)
    # `ssty` selects the glyphs of subscripts and superscripts; the other features place accents.
    options = Options(layout_features=["ssty", "mkmk", "ccmp"], hinting=False, notdef_outline=True)
    subsetter = Subsetter(options)
    subsetter.populate(unicodes=[one for first, last in KEPT for one in range(first, last + 1)])
    subsetter.subset(font)
    font.flavor = "woff"
    font.save(FONT)


def missing_characters(mathml: str) -> str:
    """Return the characters of an equation in MathML that the font lacks."""
    text = LETTER.sub(lambda found: ITALIC.get(found[1], found[1]), mathml)
    drawn = set(html.unescape(re.sub(r"<[^>]*>|\s", "", text)))
    return "".join(sorted(drawn - set(map(chr, code_points()))))


@cache
def code_points() -> frozenset[int]:
    """Return the code points in the subset."""
    with TTFont(FONT) as font:
        return frozenset(font.getBestCmap())


if __name__ == "__main__":
    write_subset(Path(sys.argv[1]))

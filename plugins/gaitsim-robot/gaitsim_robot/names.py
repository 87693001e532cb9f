"""Read the names of a limb's joints and links: its place on the trunk, or a limb such as a wing."""

import re
import unicodedata
from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gaitsim_robot.anatomy import Floats

# Words without accents: front; middle; rear; left; right.
WORDS = (
    "front fore anterior; middle mid center centre; rear hind back posterior; left; right",
    "vorne vorn vorder vordere vorderer vorderes; mitte mittel mittlere mittleres; "
    "hinten hinter hintere hinterer hinteres; links linke linker linkes; "
    "rechts rechte rechter rechtes",
    "avant; milieu; arriere; gauche; droite droit",
    "delantera delantero; media medio central; trasera trasero; izquierda izquierdo izq; "
    "derecha derecho der",
    "anteriore; centrale; posteriore; sinistra sinistro sx; destra destro dx",
    "dianteira dianteiro; meio; traseira traseiro; esquerda esquerdo esq; direita direito dir",
    "przod przedni przednia przednie; srodek srodkowy srodkowa srodkowe; "
    "tyl tylny tylna tylne; lewy lewa lewe; prawy prawa prawe",
    "mae; naka; ushiro; hidari; migi",
    "qian; zhong; hou; zuo; you",
)
"""Words of English, German, French, Spanish, Italian, Portuguese, Polish, Japanese and Chinese."""

ABBREVIATIONS = (
    "f; m c; r h b; l; r",
    "v; m; h; l; r",
    "a av; m mi; r ar arr; g; d",
    "d del; m c; t tra; i; d",
    "a ant; m c; p post; s; d",
    "d; m; t; e; d",
    "p; s; t; l; p",
    "; ; ; ; ",
    "q; z; h; z; y",
)
"""Abbreviations in the same order; they count only if they place all legs."""

_PREFIX = "(?:l|r|left|right|fore|front|mid|hind|rear|upper|lower)?"
NO_LEG = re.compile(
    f"{_PREFIX}(?:wing|antenna|antennae|feeler|head|neck|tail|arm|hand|finger|gripper|claw|pincer|"
    "sensor|camera|lidar|mast|flugel|fuhler|aile|ala)s?"
)
LEG = re.compile(
    f"{_PREFIX}(?:leg|hip|thigh|knee|shank|shin|calf|ankle|foot|toe|coxa|trochanter|femur|tibia|"
    "tarsus|bein)s?"
)
"""Words of other limbs and of legs: a limb is the kind that most of its names say."""

_TOKEN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_PART = re.compile(r"(leg|limb|bein|hip|foot)s?$")  # as in 'foreleg'

Place = tuple[float | None, float | None]
"""1 for front, 0 for the middle, -1 for rear; and 1 for left, -1 for right; None if not told."""


def places(names: Sequence[Sequence[str]]) -> Floats:
    """Return where the names of limbs say that they are: to the front, and to the left.

    Words such as `vorne` count wherever they are separate. Abbreviations and words that are glued
    to others (`rfsj`, `FLhip`, `leftfront`) count if they are in one language, tell different
    places of all limbs, and the rest of the name is the same.

    Args:
        names: the names of the joints and links of each limb.

    Returns:
        The places, (limbs, 2); a column is nan if the names do not distinguish its two ends, and
        so are the elements of limbs whose names tell nothing.
    """
    plain = [[_without_accents(name) for name in limb] for limb in names]
    told = _table([_by_words(limb) for limb in plain])
    glued = [_table(found) for found in _by_codes(plain)]
    for axis, clear in enumerate(_distinguishes(told)):
        whole = [one[:, axis] for one in glued if _distinguishes(one)[axis]]
        columns = {tuple(column) for column in whole if not np.isnan(column).any()}
        if len(columns) == 1 and (not clear or np.isnan(told[:, axis]).any()):
            told[:, axis] = columns.pop()
        elif not clear:
            told[:, axis] = np.nan
    return told


def rows(names: Sequence[Sequence[str]], left: Floats) -> Floats:
    """Return the places that numbers tell, from front to rear: L1, L2, L3, R1, R2, R3.

    Args:
        names: the names of the joints and links of each limb.
        left: the sides that the names tell, (limbs,).

    Returns:
        The places, (limbs,): positive for the first legs; nan unless both sides have the same
        numbers.
    """
    numbers = [_number(limb) for limb in names]
    of_left, of_right = (
        {number for number, one in zip(numbers, left, strict=True) if one == side}
        for side in (1, -1)
    )
    if None in numbers or of_left != of_right or not 1 < len(of_left) == len(numbers) / 2:
        return np.full(len(names), np.nan)
    order = np.array(numbers, float)
    ahead: Floats = order.mean() - order
    return ahead


def is_leg(names: Sequence[str]) -> bool:
    """Return False if most names of a limb's joints and links are those of a wing, an arm …"""
    of_names = [_TOKEN.findall(_without_accents(name)) for name in names]
    others = [any(NO_LEG.fullmatch(token.lower()) for token in one) for one in of_names]
    legs = [any(LEG.fullmatch(token.lower()) for token in one) for one in of_names]
    return sum(others) <= sum(leg and not other for leg, other in zip(legs, others, strict=True))


def _by_words(names: Sequence[str]) -> Place:
    """Return the place that separate words in a limb's names tell; None if they disagree."""
    of_names = [_place_in(name) for name in names]
    front, left = (
        {value for value in column if value is not None} for column in zip(*of_names, strict=True)
    )
    return _agreed(front), _agreed(left)


def _agreed(values: set[float]) -> float | None:
    ends = values - {0}
    return ends.pop() if len(ends) == 1 else None if ends or not values else 0


def _place_in(name: str) -> Place:
    tokens = [token.lower() for token in _TOKEN.findall(name)]
    words = [_words()[part] for token in tokens if (part := _PART.sub("", token)) in _words()]
    english = [_codes().get(token, {}).get(0) for token in tokens if len(token) == 2]
    pairs = [place for place in english if place]
    letters = [{"l": 1, "r": -1}.get(token) for token in (*tokens[:1], *tokens[-1:])]
    front, left = (
        next((place[axis] for place in (*words, *pairs) if place[axis] is not None), None)
        for axis in (0, 1)
    )
    return front, left or next(filter(None, letters), None)


def _by_codes(names: Sequence[Sequence[str]]) -> list[list[Place]]:
    """Return the readings of abbreviations and glued words that place all limbs differently."""
    numbers = [_number(limb) for limb in names]
    options: list[dict[tuple[int, str, str], Place]] = []
    unclear: set[tuple[int, str, str]] = set()
    for limb in names:
        found: dict[tuple[int, str, str], Place] = {}
        for name in limb:
            text = re.sub(r"\d+", "#", re.sub(r"[^a-z0-9]", "", name.lower()))
            for start in range(len(text)):
                for end in range(start + 1, min(len(text), start + 20) + 1):
                    for language, place in _codes().get(text[start:end], {}).items():
                        key = language, text[:start], text[end:]
                        if found.setdefault(key, place) != place:
                            unclear.add(key)
        options.append(found)
    shared = set(options[0]).intersection(*options[1:]) - unclear
    readings = [[found[key] for found in options] for key in sorted(shared)]
    return [one for one in readings if len(set(zip(one, numbers, strict=True))) == len(names)]


def _number(names: Sequence[str]) -> int | None:
    """Return the only number that all numbered names of a limb have, or None."""
    of_names = [set(map(int, re.findall(r"\d{1,4}", name))) for name in names]
    numbered = [one for one in of_names if one]
    common = set.intersection(*numbered) if numbered else set()
    return common.pop() if len(common) == 1 else None


def _table(found: Sequence[Place]) -> Floats:
    return np.array(found, float)  # None becomes nan


def _distinguishes(told: Floats) -> NDArray[np.bool_]:
    """Return whether places tell front from rear, and left from right, (2,)."""
    both: NDArray[np.bool_] = np.nanmax(told, axis=0, initial=0) > 0
    both &= np.nanmin(told, axis=0, initial=0) < 0
    return both


@cache
def _words() -> Mapping[str, Place]:
    """Return the places that the words of all languages tell."""
    kinds: Sequence[Place] = [(1, None), (0, None), (-1, None), (None, 1), (None, -1)]
    return {
        word: kind
        for language in WORDS
        for kind, group in zip(kinds, language.split(";"), strict=True)
        for word in group.split()
    }


@cache
def _codes() -> Mapping[str, Mapping[int, Place]]:
    """Return what codes, such as 'lf', tell in each language, by its index."""
    codes: dict[str, dict[int, Place]] = defaultdict(dict)
    for language, (full, short) in enumerate(zip(WORDS, ABBREVIATIONS, strict=True)):
        words = [group.split() for group in full.split(";")]
        front, middle, rear, left, right = (
            one + other.split() for one, other in zip(words, short.split(";"), strict=True)
        )
        all_rows = ((1, front), (0, middle), (-1, rear), (None, [""]))
        for (row, of_row), (side, of_side) in product(all_rows, ((1, left), (-1, right))):
            for one, other in product(of_row, of_side):
                codes[one + other][language] = codes[other + one][language] = (row, side)
        for row, of_row in ((1, words[0]), (0, words[1]), (-1, words[2])):
            for one in of_row:
                codes[one][language] = (row, None)
    return dict(codes)


def _without_accents(name: str) -> str:
    plain = unicodedata.normalize("NFKD", name.replace("ł", "l").replace("Ł", "L"))
    return plain.encode("ascii", "ignore").decode()

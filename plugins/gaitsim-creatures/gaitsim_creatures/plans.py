"""Plans: bodies as text, one module after another, such as 'L hinge 90, LF brick'.

A module's place names the faces from the core to it: front, left, right, back, up and down. So a
plan cannot contain a cycle, or two modules on one face.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

import numpy as np

from gaitsim.plugin import GaitsimError, nearest, toml
from gaitsim_creatures.trees import (
    BRICK,
    FACE,
    FACES,
    HEAD,
    HINGE,
    MODULE,
    PARENT,
    TURN,
    TURNS,
    WIDTH,
    Bodies,
    Integers,
    Shapes,
    TreeSpace,
)

KINDS = {"brick": BRICK, "hinge": HINGE}
LETTERS = {face[0].upper(): index for index, face in enumerate(FACES)}
MOST = 100  # modules of a plan
_FORM = "modules such as 'L hinge 90, LF brick': place, kind, and turn in steps of 45°"


@dataclass(frozen=True)
class PlannedModule:
    """A module of a plan: its place, its kind, and its turn in steps of 45°."""

    place: str
    kind: int
    turn: int


@lru_cache(maxsize=1)
def published() -> dict[str, str]:
    """Return the plans of published bodies by name."""
    text = (files("gaitsim_creatures") / "tables" / "bodies.toml").read_text(encoding="utf-8")
    return {name: str(plan) for name, plan in toml.parse(text, "bodies.toml").items()}


@lru_cache(maxsize=256)
def parse_plan(text: str) -> tuple[PlannedModule, ...]:
    """Return the modules of a plan or a published body, parents before their children.

    Raises:
        GaitsimError: the text is not a plan of a tree.
    """
    text = published().get(text, text)
    found: dict[str, PlannedModule] = {}
    parts = [part.split() for part in text.replace("\n", " ").split(",") if part.strip()]
    if not parts or len(parts) > MOST:
        raise _invalid(f"a plan has 1 to {MOST} modules, not {len(parts)}")
    for part in parts:
        shown = " ".join(part)[:80]
        if len(part) not in (2, 3):
            raise _invalid(f"{shown!r} is not a module")
        place, kind = part[0].upper(), part[1].lower()
        if unknown := next((letter for letter in place if letter not in LETTERS), ""):
            raise _invalid(
                f"{shown!r}: {unknown!r} is not a face; {', '.join(LETTERS)} are {', '.join(FACES)}"
            )
        if kind not in KINDS:
            raise _invalid(f"{shown!r}: {kind!r} is not a module", nearest(kind, [*KINDS]))
        turn = part[2].removesuffix("°") if len(part) == 3 else "0"
        if not turn.lstrip("+-").isdigit() or int(turn[-6:]) % 45:
            raise _invalid(f"{shown!r}: the turn must be a multiple of 45°, not {turn!r}")
        if place in found:
            raise _invalid(f"the face {place!r} is taken twice")
        found[place] = PlannedModule(place, KINDS[kind], int(turn[-6:]) // 45 % TURNS)
    for place in found:
        if place[:-1] and place[:-1] not in found:
            raise _invalid(f"{place!r} has no parent: there is no module {place[:-1]!r}")
    modules = tuple(found.values())
    places = [module.place for module in modules]
    ordered = all(place[:-1] in ["", *places[:index]] for index, place in enumerate(places))
    return modules if ordered else tuple(sorted(modules, key=lambda module: len(module.place)))


def _invalid(what: str, remedy: str = "") -> GaitsimError:
    allowed = f"{', '.join(published())}, 'evolve', or {_FORM}"
    return GaitsimError(f"invalid body: {what}", key="body", allowed=allowed, remedy=remedy)


def grow_plan(modules: Sequence[PlannedModule], shapes: Shapes) -> Bodies:
    """Return the body of a plan, a population of one.

    Raises:
        GaitsimError: the parent of a module has no such face, or the module overlaps another one.
    """
    space = TreeSpace(len(modules), shapes, math.inf, 1.0, (0.5, 1.0), "never")
    genome = np.zeros((1, space.genes))
    genome[0, 0] = 1.0
    nodes = genome[0, HEAD:].reshape(-1, WIDTH)
    numbers = {module.place: index for index, module in enumerate(modules)}
    for node, module in zip(nodes, modules, strict=True):
        node[MODULE], node[TURN] = module.kind, module.turn
        node[PARENT] = numbers.get(module.place[:-1], -1)
        node[FACE] = LETTERS[module.place[-1]]
    bodies = space.grow(genome)
    grown = {*place_names(bodies.modules[0, : bodies.counts[0]])}
    for module in modules:
        if module.place not in grown:
            raise _invalid(
                f"there is no room for the module {module.place!r}: its parent has no such face, "
                "or it overlaps another module"
            )
    return bodies


def place_names(modules: Integers) -> list[str]:
    """Return the places of grown modules, (modules, 6), by row; the core's is ''."""
    letters = [*LETTERS]
    names = [""]
    for _, parent, face, *_ in modules[1:].tolist():
        names.append(names[parent] + letters[face])
    return names


def plan_text(modules: Integers) -> str:
    """Return the plan of grown modules, (modules, 6)."""
    kinds = {kind: name for name, kind in KINDS.items()}
    parts = []
    for name, (kind, _, _, turn, *_) in zip(
        place_names(modules)[1:], modules[1:].tolist(), strict=True
    ):
        parts.append(f"{name} {kinds[kind]}{f' {45 * turn}' if turn else ''}")
    return ", ".join(parts)

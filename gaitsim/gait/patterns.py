"""Reference gaits as phase patterns, and the distance of a gait to them.

Phases are in cycles after a common time: a foot with a larger phase touches down later.
Sides: 0 left, 1 right. Places: 0 is the foremost pair.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gaitsim.gait.intervals import Floats
from gaitsim.gait.layout import Layout
from gaitsim.gait.phases import fit

NEAR = 0.1  # largest rms distance at which a gait gets the name of a pattern, cycles
_ALTERNATING = {
    1: "alternating steps",
    2: "trot",
    3: "alternating tripod",
    4: "alternating tetrapod",
}
_LAGS = np.arange(-45, 46) / 100  # cycles tried between neighbours of a metachronal gait
_SHALLOW = 0.04  # least lag between neighbours in a wave, cycles


@dataclass(frozen=True, eq=False)
class Nearest:
    """A reference gait and the distance to it.

    Attributes:
        name: name of the reference gait.
        distance: root mean square distance over the feet, cycles.
        phases: phases of the reference gait, shifted to the best fit, (feet,), cycles.
        lag: lag of each foot behind the foot in front of it on its side, if it was fitted, cycles.
    """

    name: str
    distance: float
    phases: Floats
    lag: float | None = None


def references(layout: Layout) -> dict[str, Floats]:
    """Return the phase patterns of the reference gaits by name, each (feet,), cycles.

    Neighbours and opposite legs alternate in the tetrapod of spiders (R4 L3 R2 L1 against
    L4 R3 L2 R1: Barth 2002, A Spider's World), in the tripod of insects and in the trot. In
    wave and ripple, each foot follows the one behind it by 1/legs and 2/legs of a stride, and
    the sides alternate (Wilson 1966, Annual Review of Entomology 11:103). The
    walks of four legs are those of Hildebrand (1965, Science 150:701).
    """
    side, place, pairs = layout.side, layout.place, layout.pairs
    found = {
        _ALTERNATING.get(pairs, f"alternating, {2 * pairs} legs"): (side + place) / 2,
        "in-phase hop": np.zeros(2 * pairs),
    }
    if pairs == 2:
        found |= {
            "pace": side / 2,
            "bound": place / 2,
            "lateral-sequence walk": side / 2 - place / 4,
            "diagonal-sequence walk": side / 2 + place / 4,
        }
    if pairs > 2:
        found |= {
            "wave": side / 2 - place / (2 * pairs),
            "ripple": side / 2 - place / pairs,
            "sides in turn": side / 2,
            "pairs in turn": place / 2,
        }
    return {name: pattern % 1.0 for name, pattern in found.items()}


def nearest(phases: Floats, layout: Layout) -> tuple[Nearest, Mapping[str, float]]:
    """Return the nearest reference gait, and the distance to each reference gait.

    A gait that is near none of them is 'metachronal' if its feet follow one another with the same
    lag along the body, with the sides in phase or alternating. The lag is fitted; a wave needs
    a lag of at least 0.04 cycles and at least three pairs of feet.

    Args:
        phases: phase of each foot, (feet,), cycles; feet with NaN do not step and are ignored.
        layout: positions of the feet along the body.
    """
    known = references(layout)
    away, shifted = fit(phases, np.stack([*known.values()]))
    distances = dict(zip(known, away.tolist(), strict=True))
    least = int(np.argmin(away))
    closest = Nearest([*known][least], float(away[least]), shifted[least])
    if closest.distance <= NEAR or layout.pairs < 3:
        return closest, distances
    wave = metachronal(phases, layout)
    distances["metachronal"] = wave.distance
    return min(closest, wave, key=lambda one: one.distance), distances


def metachronal(phases: Floats, layout: Layout) -> Nearest:
    """Return the nearest gait with the same lag from foot to foot along each side."""
    lags = np.repeat(_LAGS[np.abs(_LAGS) >= _SHALLOW], 2)
    across = np.tile([0.0, 0.5], len(lags) // 2)
    away, shifted = fit(phases, across[:, None] * layout.side + lags[:, None] * layout.place)
    least = int(np.argmin(away))
    return Nearest("metachronal", float(away[least]), shifted[least], float(lags[least]))

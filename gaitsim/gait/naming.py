"""Name a gait, or give the reason why it has no name."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.gait.contact import Foot, Stride
from gaitsim.gait.exploits import BRIEF
from gaitsim.gait.intervals import Floats
from gaitsim.gait.layout import Layout, layout_of
from gaitsim.gait.patterns import NEAR, nearest

NONE, STANDING = "none", "standing"
_CONSISTENT = 0.7  # least mean vector of a foot's phases; 0.7 is a spread of 0.13 cycles
_STEPPING = 0.75  # least share of the feet that step
_FEWEST = 3  # least number of touch-downs of at least one foot: phases over two strides


@dataclass(frozen=True)
class Name:
    """The name of a gait.

    Attributes:
        name: name of the nearest reference gait, 'standing' or 'none'.
        reason: distance to the reference gait, or reason why the gait has no name.
        distance: rms distance to the nearest reference gait, cycles; None if not compared.
        lag: lag of each foot behind the foot in front of it in a metachronal gait, cycles.
        pattern: phases of the reference gait, shifted to the best fit, by foot, cycles; None for
            feet that were not compared.
    """

    name: str
    reason: str
    distance: float | None = None
    lag: float | None = None
    pattern: tuple[float | None, ...] = ()


def name_of(
    feet: tuple[Foot, ...],
    stride: Stride | None,
    phases: Floats,
    consistency: Floats,
    relative: Floats,
    still: bool,
) -> tuple[Name, Mapping[str, float]]:
    """Return the name of a gait, and its distance to each reference gait it was compared with.

    Args:
        feet: steps of each foot.
        stride: common stride of the feet.
        phases: phase of each foot, (feet,), cycles.
        consistency: consistency of the phases, (feet,).
        relative: positions of the feet in the frame of the body, (frames, feet, 3), metres.
        still: whether the feet stand still relative to the body.
    """
    stepping = sum(foot.steps for foot in feet)
    if still and not stepping:
        return Name(STANDING, "nothing moves"), {}
    if stepping < _STEPPING * len(feet):
        return Name(NONE, f"{stepping} of {len(feet)} feet step"), {}
    if stride is None or max(len(foot.touch_downs) for foot in feet) < _FEWEST:
        return Name(NONE, "the feet do not step periodically"), {}
    if stride.frames <= 2 * BRIEF:
        return Name(NONE, "the feet touch down or lift off every frame or two"), {}
    inconsistent = [
        foot.name
        for foot, r in zip(feet, consistency, strict=True)
        if foot.steps and r < _CONSISTENT
    ]
    if len(inconsistent) > (1 - _STEPPING) * len(feet):
        return Name(
            NONE, f"the phases of {', '.join(inconsistent[:8])} change from stride to stride"
        ), {}
    compared = _in_pairs(phases, relative)
    if compared is None:
        return Name(NONE, "the feet do not form pairs of left and right"), {}
    chosen, layout = compared
    found, distances = nearest(phases[chosen], layout)
    places = iter(found.phases.tolist())
    pattern = tuple(next(places) if compared_with else None for compared_with in chosen)
    away = f"{found.distance:.3f} cycles from {_describe_wave(found.name, found.lag)}"
    if found.distance <= NEAR:
        return Name(found.name, away, found.distance, found.lag, pattern), distances
    reason = f"no reference gait is near; the nearest: {away}"
    return Name(NONE, reason, found.distance, pattern=pattern), distances


def _describe_wave(name: str, lag: float | None) -> str:
    if lag is None:
        return name
    way = "front to back" if lag > 0 else "back to front"
    return f"a wave that runs {way} with a lag of {abs(lag):.2f} cycles per leg"


def _in_pairs(phases: Floats, relative: Floats) -> tuple[NDArray[np.bool_], Layout] | None:
    """Return the feet to compare with reference gaits, a mask (feet,), and their layout.

    These are the feet that step, if they form pairs: a body with eight legs may hold up two of them
    and walk in a tripod. Otherwise, all feet are compared, but only the phases of those that step
    count.
    """
    stepping = ~np.isnan(phases)
    for chosen in (stepping, np.ones_like(stepping)):
        layout = layout_of(relative[:, chosen])
        if layout is not None:
            return chosen, layout
    return None

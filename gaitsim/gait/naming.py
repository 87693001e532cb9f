"""Name a gait by reference patterns, or give the reason why it has no name, such as an exploit."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitsim.gait.feet import Contacts, Floats, Foot, Layout, Stride, fit, layout_of, runs, steps
from gaitsim.gait.travel import Slip

SHAKING = 0.25  # frequency from which limbs flip-flop, as a share of the frame rate
BRIEF = 2  # longest duration of a brief stance or swing, frames
_SHARE = 0.5  # share of brief stances and swings from which feet flicker
_CHANGES = 0.05  # changes of contact per frame below which a foot does not flicker
STILL = 1e-4  # motion per frame below which a point is at rest, as a share of the body's size
_WEAK = 0.05  # motion below which a point is ignored, as a share of the fastest point's
SLIDING = 1.0  # slip ratio from which sliding explains the travel
CARRIED = 0.8  # share of the weight on the feet below which other parts carry the body
LEAP = 0.25  # share of the path in one flight; with four strides or more, each flight is shorter
CHATTER = 1.5  # touches per foot and stride from which a gait chatters
UNSUPPORTED = 0.1  # share of the path from which unsupported travel is flagged


@dataclass(frozen=True)
class Flag:
    """A sign of an exploit: its name, and the observation in words."""

    name: str
    seen: str


def rhythm(points: Floats, frame_rate: float) -> Floats:
    """Return the frequency of each point's motion, (points,), Hz; NaN for points at rest.

    The frequency is frame_rate / 2π · arccos ρ, where ρ is the correlation of successive steps. For
    a sine, this is its frequency; for a point that reverses in every frame, half the frame rate.

    Args:
        points: positions in the frame of the body, (frames, points, 3), metres.
        frame_rate: frames per second, Hz.
    """
    moved = np.diff(points, axis=0)
    squares = (moved**2).sum(axis=(0, 2))
    products = (moved[1:] * moved[:-1]).sum(axis=(0, 2))
    ends = (moved[0] ** 2).sum(axis=1) / 2 + (moved[-1] ** 2).sum(axis=1) / 2
    rho = np.divide(products, squares - ends, out=np.full_like(squares, np.nan), where=squares > 0)
    return np.asarray(frame_rate / (2 * math.pi) * np.arccos(np.clip(rho, -1, 1)))


def flip_flop(
    points: Floats, names: tuple[str, ...], size: float, frame_rate: float
) -> Flag | None:
    """Flag limbs that reverse in every frame or two.

    Args:
        points: positions of the feet, or of ends of segments for a body without feet, in the frame
            of the body, (frames, points, 3), metres.
        names: names of the points.
        size: size of the body, metres.
        frame_rate: frames per second, Hz.
    """
    if len(points) < 4 or not points.shape[1]:
        return None
    motion = np.linalg.norm(np.diff(points, axis=0), axis=-1).mean(axis=0)
    frequency = rhythm(points, frame_rate)
    moving = motion > max(STILL * size, _WEAK * float(motion.max()))
    fast = np.flatnonzero(moving & (frequency >= SHAKING * frame_rate))
    if not len(fast):
        return None
    which = list(dict.fromkeys(names[index] for index in fast))
    return Flag(
        "flip-flop",
        f"{_list_names(which)} shake at {_range(frequency[fast])} Hz; {frame_rate:g} frames a "
        f"second can represent at most {frame_rate / 2:g} Hz. No servo can follow",
    )


def flickering(touching: Contacts, names: tuple[str, ...], frame_rate: float) -> Flag | None:
    """Flag feet that touch down or lift off every frame or two."""
    found = []
    for name, foot in zip(names, touching.T, strict=True):
        lengths, _ = runs(foot)
        inner = lengths[1:-1]
        if len(inner) > _CHANGES * len(foot) and np.mean(inner <= BRIEF) >= _SHARE:
            found.append(name)
    if not found:
        return None
    return Flag(
        "flickering feet",
        f"{_list_names(found)} touch down or lift off every {1000 / frame_rate:.0f} to "
        f"{1000 * BRIEF / frame_rate:.0f} ms, a frame or two",
    )


def sliding(slip: Slip) -> Flag | None:
    """Flag travel that is explained by slip."""
    if slip.ratio is None or slip.ratio < SLIDING:
        return None
    return Flag(
        "sliding",
        f"the standing feet slide {slip.ratio:.2f} m per metre that the body travels: sliding "
        "explains the travel",
    )


def unsupported(margin: Floats, path: Floats, lying: float) -> Flag | None:
    """Flag travel in poses in which the body would tip over.

    Args:
        margin: static stability margin, (frames,), metres.
        path: path of the body, (frames, 3), metres.
        lying: share of the time during which the ground supports the trunk itself.
    """
    moved = steps(path)
    share = float(moved[margin[:-1] < 0].sum() / moved.sum()) if moved.sum() else 0.0
    if share < UNSUPPORTED or lying > 0:
        return None
    return Flag(
        "unsupported travel",
        f"for {100 * share:.0f} % of the path, the centre is outside the support of the feet: "
        "without inertia, the body would tip over",
    )


def not_on_feet(carried: Floats) -> Flag | None:
    """Flag a body in physics that does not rest on its feet alone.

    As long as the body neither rises nor sinks on average, the ground carries its weight.

    Args:
        carried: share of the weight that the feet carry, (frames,), up to a fall.
    """
    share = float(carried.mean())
    if share >= CARRIED:
        return None
    return Flag(
        "not on its feet",
        f"the feet carry only {100 * share:.0f} % of the weight: the body drags its belly or "
        "another part over the ground",
    )


def leap(touching: Contacts, path: Floats, length: float, frame_rate: float) -> Flag | None:
    """Flag travel of a body in physics that consists mainly of one flight.

    Args:
        touching: whether each foot is on the ground, (frames, feet), up to a fall.
        path: path of the body in the same frames, (frames, 3), metres.
        length: length of the body, metres.
        frame_rate: frames per second, Hz.
    """
    lengths, grounded = runs(np.asarray(touching.any(axis=1)))
    ends = np.cumsum(lengths)
    along = np.concatenate([[0.0], np.cumsum(steps(path))])
    flown = np.append(along, along[-1])[ends] - along[ends - lengths]
    flown[grounded] = 0.0
    far = int(np.argmax(flown))
    if flown[far] < max(LEAP * along[-1], length / 2):
        return None
    return Flag(
        "leap",
        f"one flight of {lengths[far] / frame_rate:.2f} s covers {flown[far]:.2f} m, "
        f"{100 * flown[far] / along[-1]:.0f} % of the path",
    )


def chatter(feet: tuple[Foot, ...]) -> str:
    """Return a sentence about feet that touch the ground several times per stride, or ''."""
    touches = [0.0 if foot.touches is None else foot.touches for foot in feet]
    mean, most = sum(touches) / len(feet), max(touches)
    if mean < CHATTER:
        return ""
    return (
        f"The gait chatters: the feet touch the ground {mean:.1f} times per stride, "
        f"{feet[touches.index(most)].name} {most:.1f} times. Contacts this brief depend on the "
        "simulated contact."
    )


def _list_names(names: list[str]) -> str:
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _range(values: Floats) -> str:
    low, high = f"{values.min():.1f}", f"{values.max():.1f}"
    return low if low == high else f"{low} to {high}"


NEAR = 0.1  # largest rms distance at which a gait gets the name of a pattern, cycles
_ALTERNATING = {
    1: "alternating steps",
    2: "trot",
    3: "alternating tripod",
    4: "alternating tetrapod",
}
_SHALLOW = 4  # least lag between neighbours in a wave, hundredths of a cycle
_LAGS = np.array([lag for lag in range(-45, 46) if abs(lag) >= _SHALLOW]).repeat(2) / 100
_ACROSS = np.tile([0.0, 0.5], len(_LAGS) // 2)  # cycles tried between the sides with each lag


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
    walks of four legs are those of Hildebrand (1965, Science 150:701). In-phase feet hop or drag
    a body that lies on the ground.
    """
    side, place, pairs = layout.side, layout.place, layout.pairs
    found = {
        _ALTERNATING.get(pairs, f"alternating, {2 * pairs} legs"): (side + place) / 2,
        "in-phase": np.zeros(2 * pairs),
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
    known, patterns = _patterns(layout)
    away, shifted = fit(phases, patterns)
    distances = dict(zip(known, away.tolist(), strict=False))
    least = int(np.argmin(away[: len(known)]))
    closest = Nearest(known[least], float(away[least]), shifted[least])
    if closest.distance <= NEAR or layout.pairs < 3:
        return closest, distances
    lag = int(np.argmin(away[len(known) :]))
    least = len(known) + lag
    wave = Nearest("metachronal", float(away[least]), shifted[least], float(_LAGS[lag]))
    distances["metachronal"] = wave.distance
    return min(closest, wave, key=lambda one: one.distance), distances


@lru_cache(16)
def _patterns(layout: Layout) -> tuple[list[str], Floats]:
    """Return the names of the reference gaits, and their phases followed by those of waves."""
    known = references(layout)
    waves = _ACROSS[:, None] * layout.side + _LAGS[:, None] * layout.place
    return [*known], np.concatenate([np.stack([*known.values()]), waves])


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
    away = f"the feet touch down within {found.distance:.3f} cycles (rms) of"
    if found.distance <= NEAR:
        what = "this pattern" if found.lag is None else _describe_wave(found.lag)
        return Name(found.name, f"{away} {what}", found.distance, found.lag, pattern), distances
    what = found.name if found.lag is None else _describe_wave(found.lag)
    reason = f"no reference gait is near; {away} the nearest: {what}"
    return Name(NONE, reason, found.distance, pattern=pattern), distances


def _describe_wave(lag: float) -> str:
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

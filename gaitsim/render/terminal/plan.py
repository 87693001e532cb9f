"""A plan of a body's legs in braille dots: the body from above, heading up."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.render.terminal.braille import (
    HIGH,
    WIDE,
    Inks,
    Paper,
    Points,
    cells,
    draw_lines,
    empty,
)

# Inks; a higher one covers a lower one.
TRUNK, LOST, LEG, DAMAGED = 1, 2, 3, 4
CHOSEN = 4  # added to the ink of the chosen leg's label
DOTTED = 1, 2  # dots drawn and left out in the lines of a lost leg
SIGNS = {LOST: "✗", DAMAGED: "!"}
HEAD = "▲"
LABEL_EXTRA = 3  # characters in a label besides the name: a sign of damage, and two brackets
SPREAD = 0.25  # distance of the legs of a body in a plane from its line, as a share of its length
LABEL_GAP = 1  # cells between a foot and its label


@dataclass(frozen=True, eq=False)
class Plan:
    """The legs of a body in one pose, from above.

    Attributes:
        segments: both ends of each segment, forward and to the left, (segments, 2, 2) m.
        owners: index of the leg of each segment, −1 for the trunk, (segments,).
        names: names of the segments.
        feet: positions of the feet, (legs, 2) m.
        legs: joints of each leg, by its name, in the order of `feet`.
    """

    segments: Points
    owners: NDArray[np.intp]
    names: tuple[str, ...]
    feet: Points
    legs: Mapping[str, tuple[str, ...]]


def plan_of(skeleton: Skeleton, legs: Mapping[str, tuple[str, ...]]) -> Plan:
    """Return the plan of a body in the first frame of a skeleton.

    A segment belongs to the leg whose name begins the segment's name. A foot is the contact named
    after the leg, or else the end of the leg's last segment. The legs of a body in a plane are
    moved sideways.
    """
    segments = skeleton.segments[0, :, :, :2].astype(np.float64)
    owners = np.full(len(segments), -1, dtype=np.intp)
    feet = np.zeros((len(legs), 2))
    for number, leg in enumerate(legs):
        owned = [name == leg or name.startswith(f"{leg} ") for name in skeleton.names]
        owners[owned] = number
        if skeleton.contacts is not None and leg in skeleton.contact_names:
            feet[number] = skeleton.contacts[0, skeleton.contact_names.index(leg), :2]
        elif any(owned):
            feet[number] = segments[owned][-1, 1]
    if not segments[..., 1].any():  # a body in a plane, whose second half of the legs is far
        reach = SPREAD * np.ptp(segments[..., 0])
        left = np.where(np.arange(len(legs)) < len(legs) / 2, -reach, reach)
        segments[owners >= 0, :, 1] = left[owners[owners >= 0], None]
        feet[:, 1] = left
    return Plan(segments, owners, skeleton.names, feet, dict(legs))


def draw_plan(
    plan: Plan, lost: Collection[str], damaged: Collection[str], chosen: str, size: tuple[int, int]
) -> tuple[NDArray[np.uint32], Inks]:
    """Draw the plan, as code points and their inks, both (rows, columns).

    Args:
        plan: the legs of the body.
        lost: names of lost legs, drawn as dotted lines.
        damaged: names of damaged joints. If no segment is named after a joint, its whole leg is
            drawn as damaged.
        chosen: the leg whose label has brackets and a different ink.
        size: columns and rows of the picture.
    """
    columns, rows = size
    dots = empty(columns, rows)
    if not dots.size:
        return cells(dots)
    names = list(plan.legs)
    state = np.array([_state(leg, joints, lost, damaged) for leg, joints in plan.legs.items()])
    inks = np.full(len(plan.owners), TRUNK)
    for segment, (owner, name) in enumerate(zip(plan.owners.tolist(), plan.names, strict=True)):
        if owner >= 0:
            ours = {joint for joint in plan.legs[names[owner]] if joint in damaged}
            shown = name in ours or not ours & {*plan.names}
            inks[segment] = state[owner] if state[owner] != DAMAGED or shown else LEG
    ends = to_cells(plan, plan.segments, size) * (WIDE, HIGH) + (WIDE / 2, HIGH / 2)
    draw_lines(dots, ends[inks == LOST], inks[inks == LOST], DOTTED)
    draw_lines(dots, ends[inks != LOST], inks[inks != LOST])
    codes, drawn = cells(dots)
    column, row = np.rint(to_cells(plan, _front(plan), size)).astype(np.intp)
    codes[row, column], drawn[row, column] = ord(HEAD), TRUNK
    for leg, (column, row) in enumerate(_labels(plan, size)):
        text = f"{names[leg]}{SIGNS.get(int(state[leg]), '')}"
        text = f"[{text}]" if names[leg] == chosen else text
        at = min(max(column - (len(text) if plan.feet[leg, 1] > 0 else 0), 0), columns - len(text))
        ink = state[leg] + (CHOSEN if names[leg] == chosen else 0)
        Paper(codes, drawn).write(row, max(at, 0), text, ink)
    return codes, drawn


def leg_at(plan: Plan, column: int, row: int, size: tuple[int, int]) -> str:
    """Return the leg whose segment or label is nearest to a cell of the picture."""
    middles = plan.segments[plan.owners >= 0].mean(axis=1)
    known = np.concatenate([to_cells(plan, middles, size), _labels(plan, size)])
    owners = np.concatenate([plan.owners[plan.owners >= 0], np.arange(len(plan.feet))])
    away = np.linalg.norm((known - (column, row)) * (WIDE, HIGH), axis=1)
    return list(plan.legs)[int(owners[np.argmin(away)])]


def next_leg(plan: Plan, leg: str, forward: int, left: int) -> str:
    """Return the nearest leg in a direction, or the same leg if no leg lies in that direction."""
    names = list(plan.legs)
    towards = np.array([forward, left])
    away = plan.feet - plan.feet[names.index(leg)]
    along = away @ towards
    across = np.abs(away @ towards[::-1])
    cost = np.where(along > np.maximum(across / 2, 1e-9), along + 2 * across, np.inf)
    return names[int(np.argmin(cost))] if np.isfinite(cost).any() else leg


def to_cells(plan: Plan, points: Points, size: tuple[int, int]) -> Points:
    """Return the columns and rows (…, 2) of points, with the heading up and space for labels."""
    columns, rows = size
    every = np.concatenate([plan.segments.reshape(-1, 2), plan.feet])
    low, high = every.min(axis=0), every.max(axis=0)
    tall, wide = np.maximum(high - low, 1e-9)
    margin = max(map(len, plan.legs), default=0) + LABEL_EXTRA + LABEL_GAP
    # A row is as high as two columns are wide.
    scale = max(min((columns - 2 * margin) / wide, 2 * (rows - 1) / tall), 1e-9)
    ahead, left = np.moveaxis(points - (low + high) / 2, -1, 0)
    return np.stack([(columns - 1) / 2 - left * scale, (rows - 1) / 2 - ahead * scale / 2], -1)


def _front(plan: Plan) -> Points:
    """Return the middle of the trunk's front, (2,) m."""
    trunk = plan.segments[plan.owners < 0].reshape(-1, 2)
    ends = trunk if len(trunk) else plan.segments.reshape(-1, 2)
    low, high = ends.min(axis=0), ends.max(axis=0)
    return np.array([high[0], (low[1] + high[1]) / 2])


def _labels(plan: Plan, size: tuple[int, int]) -> NDArray[np.intp]:
    """Return the cells (legs, 2) where labels on the right begin and labels on the left end."""
    at = np.rint(to_cells(plan, plan.feet, size)).astype(np.intp)
    at[:, 0] += np.where(plan.feet[:, 1] > 0, -LABEL_GAP + 1, LABEL_GAP)
    columns, rows = size
    return np.clip(at, 0, (columns - 1, rows - 1))


def _state(
    leg: str, joints: Collection[str], lost: Collection[str], damaged: Collection[str]
) -> int:
    if leg in lost:
        return LOST
    return DAMAGED if any(joint in damaged for joint in joints) else LEG

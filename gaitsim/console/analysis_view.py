"""Print the analysis of a gait and its footfalls, steps and travel, and of a score."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim.console.printing import output, print_table
from gaitsim.gait import Footfalls, GaitAnalysis
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import (
    Passage,
    explanation,
    format_or_dash,
    travel_and_stability,
)
from gaitsim.render.terminal.text import number, visible

COLUMNS = 62  # characters in a row of the diagram, after the name of the foot
STRIDES = 3  # strides shown, if they fit
FEET = 24  # feet shown, at most
NAME = 14  # characters shown of a foot's name, at most
DOWN, UP = "█", "·"
COLOURS = ("cyan", "yellow")  # left and right feet
UNNAMED = ("none", "standing")


def print_gait(individual: Individual, gait: GaitAnalysis) -> None:
    """Print the analysis of a gait, except for the score."""
    console = output()
    console.print(individual.title, style="bold")
    if design := individual.body.design():
        console.print(f"Design: {design}")
    found = gait.name
    style = "bold" if found.name in UNNAMED else "bold green"
    console.print(Text.assemble("Gait: ", (found.name, style), f", {found.reason}"))
    for flag in gait.flags:
        console.print(f"Likely exploit: {flag.name}. {flag.seen}", style="red")
    for warning in gait.warnings:
        console.print(Text(warning, style="yellow"))
    if gait.footfalls is not None:
        _print_footfalls(gait.footfalls, gait.frame_rate)
    print_section(travel_and_stability(gait))


def _print_footfalls(found: Footfalls, frame_rate: float) -> None:
    console = output()
    stride = found.stride
    if stride is not None:
        console.print(
            f"Stride frequency {stride.frequency:.2f} Hz{' as commanded' * stride.commanded} "
            f"({stride.frames:.1f} frames per stride), regularity {stride.periodicity:.2f}"
        )
    console.print()
    for line in diagram(found, frame_rate):
        console.print(line, no_wrap=True, crop=False)
    console.print()
    rows = []
    for index in shown_feet(len(found.feet)):
        foot = found.feet[index]
        row = (
            _short(foot.name),
            number(foot.duty_factor, 2),
            format_or_dash(foot.stance, 3),
            format_or_dash(foot.swing, 3),
            str(len(foot.touch_downs)),
            format_or_dash(found.phases[index], 2),
            format_or_dash(found.consistency[index], 2),
        )
        rows.append(row)
    numbers = "duty factor", "stance s", "swing s", "steps", "phase", "consistency"
    print_table(["foot", *numbers], rows, numbers)
    if len(found.feet) > FEET:
        console.print(f"and {len(found.feet) - FEET} more feet; --json lists all")
    console.print()


def diagram(found: Footfalls, frame_rate: float) -> list[Text]:
    """Return a footfall diagram of some strides (Hildebrand 1965), at most 80 columns wide.

    Each row is a foot, and a bar is its contact with the ground. A character that covers several
    frames shows the state of the foot in most of them.
    """
    frames, feet = found.touching.shape
    stride = found.stride.frames if found.stride else 0.0
    start = _start(found) if stride else 0
    span = min(frames - start, math.ceil(stride * STRIDES) if stride else COLUMNS)
    if stride and span > COLUMNS >= stride:
        span = int(COLUMNS // stride * stride)
    each = max(1, math.ceil(span / COLUMNS))
    shown = found.touching[start : start + span]
    label = max(len(_short(foot.name)) for foot in found.feet) + 1
    lines = []
    for index in shown_feet(feet):
        foot = found.feet[index]
        signs = "".join(
            DOWN if part.mean() >= 0.5 else UP
            for part in np.split(shown[:, index], range(each, len(shown), each))
        )
        side = 0 if index < feet / 2 else 1
        lines.append(Text.assemble(_short(foot.name).ljust(label), (signs, COLOURS[side])))
    width = len(lines[0]) - label
    begin, end = f"{start / frame_rate:.2f} s", f"{(start + len(shown)) / frame_rate:.2f} s"
    scale = f"{1000 * each / frame_rate:.0f} ms per character"
    line = begin + scale.center(max(0, width - len(begin) - len(end))) + end
    if len(begin) + len(end) + len(scale) + 2 > width:
        line = f"from {begin} to {end}, {scale}"
    return [*lines, Text(" " * label + line, style="dim")]


def shown_feet(count: int) -> list[int]:
    """Return the indices of the feet to show: all, or the foremost ones of both sides."""
    half = -(-count // 2)
    return [index for index in range(count) if count <= FEET or index % half < FEET // 2]


def _start(found: Footfalls) -> int:
    """Return the frame of the second touch-down of a foot that steps, when the gait has settled."""
    first = next((foot for foot in found.feet if foot.steps), None)
    return first.touch_downs[1] if first and len(first.touch_downs) > STRIDES + 1 else 0


def _short(name: str) -> str:
    clean = visible(name)
    return clean if len(clean) <= NAME else clean[: NAME - 1] + "…"


def print_score_breakdown(
    individual: Individual, history: Mapping[str, NDArray[np.float64]]
) -> None:
    """Print the terms of the score over time and over generations, and a summary."""
    for section in explanation(individual, history):
        output().print()
        print_section(section)


def print_section(section: Passage) -> None:
    """Print a section: its title and warnings, its table, and its notes."""
    console = output()
    if section.title:
        console.print(section.title, style="bold")
    if section.failure:
        console.print(Text(section.failure, style="red"))
    if section.warning:
        console.print(Text(section.warning, style="yellow"))
    if section.columns:
        print_table(section.columns, section.rows, section.numbers)
    for note in section.notes:
        console.print(note)

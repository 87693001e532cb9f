"""Divide a picture into panels."""

import math

Place = tuple[float, float, float, float]


def tiles(count: int, width: int, height: int) -> list[Place]:
    """Return left, bottom, width and height of `count` equal panels, row by row from the top.

    Chooses the number of columns for which the smaller side of a panel is largest.
    """
    columns = max(range(1, count + 1), key=lambda c: min(width / c, height / math.ceil(count / c)))
    rows = math.ceil(count / columns)
    wide, tall = width / columns, height / rows
    return [
        ((index % columns) * wide, height - (index // columns + 1) * tall, wide, tall)
        for index in range(count)
    ]


def inner_edges(places: list[Place], height: int) -> list[list[tuple[float, float]]]:
    """Return both ends of the lines between panels, pixels."""
    edges = []
    for left, bottom, wide, tall in places:
        if left > 0:
            edges.append([(left, bottom), (left, bottom + tall)])
        if bottom + tall < height:
            edges.append([(left, bottom + tall), (left + wide, bottom + tall)])
    return edges

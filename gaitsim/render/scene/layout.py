"""How panels share a picture."""

import math

Place = tuple[float, float, float, float]


def tiles(count: int, width: int, height: int) -> list[Place]:
    """Left, bottom, width and height of each of `count` equal panels, row by row from the top.

    As many columns as make the smaller sides of the panels largest.
    """
    columns = max(range(1, count + 1), key=lambda c: min(width / c, height / math.ceil(count / c)))
    rows = math.ceil(count / columns)
    wide, tall = width / columns, height / rows
    return [
        ((index % columns) * wide, height - (index // columns + 1) * tall, wide, tall)
        for index in range(count)
    ]


def inner_edges(places: list[Place], height: int) -> list[list[tuple[float, float]]]:
    """The lines between panels: both ends of each, pixels."""
    edges = []
    for left, bottom, wide, tall in places:
        if left > 0:
            edges.append([(left, bottom), (left, bottom + tall)])
        if bottom + tall < height:
            edges.append([(left, bottom + tall), (left + wide, bottom + tall)])
    return edges

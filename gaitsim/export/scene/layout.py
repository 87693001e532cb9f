"""How panels share a picture."""

import math

IDEAL = 4 / 3  # width to height of a panel

Place = tuple[float, float, float, float]


def tiles(count: int, width: int, height: int) -> list[Place]:
    """Left, bottom, width and height of each of `count` equal panels, row by row from the top.

    As many columns as make panels largest for pictures of 4 : 3.
    """
    columns = max(range(1, count + 1), key=lambda c: _filled(count, c, width, height))
    rows = math.ceil(count / columns)
    wide, tall = width / columns, height / rows
    return [
        ((index % columns) * wide, height - (index // columns + 1) * tall, wide, tall)
        for index in range(count)
    ]


def _filled(count: int, columns: int, width: int, height: int) -> float:
    wide, tall = width / columns, height / math.ceil(count / columns)
    return min(wide, tall * IDEAL)

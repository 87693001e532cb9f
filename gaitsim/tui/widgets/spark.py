"""A curve in one line of block characters."""

import math
from collections.abc import Sequence
from itertools import pairwise

BLOCKS = "▁▂▃▄▅▆▇█"


def spark(values: Sequence[float], width: int) -> str:
    """The curve of `values` in at most `width` characters; the highest of neighbours counts.

    What is not finite is a gap.
    """
    count = min(width, len(values))
    if count <= 0:
        return ""
    edges = [at * len(values) // count for at in range(count + 1)]
    tops = [
        max((v for v in values[a:b] if math.isfinite(v)), default=math.nan)
        for a, b in pairwise(edges)
    ]
    finite = [top for top in tops if not math.isnan(top)]
    if not finite:
        return " " * count
    low, high = min(finite), max(finite)
    scale = (len(BLOCKS) - 1) / (high - low) if high > low else 0.0
    return "".join(
        " " if math.isnan(top) else BLOCKS[round((top - low) * scale) if scale else 3]
        for top in tops
    )

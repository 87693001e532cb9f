"""Blocks of intervals between frames, the working memory of the walking kernels.

The kernels' innermost loops run over the intervals of a block. In a single record with fixed
shapes, the compiler sees that arrays do not overlap, and vectorises these loops. With separate
arrays they stay scalar: the projection onto the plane then takes 9 times as long.
"""

import numpy as np

SIZE = 80  # intervals; a block has 34 kB, about the size of a first-level cache

_BY_LEG, _BY_INTERVAL = (8, SIZE), (SIZE,)
_FIELDS = {
    # Feet in the middle of the interval, relative to the centre of mass, and their travel, m.
    **dict.fromkeys(("x", "y", "z", "dx", "dy", "dz"), _BY_LEG),
    # The centre of mass in the body's frame, m.
    **dict.fromkeys(("cx", "cy", "cz"), _BY_INTERVAL),
    # The resting plane: its height under the centre, m, upward normal n, and tilt, rad.
    **dict.fromkeys(("height", "nx", "ny", "nz", "slope"), _BY_INTERVAL),
    # Whether a foot is on the plane, 1 or 0; its position and travel on the plane, m, from the
    # mean of the stance feet; 0 for a foot in the air.
    **dict.fromkeys(("on", "u", "v", "du", "dv"), _BY_LEG),
    # Number of stance feet; the centre of mass on the plane, relative to their centroid, m.
    **dict.fromkeys(("count", "u0", "v0"), _BY_INTERVAL),
    # Gravity along the ground in the body's frame, relative to gravity into the ground.
    **dict.fromkeys(("lean_x", "lean_y"), _BY_INTERVAL),
    # A corner of the support polygon, relative to the centroid, and the stability margin, m.
    **dict.fromkeys(("corner_u", "corner_v", "margin"), _BY_INTERVAL),
    # Motion of the body, m and rad, and mean slide of the stance feet, m.
    **dict.fromkeys(("forward", "sideways", "turn", "slip"), _BY_INTERVAL),
}
# `feet` holds the three feet that the body rests on, i < j < k, as 64 i + 8 j + k; −1 for none.
# The heading of the body in the middle of the interval, rad, and its cosine and sine, are doubles.
BLOCK = np.dtype(
    [
        ("feet", np.int32, _BY_INTERVAL),
        *((name, np.float32, s) for name, s in _FIELDS.items()),
        *((name, np.float64, _BY_INTERVAL) for name in ("heading", "ahead_x", "ahead_y")),
    ],
    align=True,
)


def whole_blocks(frames: int) -> int:
    """Return the number of frames of the blocks with all intervals between some frames."""
    return SIZE * -((1 - frames) // SIZE) + 1

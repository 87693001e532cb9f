"""Blocks of frame intervals, the working memory of the walking kernels.

The kernels' innermost loops run over the intervals of a block. In one record of fixed shapes the
compiler sees that no two arrays overlap, and turns these loops into vector instructions. With
separate arrays the same loops stay scalar: the projection onto the plane takes 9 times as long.
"""

import numpy as np

SIZE = 80  # intervals; a block is 34 kB, about what a first-level cache holds

_BY_LEG, _BY_INTERVAL = (8, SIZE), (SIZE,)
_FIELDS = {
    # Feet half-way through the interval, from the centre of mass, and their travel, m.
    **dict.fromkeys(("x", "y", "z", "dx", "dy", "dz"), _BY_LEG),
    # The centre of mass in the body's frame, m.
    **dict.fromkeys(("cx", "cy", "cz"), _BY_INTERVAL),
    # The resting plane: its height under the centre, m, upward normal n, and tilt, rad.
    **dict.fromkeys(("height", "nx", "ny", "nz", "slope"), _BY_INTERVAL),
    # Whether a foot is on the plane, 1 or 0; its place and travel there, m, from the mean of the
    # stance feet, and 0 in the air.
    **dict.fromkeys(("on", "u", "v", "du", "dv"), _BY_LEG),
    # Number of stance feet; the centre of mass in the plane, m, from their centroid.
    **dict.fromkeys(("count", "u0", "v0"), _BY_INTERVAL),
    # A corner of the support polygon, m, from the centroid, and the stability margin, m.
    **dict.fromkeys(("corner_u", "corner_v", "margin"), _BY_INTERVAL),
    # Motion of the body, m and rad, and mean slide of the stance feet, m.
    **dict.fromkeys(("forward", "sideways", "turn", "slip"), _BY_INTERVAL),
}
# Also the three feet that the body rests on, i < j < k, as 64 i + 8 j + k; −1 without any.
BLOCK = np.dtype(
    [("feet", np.int32, _BY_INTERVAL), *((name, np.float32, s) for name, s in _FIELDS.items())]
)

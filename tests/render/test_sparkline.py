"""Sparklines: heights, gaps, scales, and the widest ranges of floats."""

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from gaitsim.render.terminal.curves import sparkline


@pytest.mark.parametrize(
    ("values", "width", "shown"),
    [
        ([0, 1, 2, 3], 8, "⡠⠊"),
        ([3, 0], 8, "⢱"),
        ([], 5, ""),
        ([1, 2], 0, ""),
        ([1.0, 2, 3], 5, "⡰⠁"),
        ([2.5, 2.5, 2.5], 8, "⣀⡀"),
        ([1.0] * 9, 3, "⣀⣀⣀"),
        ([-np.inf, 0, np.nan, 1], 8, "⢀⠈"),
        ([np.nan, np.inf, -np.inf], 9, "  "),
        ([-1e308, 1e308], 2, "⡸"),
        (np.arange(100_000.0), 2, "⡠⠊"),
    ],
)
def test_heights_and_gaps(values, width, shown):
    assert sparkline(values, width) == shown


@pytest.mark.parametrize(
    ("scale", "shown"),
    [((0, 9), "⣀⡀"), ((-9, 1), "⠉⠁"), ((1, 1), "⣀⡀"), ((2, 3), "⣀⡀"), ((-1, 0), "⠉⠁")],
)
def test_a_scale_lets_curves_be_compared_and_clips_them(scale, shown):
    assert sparkline([1.0, 1.0, 1.0], 8, scale) == shown


@given(st.lists(st.floats(width=64), min_size=1, max_size=300), st.integers(1, 120))
@example([-1e308, 1e308], 3)
def test_the_curve_fits_its_width_and_ends_with_the_newest_value(values, width):
    drawn = sparkline(values, width)
    assert len(drawn) == min(-(-len(values) // 2), width)
    assert all(dots == " " or "\u2800" < dots <= "\u28ff" for dots in drawn)
    ends = sparkline([0.0] * 2 * width + values, width)[-1]  # the newest value is on the right
    assert (ord(ends) & 0xB8 if ends != " " else 0) > 0 or not np.isfinite(values[-1])

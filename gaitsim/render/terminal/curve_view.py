"""The view of curves: visible range, smoothing and logarithmic axes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.render.series import Series
from gaitsim.render.terminal.braille import Dots
from gaitsim.render.ticks import MAX_VALUE, clipped

# A few very low scores, for example in the first generations, would flatten the rest of the
# curves.
MAX_OUTLIERS = 0.05  # maximum share of points left out below the axis
MIN_OUTLIER_DISTANCE = (
    4.0  # minimum distance of such points below the others, in heights of the others
)
WINDOWS = (1, 5, 25, 125)  # widths of the median filter of smoothed curves, generations


@dataclass(frozen=True)
class CurveView:
    """The visible range of curves and the kind of their axes.

    Attributes:
        left, right: ends of the horizontal axis; None extends it to the ends of the curves.
        smooth: width of the median filter, an odd number of points; 1 disables smoothing.
        log: whether the vertical axis is logarithmic, provided that its values are positive.
        whole: whether the vertical axis includes the few points far below the others.
    """

    left: float | None = None
    right: float | None = None
    smooth: int = 1
    log: bool = False
    whole: bool = False

    @property
    def zoomed(self) -> bool:
        """Whether an end of the horizontal axis has been set."""
        return self.left is not None or self.right is not None

    def reset(self) -> "CurveView":
        """Return the view of the whole curves, with the same smoothing and kind of axis."""
        return replace(self, left=None, right=None)


@dataclass(frozen=True)
class Scale:
    """One axis: its ends, and whether it is logarithmic."""

    low: float
    high: float
    log: bool = False

    def share(self, values: NDArray[Any] | float) -> NDArray[np.float64]:
        """Return the position of values along the axis, from 0 at the low end to 1 at the high."""
        found = np.asarray(values, dtype=np.float64)
        found = clipped(found)
        low, high = self.low, self.high
        if self.log:
            with np.errstate(invalid="ignore", divide="ignore"):
                found = np.log10(found)
            low, high = float(np.log10(low)), float(np.log10(high))
        return (found - low) / (high - low)

    def value(self, share: float) -> float:
        """Return the value at a share of an axis that is not logarithmic."""
        return self.low + share * (self.high - self.low)

    def zoomed(self, factor: float, centre: float, whole: "Scale") -> "Scale | None":
        """Return the axis stretched about a share of it; None if all of `whole` is visible."""
        return self._within(centre - centre / factor, centre + (1 - centre) / factor, whole)

    def panned(self, share: float, whole: "Scale") -> "Scale | None":
        """Return the axis moved by a share of its length, within `whole`; None as in `zoomed`."""
        low, high = (float(whole.share(self.value(end))) for end in (0, 1))
        width = high - low
        low = min(max(low + share * width, 0.0), max(1 - width, 0.0))
        return whole._within(low, low + width, whole)

    def _within(self, low: float, high: float, whole: "Scale") -> "Scale | None":
        """Return the part between two shares; None if this part contains `whole`."""
        ends = max(self.value(low), whole.low), min(self.value(high), whole.high)
        if ends[0] <= whole.low and ends[1] >= whole.high:
            return None
        # A narrower axis would show rounding errors.
        if not ends[1] - ends[0] > 1e-9 * max(map(abs, ends)):
            return self
        return Scale(*ends)


@dataclass(frozen=True)
class Frame:
    """The axes of a plot, and whether points lie below the vertical axis."""

    x: Scale
    y: Scale
    below: bool = False

    def dots(self, x: NDArray[Any], y: NDArray[Any] | None, picture: Dots) -> NDArray[np.float64]:
        """Return the dots (n, 2) of points; without y they are spread over the full height."""
        height, width = picture.shape
        down = np.linspace(0, 1, len(x)) if y is None else 1 - self.y.share(y)
        return np.stack([self.x.share(x) * (width - 1), down * (height - 1)], axis=1)


def frame_of(series: Sequence[Series], view: CurveView = CurveView()) -> Frame | None:
    """Return the axes of a view; None if the curves have no finite point.

    The vertical axis covers the points within the horizontal axis, except, unless the view is
    `whole`, a few points far below the others.
    """
    found = [(one, at) for one in series if (at := np.isfinite(one.y)).any()]
    if not found:
        return None
    drawn = [(one.x[at], one.y[at]) for one, at in found if not one.incomparable]
    drawn = drawn or [(one.x[at], one.y[at]) for one, at in found]
    x, y = (
        np.clip(np.concatenate(part), -MAX_VALUE, MAX_VALUE) for part in zip(*drawn, strict=True)
    )
    left = min(float(one.x[at][0]) for one, at in found)
    right = max(float(one.x[at][-1]) for one, at in found)
    left = left if view.left is None else view.left
    right = right if view.right is None else view.right
    across = Scale(left, right if right > left else left + 1.0)
    seen = y[(x >= across.low) & (x <= across.high)]
    seen = seen if len(seen) else y
    low, top = float(seen.min()), float(seen.max())
    usual = float(np.quantile(seen, MAX_OUTLIERS))
    cut = not view.whole and top - low > (1 + MIN_OUTLIER_DISTANCE) * (top - usual) > 0
    low = usual if cut else low
    if top - low <= max(1e-9 * max(abs(top), abs(low)), 1e-300):
        # Centre a constant curve on an axis of some height.
        half = 0.1 * abs(top) or 1.0
        low, top = low - half, top + half
    return Frame(across, Scale(low, top, view.log and low > 0), bool(cut))


def smooth_series(series: Series, window: int) -> Series:
    """Return a series filtered by a median of `window` points, stage by stage; gaps remain."""
    if window <= 1:
        return series
    from scipy.ndimage import median_filter

    y = np.array(series.y, dtype=np.float64)
    for part in np.split(np.arange(len(y)), series.stages):
        at = part[np.isfinite(y[part])]
        if len(at):
            y[at] = median_filter(y[at], min(window, 2 * len(at) - 1), mode="reflect")
    return replace(series, y=y)


def nearest(series: Series, x: float) -> int | None:
    """Return the index of the point nearest to x; None if x is outside the series."""
    count = len(series.x)
    if not count or x < series.x[0] or x > series.x[-1]:
        return None
    right = min(int(np.searchsorted(series.x, x)), count - 1)
    left = max(right - 1, 0)
    return left if abs(series.x[left] - x) <= abs(series.x[right] - x) else right

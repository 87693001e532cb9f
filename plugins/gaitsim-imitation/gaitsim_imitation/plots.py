"""Plot the errors of imitators during training."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.pictures import LIGHT, WIDTH, Theme, add_heading, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def errors_figure(
    errors: Mapping[str, NDArray[np.float64]],
    heading: str,
    theme: Theme = LIGHT,
    size: tuple[float, float] = (WIDTH, 2.4),
) -> "Figure":
    """Plot mean squared errors by epoch, on a logarithmic scale.

    Args:
        errors: errors by label, each (epochs,), rad².
        heading: heading of the figure.
        theme: colours of the plot.
        size: width and height, inches.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

    with styled(theme):
        figure = Figure(figsize=size)
        axes = figure.subplots()
        for index, (label, values) in enumerate(errors.items()):
            epochs = np.arange(1, len(values) + 1)
            marker = "." if len(values) == 1 else None  # a line through one point is invisible
            # An error of zero has no logarithm and leaves a gap in the line.
            shown = np.where(values > 0, values, np.nan)
            axes.plot(epochs, shown, label=label, marker=marker, **theme.line(index))
        if any((values > 0).any() for values in errors.values()):
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter(FuncFormatter(_power_of_ten))
            axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set_xlim(1, max(2, *(len(values) for values in errors.values())))
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        axes.set_xlabel("epoch")
        axes.set_ylabel("MSE of the next frame (rad²)")
        handles, labels = axes.get_legend_handles_labels()
        add_heading(figure, heading, *((handles, labels) if len(errors) > 1 else ()))
    return figure


def _power_of_ten(value: float, _position: int | None = None) -> str:
    """Format a power of ten, such as '10⁻³'; the plot style disables mathematical notation."""
    exponent = str(round(np.log10(value)))
    return "10" + exponent.translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))

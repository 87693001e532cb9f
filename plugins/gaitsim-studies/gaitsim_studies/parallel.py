"""The cells of a study in parallel coordinates."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.pictures import (
    LIGHT,
    MAX_AXES,
    ParallelAxis,
    ParallelView,
    parallel_figure,
    replace_figure,
)
from gaitsim_studies.file import EXPERIMENT, Cell, Scalar, Study
from gaitsim_studies.running import Best

FILE = "parallel.png"
MAX_CHOICES = 12  # an option with more numbers has an axis of numbers instead of one of choices


def plot_cells(folder: Path, study: Study, found: Sequence[tuple[Cell, Best]]) -> None:
    """Draw the cells of a study into a folder; with a single option, remove an old figure."""
    view = view_of(study, found)
    drawn = 3 <= len(view.axes) <= MAX_AXES and view.best is not None
    text = f"{study.name}, mean of {study.repeats} repeat{'s' * (study.repeats > 1)}"
    replace_figure(folder / FILE, parallel_figure(view, text, LIGHT) if drawn else None)


def view_of(study: Study, found: Sequence[tuple[Cell, Best]]) -> ParallelView:
    """Return the finished cells of a study: their options and mean last best scores.

    A cell in which a repeat failed has no score.

    Raises:
        GaitsimError: no cell is finished.
    """
    if not found:
        raise GaitsimError(
            f"no cell of the study {study.name} is finished",
            remedy="let the study run until some cells are finished",
        )
    axes = []
    for axis in (EXPERIMENT, *study.axes):
        values: list[Scalar] = [*study.experiments] if axis == EXPERIMENT else study.values(axis)
        if len(values) < 2:
            continue
        points = [cell.point[axis] for cell, _ in found]
        numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
        if numbers and len(values) > MAX_CHOICES:
            axes.append(ParallelAxis(axis, np.array(points, np.float64)))
        else:
            at = np.array([values.index(point) for point in points], np.float64)
            axes.append(ParallelAxis(axis, at, choices=tuple(map(str, values))))
    with np.errstate(over="ignore"):
        means = np.array([best[:, -1].mean() for _, best in found])
    scores = np.where(np.isfinite(means), means, np.nan)
    units = {cell.experiment.fitness.unit for cell, _ in found}
    unit = units.pop() if len(units) == 1 else ""
    axes.append(ParallelAxis("mean best score", scores, unit, "max"))
    return ParallelView(tuple(axes), "cells")

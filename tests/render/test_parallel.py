"""Parallel coordinates of members and cells: positions, figures, and pictures of characters."""

import numpy as np
import pytest

from gaitsim.errors import NothingToPlotError
from gaitsim.render.parallel_view import ParallelAxis, ParallelView
from gaitsim.render.plots.parallel import parallel_figure
from gaitsim.render.plots.style import LIGHT


def view(*columns, scores=None):
    axes = [ParallelAxis(f"axis {at}", np.array(one, float)) for at, one in enumerate(columns)]
    scores = np.arange(len(columns[0]), dtype=float) if scores is None else np.array(scores, float)
    return ParallelView((*axes, ParallelAxis("score", scores, "m", "max")), "members")


def test_the_figure_has_a_line_for_each_item_and_the_best_is_thick():
    found = view([3, 1, 2], [10, 30, 20])
    figure = parallel_figure(found, "runs", LIGHT)
    (lines,) = figure.axes[0].collections
    ends = {(line[0][1], line[-1][1]) for line in lines.get_segments()}
    assert ends == {(1.0, 0.0), (0.0, 0.5), (0.5, 1.0)}
    thick = int(np.argmax(lines.get_linewidths()))
    assert lines.get_segments()[thick][-1][1] == 1.0
    with pytest.raises(NothingToPlotError, match="has a score"):
        parallel_figure(view([1, 2], scores=[np.nan, np.nan]), "runs", LIGHT)
    with pytest.raises(NothingToPlotError, match="too many axes"):
        parallel_figure(view(*[[1, 2]] * 20), "runs", LIGHT)


@pytest.mark.parametrize(
    "values", [[1.0], [2.0, 2.0], [np.nan, 1.0], [1e308, -1e308], [0.0] * 5_000]
)
def test_extreme_items_are_drawn(values):
    found = view(values, [1.0] * len(values))
    parallel_figure(found, "runs", LIGHT)

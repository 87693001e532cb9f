"""Parallel coordinates of members and cells: positions, figures, and pictures of characters."""

from types import SimpleNamespace

import numpy as np
import pytest

from gaitsim.errors import GaitsimError, NothingToPlotError
from gaitsim.render.parallel_view import ParallelAxis, ParallelView
from gaitsim.render.plots.parallel import parallel_figure
from gaitsim.render.plots.style import LIGHT
from gaitsim.study.file import Study


def view(*columns, scores=None):
    axes = [ParallelAxis(f"axis {at}", np.array(one, float)) for at, one in enumerate(columns)]
    scores = np.arange(len(columns[0]), dtype=float) if scores is None else np.array(scores, float)
    return ParallelView((*axes, ParallelAxis("score", scores, "m", "max")), "members")


def test_cells_of_a_study_are_lines_across_its_options():
    study = Study(
        experiments=("a", "b"), axes={"rate": (0.1, 0.2), "kind": ("x", "y"), "one": (3,)}
    )
    points = [
        {"experiment": name, "rate": rate, "kind": kind, "one": 3}
        for name in "ab"
        for rate in (0.1, 0.2)
        for kind in "xy"
    ]
    experiment = SimpleNamespace(fitness=SimpleNamespace(unit="m"))
    cells = [SimpleNamespace(point=point, experiment=experiment) for point in points]
    bests = [np.full((3, 2), float(at)) for at in range(8)]
    bests[2][1, -1] = -np.inf
    found = ParallelView.of_study(study, [*zip(cells, bests, strict=True)])
    assert [axis.name for axis in found.axes] == ["experiment", "rate", "kind", "mean best score"]
    assert found.axes[1].choices == ("0.1", "0.2")
    assert found.best == 7
    assert found.axes[-1].label == "mean best score (m)"
    assert np.flatnonzero(np.isnan(found.scores)).tolist() == [2]
    # Cells with the same choice are side by side, in the order of their scores.
    beside = found.shares[[0, 1, 4, 5], 1]
    assert (np.diff(beside) > 0).all()
    assert beside.max() < 0.5 < found.shares[[2, 3, 6, 7], 1].min()
    with pytest.raises(GaitsimError, match="no cell"):
        ParallelView.of_study(study, [])


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

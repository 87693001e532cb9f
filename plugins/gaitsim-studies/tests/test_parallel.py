"""Parallel coordinates of the cells of a study."""

from types import SimpleNamespace

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim_studies.file import Study
from gaitsim_studies.plots import view_of


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
    found = view_of(study, [*zip(cells, bests, strict=True)])
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
        view_of(study, [])

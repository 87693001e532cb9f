"""Plot the surfaces of a study: the mean best score against an axis and the generation."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gaitsim.plugin.pictures import LIGHT, save, styled
from gaitsim.plugin.runs import writing
from gaitsim_studies.file import EXPERIMENT, Cell, Study
from gaitsim_studies.running import Best, recorded_generations


def surface_axis(study: Study) -> str | None:
    """Return the only axis of a study, if its values are numbers; else None."""
    if len(study.axes) != 1 or {*study.axes} & {"evolution.generations", "seed"}:
        return None
    (axis,) = study.axes
    numbers = all(
        isinstance(v, int | float) and not isinstance(v, bool) for v in study.values(axis)
    )
    return axis if numbers and len(study.values(axis)) > 1 else None


def plot_surfaces(folder: Path, study: Study, results: Sequence[tuple[Cell, Best]]) -> None:
    """Draw the surface of each experiment into a folder, after removing old surfaces."""
    for old in folder.glob("surface-*.png"):
        with writing(old):
            old.unlink()
    axis = surface_axis(study)
    if axis is not None:
        for place, experiment in enumerate(study.experiments, 1):
            file = folder / f"surface-{place}-{Path(experiment).stem}.png"
            _plot_surface(study, axis, experiment, results, file)


@np.errstate(over="ignore")
def _plot_surface(
    study: Study, axis: str, experiment: str, results: Sequence[tuple[Cell, Best]], path: Path
) -> None:
    """Draw the surface of an experiment, unless it has only one generation or no scores."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    mine = [(cell, best) for cell, best in results if cell.point[EXPERIMENT] == experiment]
    generations = recorded_generations(mine[0][0].experiment, study.record_every)
    along = np.array([cell.point[axis] for cell, _ in mine], dtype=float)
    means = np.stack([best.mean(axis=0) for _, best in mine])
    means[~np.isfinite(means)] = np.nan  # a repeat without a score leaves a hole in the surface
    if means.shape[1] < 2 or np.isnan(means).all():
        return
    with styled(LIGHT):
        figure = Figure(figsize=(5.4, 4.2))
        figure.set_layout_engine("none")  # the layout engine cannot place 3D axes
        axes = figure.add_axes((0.0, -0.02, 0.96, 1.0), projection="3d")
        x, y = np.meshgrid(generations, along)
        axes.plot_surface(  # type: ignore[attr-defined]
            x,
            y,
            means,
            cmap="viridis",
            rcount=len(along),
            ccount=len(generations),
            linewidth=0.1,
            antialiased=True,
        )
        axes.set_xlabel("generations")
        axes.set_ylabel(
            axis.removeprefix("evolution.").replace("_", " ")
            + " size" * (axis == "evolution.population")
        )
        axes.set_zlabel("mean best score")  # type: ignore[attr-defined]
        lowest, highest = min(0.0, float(np.nanmin(means))), float(np.nanmax(means))
        low, *_, high = MaxNLocator(5).tick_values(lowest, highest)
        axes.set_zlim(low, high)  # type: ignore[attr-defined]
        for one in (axes.xaxis, axes.yaxis, axes.zaxis):  # type: ignore[attr-defined]
            one.set_major_locator(MaxNLocator(5))
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
        if (along % 1 == 0).all():
            axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
        axes.set_box_aspect(None, zoom=0.88)  # type: ignore[call-arg]
        axes.view_init(elev=24, azim=-128)  # type: ignore[attr-defined]
        axes.set_title(
            f"{experiment}, mean of {study.repeats} repeat{'s' * (study.repeats > 1)}",
            fontsize="medium",
            y=0.95,
        )
    save(figure, path)

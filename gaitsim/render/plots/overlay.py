"""Plot several runs in one figure."""

from collections.abc import Sequence
from pathlib import Path

from gaitsim.errors import RunError
from gaitsim.render.plots.components import finite
from gaitsim.render.plots.labels import head, shortened
from gaitsim.render.plots.style import LIGHT, WIDTH, Theme, check_target, save, styled
from gaitsim.study.compare_runs import ComparedRun


def plot_overlay(
    courses: Sequence[ComparedRun], quantity: str, by: str, path: Path, theme: Theme = LIGHT
) -> None:
    """Draw a line a run, with a dot where a stage begins.

    Args:
        courses: of the runs.
        quantity: one of `gaitsim.study.compare_runs.QUANTITIES`.
        by: one of `gaitsim.study.compare_runs.AXES`.
        path: the file.
        theme: its colours.

    Raises:
        RunError: none of the runs has a generation yet, or the file cannot be written.
        GaitsimError: the file's suffix is not a known format.
    """
    from matplotlib.figure import Figure

    check_target(path)
    drawn = [one for one in courses if one.history]
    if not drawn:
        raise RunError("none of these runs has a finished generation yet")
    with styled(theme):
        figure = Figure(figsize=(WIDTH, 2.4))
        axes = figure.subplots()
        for index, one in enumerate(drawn):
            x, y = one.axis(by), finite(one.history[quantity])
            begun = [first - 1 for first, _ in one.stages[1:] if first <= len(x)]
            axes.plot(
                x,
                y,
                label=shortened(one.label, 40),
                marker="." if begun or len(x) == 1 else None,
                markevery=begun or [0],
                **theme.line(index),
            )
        axes.margins(x=0)
        axes.set_xlabel(f"{by} (s)" if by == "seconds" else by)
        axes.set_ylabel(quantity if quantity == "diversity" else f"{quantity} score")
        head(figure, f"{len(drawn)} runs", *axes.get_legend_handles_labels())
    save(figure, path, theme)

"""Plot a front: the compromises between the objectives of a search."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Members, NothingToPlotError
from gaitsim.plugin.pictures import (
    WIDTH,
    FrontView,
    Theme,
    add_heading,
    format_number,
    heading_of_run,
    require_front,
    rows_of_panels,
    shorten,
    styled,
)
from gaitsim.plugin.runs import Member, RunSnapshot, command

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_OBJECTIVES = 6  # maximum number of objectives: 15 panels


def front_figure(run: RunSnapshot, theme: Theme) -> "Figure":
    """Plot the members of a front for each pair of objectives.

    With two objectives, a line shows the edge of the dominated region. The other individuals of
    the last generation are faint. The member with the best score is marked, and the first and the
    last member are numbered.
    """
    from matplotlib.figure import Figure

    individual = run.individual(Member(1)) if run.experiment.search.keeps else run.individual()
    require_front(individual)
    view = FrontView.of(run)
    if view is None:
        raise ValueError("the search keeps a front, but the run has no members")
    members, names, directions = view.members, view.names, view.directions
    if len(names) > MAX_OBJECTIVES:
        raise NothingToPlotError(
            f"too many objectives to plot: {len(names)}, which have "
            f"{len(names) * (len(names) - 1) // 2} pairs",
            allowed=f"at most {MAX_OBJECTIVES} objectives",
            remedy=f"write a table, and plot some of its columns: "
            f"{command('members', run.path, '--out', 'front.csv')}",
        )
    labels = {name: _label(name, individual.unit_of(name), directions) for name in names}
    pairs = view.pairs
    with styled(theme):
        columns = min(len(pairs), 3)
        rows = -(-len(pairs) // columns)
        width = WIDTH if columns == 1 else 2.1 * WIDTH
        figure = Figure(figsize=(width, 2.9 if columns == 1 else 0.6 + 2.2 * rows))
        places = rows_of_panels(figure, len(pairs), columns)
        for axes, (across, up) in zip(places, pairs, strict=True):
            _draw_population(axes, view.others[across], view.others[up], theme)
            if len(names) == 2:
                _draw_edge(axes, members, directions[across], theme)
            _draw_members(axes, members, across, up, theme)
            axes.set_xlabel(labels[across])
            axes.set_ylabel(labels[up])
        count = len(members.scores)
        more = f", generation {run.generation}, {count} member{'s' * (count != 1)}"
        add_heading(
            figure,
            heading_of_run(run.path.resolve().name, run.experiment, more),
            *places[0].get_legend_handles_labels(),
        )
    return figure


def _label(name: str, unit: str, directions: Mapping[str, str]) -> str:
    words = {"max": "more is better", "min": "less is better"}[directions[name]]
    inside = ", ".join(part for part in (unit, words) if part)
    return f"{shorten(name, 24)} ({inside})" if inside else shorten(name, 40)


def _draw_population(
    axes: "Axes", across: NDArray[np.float64], up: NDArray[np.float64], theme: Theme
) -> None:
    axes.scatter(across, up, s=7, color=theme.faint, linewidth=0, label="last generation", zorder=2)


def _draw_edge(axes: "Axes", members: Members, direction: str, theme: Theme) -> None:
    """Draw the edge of the region that a front of two objectives dominates."""
    across, up = members.values.values()
    # Between two members, the member with the worse first objective determines the edge.
    axes.step(
        across,
        up,
        where="post" if direction == "min" else "pre",
        color=theme.colours[0],
        linewidth=0.8,
        alpha=0.6,
        zorder=3,
    )


def _draw_members(axes: "Axes", members: Members, across: str, up: str, theme: Theme) -> None:
    x, y = members.values[across], members.values[up]
    axes.scatter(x, y, s=11, color=theme.colours[0], linewidth=0, label="front", zorder=4)
    best = int(np.argmax(members.scores))
    label = f"best score, {format_number(float(members.scores[best]))}: member {best + 1}"
    axes.scatter(
        x[best],
        y[best],
        s=34,
        marker="D",
        facecolor=theme.background,
        edgecolor=theme.colours[1],
        linewidth=1.1,
        label=label,
        zorder=5,
    )
    for index in {0, len(x) - 1} - {best}:
        axes.annotate(
            str(index + 1),
            (x[index], y[index]),
            xytext=(3, 3),
            textcoords="offset points",
            fontsize=6,
            color=theme.ink,
        )

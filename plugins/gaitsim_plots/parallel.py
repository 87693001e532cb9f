"""Plot the members of a front or an archive in parallel coordinates."""

from typing import TYPE_CHECKING

from gaitsim.plugin import NothingToPlotError
from gaitsim.plugin.pictures import ParallelView, Theme, heading_of_run, parallel_figure
from gaitsim.plugin.runs import Individual, RunSnapshot

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def require_members(individual: Individual) -> None:
    """Check that the search of an individual's run keeps a front or an archive."""
    experiment = individual.experiment
    if not experiment.search.keeps:
        name = experiment.entries["search"].name
        raise NothingToPlotError(
            f"the search {name!r} keeps neither a front nor an archive",
            allowed="a search that does, such as nsga-2 or map-elites",
        )


def members_figure(run: RunSnapshot, theme: Theme, measures: tuple[str, ...] = ()) -> "Figure":
    """Plot a line for each member across its objectives or axes, measures, and the score."""
    require_members(run.individual())
    view = ParallelView.of_run(run, measures)
    more = f", generation {run.generation}"
    return parallel_figure(
        view, heading_of_run(run.path.resolve().name, run.experiment, more), theme
    )

"""Maps of designs: the best gaits of a body for many values of its dimensions.

This module imports nothing heavy, as the help of `gaitsim plot` needs it.
"""

from typing import TYPE_CHECKING, Any, ClassVar

from gaitsim.plugin import NothingToPlotError, Plot, Subject

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gaitsim.plugin import Input
    from gaitsim.plugin.runs import Experiment


class DesignPlot(Plot):
    """Score, speed, cost of transport and heat of the designs of a body, with the plateau."""

    title: ClassVar[str] = "Map of designs"
    group: ClassVar[str] = "of a front or an archive"
    input: ClassVar["Input"] = "run"

    def check(self, individual: Any) -> None:
        """Check that the run is a map of designs."""
        _require(individual.experiment)

    def draw(self, subject: Subject) -> "Figure":
        """Return the figure."""
        from gaitsim.plugin.pictures import PLOT_THEMES
        from gaitsim_design.maps import DesignMap
        from gaitsim_design.plots import design_figure

        run = subject.whole_run
        _require(run.experiment)
        return design_figure(DesignMap.of(run), PLOT_THEMES[self.theme])


def _require(experiment: "Experiment") -> None:
    """Check that an experiment is that of a map of designs."""
    from gaitsim_design.search import Designs

    if not isinstance(experiment.search, Designs):
        raise NothingToPlotError(
            "the run is not a map of designs", remedy="'gaitsim design BODY' computes a map"
        )

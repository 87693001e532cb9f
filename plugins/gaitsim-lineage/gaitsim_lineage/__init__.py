"""Lineage: the ancestors of an individual, and which change brought which gain.

This module imports nothing heavy, as the help of `gaitsim plot` needs it.
"""

from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import NothingToPlotError, Plot, Subject

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gaitsim.plugin import Input
    from gaitsim_lineage.lineage import Lineage


class _LinePlot(Plot):
    """A plot of the line of ancestors of an individual."""

    group: ClassVar[str] = "of ancestors"
    input: ClassVar["Input"] = "individual"
    items: ClassVar[str] = "generations"

    def check_among_all(self, subject: Subject) -> None:
        """Leave the plot out, as tracing a line of ancestors may take long."""
        raise NothingToPlotError("it repeats the whole search: ask for it by name")

    def _lineage(self, subject: Subject, explain: int) -> "Lineage":
        from gaitsim_lineage.lineage import lineage

        individual, run = subject.individual, subject.whole_run
        which = individual.generation if individual.member is None else individual.member
        return lineage(run, which, explain=explain, begin=subject.begin, advance=subject.advance)


class LineagePlot(_LinePlot):
    """Scores of the ancestors of an individual, with the largest rises named."""

    title: ClassVar[str] = "Line of ancestors"

    def draw(self, subject: Subject) -> "Figure":
        """Return the figure."""
        from gaitsim.plugin.pictures import PLOT_THEMES
        from gaitsim_lineage.plots import lineage_figure

        return lineage_figure(self._lineage(subject, explain=5), PLOT_THEMES[self.theme])


class GenealogyPlot(_LinePlot):
    """Family tree of the individuals that the search had, with the line of one of them."""

    title: ClassVar[str] = "Family tree"

    def draw(self, subject: Subject) -> "Figure":
        """Return the figure."""
        from gaitsim.plugin.pictures import PLOT_THEMES
        from gaitsim_lineage.plots import genealogy_figure

        return genealogy_figure(self._lineage(subject, explain=0), PLOT_THEMES[self.theme])

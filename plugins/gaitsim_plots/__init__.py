"""The bundled kinds of plots.

Each class declares a kind and its options, and names the function that draws it, which is imported
only then, so that `gaitsim plot --help` needs neither NumPy nor Matplotlib.
"""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from gaitsim.plugin import Names, Pair, Plot, Subject, Window, option

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gaitsim.plugin import Input
    from gaitsim.plugin.runs import Individual


def _function(name: str) -> Callable[..., Any]:
    """Return the function MODULE:FUNCTION."""
    module, _, function = name.partition(":")
    return getattr(import_module(module), function)  # type: ignore[no-any-return]


class BundledPlot(Plot):
    """A plot that a function draws, given the run or individuals, the theme, and the options.

    Attributes:
        function: function that draws the plot, as MODULE:FUNCTION.
        needs: function that checks that an individual has the data; '' for none.
    """

    function: ClassVar[str]
    needs: ClassVar[str] = ""

    def check(self, individual: "Individual") -> None:
        """Check that the individual has the data."""
        if self.needs:
            _function(self.needs)(individual)

    def draw(self, subject: Subject) -> "Figure":
        """Return the figure."""
        data: Any = {
            "run": subject.run,
            "individual": subject.individuals[:1] and subject.individual,
            "individuals": subject.individuals,
        }
        return self.call(data[self.input], subject)

    def call(self, data: Any, subject: Subject) -> "Figure":
        """Call the function with the data and the options."""
        from gaitsim.plugin.pictures import PLOT_THEMES as THEMES

        given = {name: value for name, value in self if name != "theme" and value is not None}
        figure: Figure = _function(self.function)(data, THEMES[self.theme], **given)
        return figure


class RunPlot(BundledPlot):
    """A plot of a whole run."""

    group: ClassVar[str] = "of the evolution"
    input: ClassVar["Input"] = "run"


class KeptPlot(RunPlot):
    """A plot of a front or an archive."""

    group: ClassVar[str] = "of a front or an archive"


class MotionPlot(BundledPlot):
    """A plot of a motion."""

    group: ClassVar[str] = "of the motion"


class WindowedPlot(MotionPlot):
    """A plot of a part of a motion."""

    window: Window | None = option(
        None,
        "part of the motion to plot, in seconds, such as 2:5",
        allowed="START:END in seconds",
        placeholder="START:END",
    )


class FitnessPlot(RunPlot):
    """The best, the mean and the quartiles of the scores over the generations."""

    title: ClassVar[str] = "Fitness curve"
    function: ClassVar[str] = "gaitsim.render.plots.fitness:fitness_figure"


class TermsPlot(RunPlot):
    """The terms of the score over the generations, of the best individual and of the mean."""

    title: ClassVar[str] = "Terms of the score"
    function: ClassVar[str] = "gaitsim_plots.curves:terms_figure"
    scale: Literal["own", "common", "share"] = option(
        "own",
        "vertical scale of the panels: their own, a common one, or each term as a share of all "
        "gains and losses",
    )


class DiversityPlot(RunPlot):
    """The diversity of the genomes and of the scores over the generations."""

    title: ClassVar[str] = "Diversity"
    function: ClassVar[str] = "gaitsim_plots.curves:diversity_figure"


class GenomePlot(RunPlot):
    """The genes of each generation's best individual."""

    title: ClassVar[str] = "Best genomes over time"
    function: ClassVar[str] = "gaitsim_plots.genome:genome_figure"


class SearchPlot(RunPlot):
    """The quantities that the search records, such as coverage."""

    title: ClassVar[str] = "Progress of the search"
    function: ClassVar[str] = "gaitsim_plots.curves:search_figure"
    needs: ClassVar[str] = "gaitsim_plots.curves:require_figures"


class FrontPlot(KeptPlot):
    """The members of a Pareto front."""

    title: ClassVar[str] = "Pareto front"
    function: ClassVar[str] = "gaitsim_plots.front:front_figure"
    needs: ClassVar[str] = "gaitsim.render.plots.data:require_front"


class ParallelPlot(KeptPlot):
    """The members of a front or an archive in parallel coordinates."""

    title: ClassVar[str] = "Parallel coordinates"
    function: ClassVar[str] = "gaitsim_plots.parallel:members_figure"
    needs: ClassVar[str] = "gaitsim_plots.parallel:require_members"
    measures: Names | None = option(
        None,
        "measure of the body that has an axis, besides the objectives and the score; an unknown "
        "name lists all measures",
        placeholder="NAME",
        flag="--measure",
    )


class ArchivePlot(KeptPlot):
    """The best score in each cell of an archive."""

    title: ClassVar[str] = "Archive map"
    function: ClassVar[str] = "gaitsim_plots.archive:archive_figure"
    needs: ClassVar[str] = "gaitsim.render.plots.data:require_archive"
    axes: Pair | None = option(
        None,
        "two axes of the archive",
        unset="all pairs of axes",
        allowed="the names of two axes, such as 'forward, yaw'",
        placeholder="NAME NAME",
    )

    def words(self, subject: Subject) -> tuple[str, ...]:
        """Return the axes."""
        return self.axes or ()


class GaitsPlot(KeptPlot):
    """The best gait of each pattern in an archive."""

    title: ClassVar[str] = "Best gait per pattern"
    function: ClassVar[str] = "gaitsim_plots.feet:gaits_figure"
    needs: ClassVar[str] = "gaitsim_plots.feet:require_gaits"
    items: ClassVar[str] = "members"

    def call(self, data: Any, subject: Subject) -> "Figure":
        """Call the function with the functions that report its progress."""
        from gaitsim.plugin.pictures import PLOT_THEMES as THEMES
        from gaitsim_plots.feet import gaits_figure

        return gaits_figure(data, THEMES[self.theme], subject.begin, subject.advance)


class PathPlot(WindowedPlot):
    """The path of the body from above and from the side."""

    title: ClassVar[str] = "Path from above and side"
    function: ClassVar[str] = "gaitsim_plots.path:path_figure"


class DrawingPlot(MotionPlot):
    """The dimensions of the body from the side and from above, beside the original's."""

    title: ClassVar[str] = "Dimensioned drawing"
    function: ClassVar[str] = "gaitsim_plots.drawing:drawing_figure"


class ChannelPlot(WindowedPlot):
    """A channel of the motion over time."""

    title: ClassVar[str] = "Channel of the motion"
    input: ClassVar["Input"] = "individuals"
    function: ClassVar[str] = "gaitsim_plots.channel:channel_figure"
    needs: ClassVar[str] = "gaitsim_plots.channel:default_channel"
    channel: str | None = option(
        None,
        "channel of the motion to plot, such as 'altitude'; an unknown name lists all channels",
        placeholder="NAME",
    )
    components: Names | None = option(
        None,
        "component of the channel, such as z, 3 or 'L1 coxa'",
        unset="all components",
        placeholder="NAME",
        flag="--component",
    )

    def check_among_all(self, subject: Subject) -> None:
        """Check that no other kind of plot draws the default channel."""
        if self.channel is None:
            _function("gaitsim_plots.channel:check_default_channel")(subject.individual)

    def words(self, subject: Subject) -> tuple[str, ...]:
        """Return the channel and its components."""
        default = _function(self.needs)
        return self.channel or default(subject.individual), *(self.components or ())


class FootfallPlot(WindowedPlot):
    """When each foot is on the ground."""

    title: ClassVar[str] = "Footfalls"
    function: ClassVar[str] = "gaitsim_plots.feet:footfall_figure"
    needs: ClassVar[str] = "gaitsim_plots.feet:contacts_of"


class PhasePlot(MotionPlot):
    """The phases of the feet within a stride."""

    title: ClassVar[str] = "Phases of the feet"
    function: ClassVar[str] = "gaitsim_plots.phase:phase_figure"
    needs: ClassVar[str] = "gaitsim_plots.phase:stride_of"


class JointsPlot(WindowedPlot):
    """The angles of the joints over time."""

    title: ClassVar[str] = "Joint angles"
    function: ClassVar[str] = "gaitsim_plots.joints:joints_figure"
    needs: ClassVar[str] = "gaitsim_plots.joints:require_joints"
    channel: str | None = option(
        None,
        "channel of the joints to plot, such as 'torque'",
        unset="their angles",
        placeholder="NAME",
    )

    def words(self, subject: Subject) -> tuple[str, ...]:
        """Return the channel."""
        return (self.channel,) if self.channel else ()


class StabilityPlot(WindowedPlot):
    """The static stability margin over time."""

    title: ClassVar[str] = "Stability margin"
    function: ClassVar[str] = "gaitsim_plots.feet:stability_figure"
    needs: ClassVar[str] = "gaitsim_plots.feet:contacts_of"


class FeedbackPlot(WindowedPlot):
    """Commands, the changes of reflexes, and the yaw over time."""

    title: ClassVar[str] = "Commands and reflexes"
    function: ClassVar[str] = "gaitsim_plots.feedback:feedback_figure"
    needs: ClassVar[str] = "gaitsim_plots.feedback:require_feeling"

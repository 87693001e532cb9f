"""Plot the best gait of each pattern in an archive."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from gaitsim.gait.repertoire import RepertoireGait, gaits_of, patterns
from gaitsim.gait.report import frames_before_fall
from gaitsim.individual import Individual, Member
from gaitsim.render.plots.data import require_archive, window_slice
from gaitsim.render.plots.labels import add_heading, format_number, heading_of_run, shorten
from gaitsim.render.plots.panels import draw_bars
from gaitsim.render.plots.style import WIDTH, Theme, styled
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim_plots.footfall import contacts_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SECONDS = 2.0  # length of each footfall diagram
_NAMES = {"none": "no name"}
_FOOT = 0.055  # height of a foot's row, inches


def require_gaits(individual: Individual) -> None:
    """Check that an individual's run has an archive and its body has feet."""
    require_archive(individual)
    contacts_of(individual)


def gaits_figure(
    run: RunSnapshot,
    theme: Theme,
    begin: Callable[[int], object] = lambda total: None,
    advance: Callable[[int], object] = lambda done: None,
) -> "Figure":
    """Plot a row for each pattern of gait: footfalls and score of its best member, and its cells.

    Gaits without a name come last. The footfalls cover the last seconds before a fall, with
    left feet above right feet as in the plot of a single gait.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    best = run.individual(Member(1)) if run.experiment.search.keeps else run.individual()
    require_gaits(best)
    members = run.members
    assert members is not None, "a search with a first member has members"
    total = len(members.scores)
    begin(total)
    gaits: list[RepertoireGait] = []
    for part in gaits_of(best.experiment, members.genomes):
        gaits += part
        advance(len(part))
    found = patterns(gaits, members.scores)
    with styled(theme):
        feet = contacts_of(best)[0].shape[1]
        height = max(_FOOT * feet + 0.08, 0.34)
        figure = Figure(figsize=(1.5 * WIDTH, 0.75 + height * len(found)))
        strips, scores = figure.subplots(
            len(found), 2, width_ratios=[1.7, 1], squeeze=False
        ).T.tolist()
        low = min(0.0, *(one.score for one in found))
        high = max(0.0, *(one.score for one in found))
        for pattern, strip, bar in zip(found, strips, scores, strict=True):
            member = run.individual(Member(pattern.member))
            _draw_footfalls(strip, member, theme)
            share = f"{max(pattern.count / total, 0.001):.1%}"
            share = f"<{share}" if pattern.count < 0.001 * total else share
            name = shorten(_NAMES.get(pattern.name, pattern.name), 26)
            strip.set_ylabel(
                f"{name}\nmember {pattern.member}",
                rotation=0,
                ha="right",
                va="center",
            )
            _draw_score(bar, pattern.score, theme)
            bar.set_xlim(low - 0.02 * (high - low), high + 0.95 * (high - low))
            cells = f"{pattern.count:,} cell{'s' * (pattern.count > 1)}"
            bar.annotate(
                f"{format_number(pattern.score)}\n{cells}, {share}",
                (max(pattern.score, 0.0), 0),
                xytext=(3, 0),
                textcoords="offset points",
                va="center",
                fontsize=7,
            )
        ticks = [tick for tick in scores[-1].get_xticks() if low <= tick <= high]
        for bar in scores:  # no ticks below the annotations
            bar.set_xticks(ticks)
        for column in (strips, scores):
            for axes in column[:-1]:
                axes.tick_params(labelbottom=False, bottom=False)
                axes.spines["bottom"].set_visible(False)
        strips[-1].set_xlabel("time (s)")
        unit = best.experiment.fitness.unit
        scores[-1].set_xlabel(f"best score ({unit})" if unit else "best score")
        figure.align_ylabels()
        more = f", generation {run.generation}, {total:,} members"
        colours = theme.foot_colours(contacts_of(best)[1])
        sides = {"left feet, front to back": theme.left, "right feet": theme.right}
        shown = {name: Patch(facecolor=one) for name, one in sides.items() if one in colours}
        width = figure.get_figwidth()
        heading = heading_of_run(run.path.resolve().name, run.experiment, more, width)
        add_heading(figure, heading, [*shown.values()], [*shown])
    return figure


def _draw_footfalls(axes: "Axes", member: Individual, theme: Theme) -> None:
    touching, names = contacts_of(member)
    rate = member.skeleton.frame_rate
    part = window_slice(frames_before_fall(member), rate, None, _SECONDS)
    shown = touching[part]
    rows = [("", shown[:, foot]) for foot in range(len(names))]
    draw_bars(axes, rows, 0.0, rate, theme.foot_colours(names))
    axes.set_yticks([])
    axes.set_xlim(0, _SECONDS)


def _draw_score(axes: Any, score: float, theme: Theme) -> None:
    axes.barh([0], [score], height=0.5, color=theme.colours[0], linewidth=0)
    axes.axvline(0, color=theme.ink, linewidth=0.6)
    axes.set_ylim(-0.6, 0.6)
    axes.set_yticks([])
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)

"""Print an archive as a map."""

from gaitsim.console.characters import lines
from gaitsim.console.printing import output
from gaitsim.console.streams import results
from gaitsim.contracts import Members
from gaitsim.errors import GaitsimError, RunError, unknown
from gaitsim.individual import Member
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.heat_map import HeatMap, axis_labels, styles, summary
from gaitsim.runs.files.folder import command
from gaitsim.runs.snapshot import RunSnapshot

WIDEST, HIGHEST = 80, 36  # characters, at most, in a terminal
PIPED = 80, 30  # characters, if the output is not a terminal


def print_map(run: RunSnapshot, members: Members, axes: tuple[str, str] | None) -> None:
    """Print an archive as a map along two axes, with the best member marked.

    Args:
        run: run that keeps the archive.
        members: elites of the archive.
        axes: names of the two axes; None chooses the first pair.
    """
    view = ArchiveView.of(members)
    if view is None:
        raise RunError(
            f"the run {run.path} keeps a front, which has no map",
            remedy=f"plot it: {command('plot', run.path, '--kind', 'front')}",
        )
    for name in axes or ():
        if name not in view.names:
            raise unknown("axis", name, view.names, where="--axes")
    if axes is not None and axes[0] == axes[1]:
        raise GaitsimError("the two axes of a map must differ", where="--axes")
    names = axes or next(iter(view.pairs), view.names)
    console = output()
    console.print(f"{run.path}: {summary(run, view)}", style="bold")
    if not len(members.scores):
        console.print("Every individual failed.")
        return
    terminal = results().isatty()
    width = min(console.width, WIDEST) if terminal else PIPED[0]
    height = min(console.height - 4, HIGHEST) if terminal else PIPED[1]
    shaded = console.no_color or console.color_system is None
    words = axis_labels(run.individual(Member(1)), view)
    drawn = HeatMap(view, names, words, width, height, shaded=shaded)
    if not drawn.fits:
        raise GaitsimError("the terminal is too small for a map", remedy="enlarge it")
    best = view.best
    assert best is not None, "an archive with members has a best one"
    for line in lines(*drawn.draw(drawn.place_of(best)), styles("default", "bright_black")):
        line.rstrip()
        if line.plain:
            console.print(line)
    mark = "◆" if shaded else "▸ ▴"
    console.print(f"{mark} member {best}, the best: {command('play', run.path, '--member', best)}")

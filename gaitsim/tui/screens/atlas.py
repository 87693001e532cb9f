"""Map: the archive of a run as a heat map and the gait under the cursor."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import wrap

from gaitsim.individual import Which
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.heat_map import summary
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.members import MembersScreen
from gaitsim.tui.screens.members_source import KeptMembers, MembersReader
from gaitsim.tui.widgets.member_plot import ArchiveMap

BEHAVIOUR = 3  # maximum lines of behaviour below the map
_JOINED = "\N{NO-BREAK SPACE}"  # prevents a line break
_MISSING = (
    "archive and no front",
    "evolve with the search 'map-elites' or 'nsga-2', as in the presets 'spider-atlas' and "
    "'spider-front'",
)


class Map(MembersScreen[ArchiveView]):
    """The archive of a run along two of its axes, with the elite under the cursor in motion.

    Args:
        run: folder of the run.
        which: member initially under the cursor; the best if it is not a member.
    """

    HELP_TEXT = """
All gaits that a search has found, as a map of two axes: the colour of a cell is its best score;
dots are cells without a gait.

- **Arrow keys** or a click choose a gait. It moves on the right, with its name, footfalls and
  measures. Below the map are its number, score and position on all axes.
- **Axes**: with more than two axes, each cell shows the best score over the other axes. `]` and
  `[` step through pairs of axes, opposite legs first; `x` and `z` change one axis.
- **Best** selects the best gait, **Go to** a gait by its number.
- While the run evolves, the map fills, and the numbers of members change.
- **Replay**, **Why**, **Export** and the **Laboratory** apply to the gait under the cursor.
- The title shows the generation, the number and share of cells with a gait (the coverage), and the
  sum of all scores (the QD score).
"""
    BINDINGS = bindings("map")

    def __init__(self, run: Path, which: Which = None) -> None:
        reader = MembersReader(run, lambda found: ArchiveView.of(found.members), _MISSING)
        super().__init__(run, which, ArchiveMap("reading the run …"), reader)
        self.sub_title = "map"

    def summary(self, kept: KeptMembers[ArchiveView]) -> str:
        return summary(kept.run, kept.view)

    def describe_values(
        self, kept: KeptMembers[ArchiveView], member: int, width: int
    ) -> Sequence[str]:
        """Return the words that all names of axes share, then each axis with the value."""
        values, names = kept.view.members.values, kept.view.names
        shared = shared_prefix(names)
        items = [
            visible(name.removeprefix(shared)).replace(" ", _JOINED)
            + _JOINED
            + number(float(values[name][member - 1]), 2)
            for name in names
        ]
        text = " ".join([visible(shared.strip()), *items]) if shared else "  ".join(items)
        return wrap(text, width)[:BEHAVIOUR]


def shared_prefix(names: Sequence[str]) -> str:
    """Return the words that begin all names, with the trailing space."""
    first, last = min(names), max(names)
    alike = [one == other for one, other in zip(first, last, strict=False)]
    shared = first[: [*alike, False].index(False)] if len(names) > 1 else ""
    return shared[: shared.rfind(" ") + 1]

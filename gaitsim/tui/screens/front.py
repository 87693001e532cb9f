"""Front: the members of a Pareto front as a scatter plot and the gait under the cursor."""

from collections.abc import Sequence
from pathlib import Path

from rich.cells import set_cell_size

from gaitsim.individual import Member, Which
from gaitsim.render.front_view import FrontView
from gaitsim.render.terminal.scatter import summary
from gaitsim.render.terminal.text import number, visible
from gaitsim.tui.formatting import clip
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.members import MembersScreen
from gaitsim.tui.screens.members_source import KeptMembers, MembersReader
from gaitsim.tui.widgets.member_plot import FrontScatter

MARKS = "AB"  # characters of marked members
DIGITS = 4
LISTED = 6  # maximum number of objectives listed below the plot
_MISSING = "front", "evolve with the search 'nsga-2', as in the preset 'spider-front'"


class Front(MembersScreen[FrontView]):
    """The front of a run along two objectives, with the member under the cursor in motion.

    Args:
        run: folder of the run.
        which: member initially under the cursor; the best if it is not a member.
    """

    HELP_TEXT = """
The compromises that a search has found, along two objectives. The arrow beside the name of an axis
points to better values. No other individual is at least as good as a member of the front in every
objective, and better in one. The fainter dots are the other individuals of the last generation;
**Others** hides them, and the axes then fit the front.

- **Arrow keys** or a click choose the nearest member in a direction; `,` and `.` step along the
  front by number. The member moves on the right, with its name, footfalls and measures. Below the
  plot are its objectives.
- **Axes**: with more than two objectives, `]` and `[` step through pairs of objectives, `x` and `z`
  change one axis, and the colour is another objective; `c` chooses it.
- **Mark** two members to compare their objectives, and to **Replay** them side by side.
- **Best** selects the member with the best score, **Go to** a member by its number.
- While the run evolves, the front moves, and the numbers of members change.
- **Replay**, **Why**, **Export** and the **Laboratory** apply to the gait under the cursor.
"""
    BINDINGS = bindings("front")

    def __init__(self, run: Path, which: Which = None) -> None:
        self._plot = FrontScatter("reading the run …")
        super().__init__(run, which, self._plot, MembersReader(run, FrontView.of, _MISSING))
        self._marked: list[bytes] = []  # keys of the marked members, the latest last
        self.sub_title = "front"

    def summary(self, kept: KeptMembers[FrontView]) -> str:
        return summary(kept.run, kept.view)

    @property
    def _colours(self) -> list[str]:
        """The objectives that are not on an axis."""
        names = self._kept.view.names if self._kept is not None else ()
        return [name for name in names if name not in self._pair]

    @property
    def marked(self) -> list[int]:
        """The numbers of the marked members that the front still contains."""
        kept = self._kept
        if kept is None or not self._marked:
            return []
        count = len(kept.view.members.scores)
        numbers = {kept.key(number): number for number in range(1, count + 1)}
        return [numbers[key] for key in self._marked if key in numbers]

    def _show(self, member: int | None) -> None:
        colours = self._colours
        if self._plot.colour not in colours:
            self._plot.colour = next(iter(colours), "")
        self._plot.marks = dict(zip(self.marked, MARKS, strict=False))
        super()._show(member)

    def describe_values(
        self, kept: KeptMembers[FrontView], member: int, width: int
    ) -> Sequence[str]:
        """Return a line for each objective: its name, values of the members, unit and direction."""
        view, units = kept.view, self._reader.units
        marked = dict(zip(self.marked, MARKS, strict=False))
        numbers = [member, *marked]
        names = view.names[:LISTED]
        columns = [
            [number(float(view.members.values[name][at - 1]), DIGITS) for name in names]
            for at in numbers
        ]
        heads = ["", *(f"{mark} {at:,}" for at, mark in marked.items())]
        wide = [max(map(len, [head, *one])) for head, one in zip(heads, columns, strict=True)]
        ends = [
            f" {clip(units.get(name, ''), 8)}".rstrip()
            + (" ↑" if view.directions[name] == "max" else " ↓")
            for name in names
        ]
        room = width - sum(wide) - 2 * len(wide) - max(map(len, ends))
        longest = max(4, min(room, max(len(visible(name)) for name in names)))

        def line(name: str, cells: Sequence[str], end: str) -> str:
            cells = [cell.rjust(size) for cell, size in zip(cells, wide, strict=True)]
            return "  ".join([set_cell_size(clip(name, longest), longest), *cells]) + end

        rows = zip(names, zip(*columns, strict=True), ends, strict=True)
        head = [line("", heads, "")] if marked else []
        return [*head, *(line(name, cells, end) for name, cells, end in rows)]

    def action_along(self, steps: int) -> None:
        """Move along the front, in the order of the numbers of members."""
        if self._kept is not None and self.plot.member is not None:
            count = len(self._kept.view.members.scores)
            self.plot.go_to(min(max(self.plot.member + steps, 1), count))

    def action_colour(self) -> None:
        """Show the next objective by colour."""
        colours = self._colours
        at = colours.index(self._plot.colour) if self._plot.colour in colours else -1
        self._plot.colour = colours[(at + 1) % len(colours)]
        self._turn(self._pair)

    def action_others(self) -> None:
        """Show or hide the other individuals of the last generation."""
        self._plot.others = not self._plot.others
        self._turn(self._pair)

    def action_mark(self) -> None:
        """Mark the member under the cursor, or remove its mark; two at most."""
        assert self._kept is not None
        assert self.plot.member is not None
        key = self._kept.key(self.plot.member)
        kept = [one for one in self._marked if one != key]
        if len(kept) == len(self._marked):
            kept = [*kept, key][-len(MARKS) :]
        self._marked = kept
        self._turn(self._pair)

    def action_replay(self) -> None:
        """Replay the member under the cursor, or the two marked ones side by side."""
        marked = self.marked
        if len(marked) == len(MARKS):
            first, second = map(Member, marked)
            self.show_screen("replay.Replay", self.run, first, self.run, beside_which=second)
        else:
            super().action_replay()

    def obstacle(self, action: str) -> str:
        if action == "colour" and not (self.is_mounted and len(self._colours) > 1):
            return "There is no other objective to show by colour."
        return super().obstacle(action)

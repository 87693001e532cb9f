"""Data of maps and fronts: the members of a run that may be evolving, and each in motion."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic

from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait import analyse_individual
from gaitsim.gait.naming import Name
from gaitsim.individual import Member
from gaitsim.render.terminal.member_picture import units_of
from gaitsim.storage.growing import RunFollower
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.screens.replay_loading import ReplayView, load_individual
from gaitsim.tui.widgets.member_plot import V

CACHED = 64  # maximum number of members in memory, about 0.5 MB each


@dataclass(frozen=True, eq=False)
class KeptMembers(Generic[V]):
    """The members of a run at one moment.

    Attributes:
        run: snapshot of the run.
        view: view of its members.
    """

    run: RunSnapshot
    view: V

    def key(self, member: int) -> bytes:
        """Return a key of a member that does not change when members are renumbered."""
        genome: bytes = self.view.members.genomes[member - 1].tobytes()
        return len(self.run.stages).to_bytes(4, "little") + genome


MovingMember = tuple[ReplayView, Name | None]
"""Body and measures of a member, and the name of its gait; None if its feet do not define one."""


class MembersReader(Generic[V]):
    """The members of a run, re-read when the run has new generations.

    Args:
        path: folder of the run.
        view_of: function that returns the view of a run's members; None if it has none.
        missing: what a run without a view lacks, such as 'archive', and a remedy.

    Attributes:
        units: units of the score and of the axes by name, once a member has been simulated.
    """

    def __init__(
        self, path: Path, view_of: Callable[[RunSnapshot], V | None], missing: tuple[str, str]
    ) -> None:
        self._path, self._view_of, self._missing = path, view_of, missing
        self._follower = RunFollower(path)
        self._members: OrderedDict[bytes, MovingMember] = OrderedDict()
        self.units: dict[str, str] = {}

    def poll(self) -> KeptMembers[V] | None:
        """Return the current members; None if the run has not changed."""
        try:
            run = self._follower.poll()
            if run is None:
                return None
            view = self._view_of(run)
        except OSError as error:
            raise RunError(f"cannot read {self._path}: {error.strerror or error}") from None
        if view is None:
            name = run.experiment.entries["search"].name
            what, remedy = self._missing
            raise RunError(
                f"the search {name!r} keeps no {what}", where=str(self._path), remedy=remedy
            )
        return KeptMembers(run, view)

    def cached(self, kept: KeptMembers[V], member: int) -> MovingMember | None:
        """Return a member if it is in memory, else None."""
        return self._members.get(kept.key(member))

    def load(self, kept: KeptMembers[V], member: int) -> MovingMember:
        """Simulate a member and name its gait."""
        shown = load_individual(kept.run, Member(member))
        try:
            gait = analyse_individual(shown.individual).name
        except GaitsimError:
            gait = None
        self.units = units_of(shown.individual, kept.view.names)
        moving = self._members[kept.key(member)] = shown, gait
        if len(self._members) > CACHED:
            self._members.popitem(last=False)
        return moving

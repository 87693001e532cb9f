"""Data of the map: the archive of a run that may be evolving and its elites in motion."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait import analyse_individual
from gaitsim.gait.naming import Name
from gaitsim.individual import Member
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.heat_map import axis_labels, summary
from gaitsim.render.terminal.text import number, visible
from gaitsim.storage.growing import RunFollower
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.screens.replay_loading import LoadedIndividual, load_individual

_JOINED = "\N{NO-BREAK SPACE}"  # prevents a line break
CACHED = 64  # maximum number of elites in memory, about 0.5 MB each


@dataclass(frozen=True, eq=False)
class Atlas:
    """The archive of a run at one moment.

    Attributes:
        run: snapshot of the run.
        view: view of its archive.
    """

    run: RunSnapshot
    view: ArchiveView

    @property
    def summary(self) -> str:
        """The generation, number of elites, coverage and QD score, in words."""
        return summary(self.run, self.view)

    def behaviour(self, member: int) -> list[str]:
        """Return the words that all axis names share, then each axis with the member's value."""
        values, names = self.view.members.values, self.view.names
        shared = shared_prefix(names)
        return [
            visible(shared.strip()),
            *(
                visible(name.removeprefix(shared)).replace(" ", _JOINED)
                + _JOINED
                + number(float(values[name][member - 1]), 2)
                for name in names
            ),
        ]


@dataclass(frozen=True, eq=False)
class Elite:
    """A member in motion.

    Attributes:
        shown: body and measures of the member.
        gait: name of its gait; None if the feet of the body do not define one.
    """

    shown: LoadedIndividual
    gait: Name | None


class AtlasReader:
    """The archive of the run in the folder `path`, re-read when the run has new generations."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._follower = RunFollower(path)
        self._labels: dict[str, str] = {}
        self._elites: OrderedDict[bytes, Elite] = OrderedDict()

    def poll(self) -> Atlas | None:
        """Return the current archive; None if the run has not changed."""
        try:
            run = self._follower.poll()
            if run is None:
                return None
            view = ArchiveView.of(run.members)
        except OSError as error:
            raise RunError(f"cannot read {self._path}: {error.strerror or error}") from None
        if view is None:
            name = run.experiment.entries["search"].name
            raise RunError(
                f"the search {name!r} keeps no archive",
                where=str(self._path),
                remedy="evolve with the search 'map-elites', as in the preset 'spider-atlas'",
            )
        return Atlas(run, view)

    def labels(self, atlas: Atlas) -> dict[str, str]:
        """Return labels of the axes and the score, with units once an elite has been simulated."""
        plain = {name: name for name in ("score", *atlas.view.names)}
        return plain | self._labels

    def cached(self, atlas: Atlas, member: int) -> Elite | None:
        """Return a member if it is in memory, else None."""
        return self._elites.get(_key(atlas, member))

    def elite(self, atlas: Atlas, member: int) -> Elite:
        """Simulate a member and name its gait."""
        shown = load_individual(atlas.run, Member(member))
        try:
            gait = analyse_individual(shown.individual).name
        except GaitsimError:
            gait = None
        self._labels = axis_labels(shown.individual, atlas.view)
        elite = self._elites[_key(atlas, member)] = Elite(shown, gait)
        if len(self._elites) > CACHED:
            self._elites.popitem(last=False)
        return elite


def shared_prefix(names: Sequence[str]) -> str:
    """Return the words that begin all names, with the trailing space."""
    first, last = min(names), max(names)
    alike = [one == other for one, other in zip(first, last, strict=False)]
    shared = first[: [*alike, False].index(False)] if len(names) > 1 else ""
    return shared[: shared.rfind(" ") + 1]


def _key(atlas: Atlas, member: int) -> bytes:
    """Return a key of a member that does not change when members are renumbered."""
    genome: bytes = atlas.view.members.genomes[member - 1].tobytes()
    return len(atlas.run.stages).to_bytes(4, "little") + genome

"""What the map shows: the archive of a run that may grow, and its elites in motion."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gaitsim.errors import GaitsimError, RunError
from gaitsim.gait import analyse_individual
from gaitsim.gait.naming import Name
from gaitsim.individual import Member
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.atlas_words import summary, words_of
from gaitsim.render.terminal.text import number, visible
from gaitsim.runs.follow import RunFollower
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.tui.screens.replay_loading import Shown, shown_of

_JOINED = "\N{NO-BREAK SPACE}"  # no line is broken there
KEPT = 64  # elites whose motion is kept, about 0.5 MB each


@dataclass(frozen=True, eq=False)
class Atlas:
    """The archive of a run at one moment.

    Attributes:
        run: as it was read.
        view: its archive.
    """

    run: RunSnapshot
    view: ArchiveView

    @property
    def summary(self) -> str:
        """Generation, elites, coverage and QD score, in words."""
        return summary(self.run, self.view)

    def behaviour(self, member: int) -> list[str]:
        """Return the words that all axes share, and each axis with the value of a member."""
        values, names = self.view.members.values, self.view.names
        shared = shared_words(names)
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
        shown: its body and measures.
        gait: its name; None of a body whose feet say nothing.
    """

    shown: Shown
    gait: Name | None


class AtlasReader:
    """The archive of the run in the folder `path`, read again when the run has grown."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._follower = RunFollower(path)
        self._words: dict[str, str] = {}
        self._elites: OrderedDict[bytes, Elite] = OrderedDict()

    def poll(self) -> Atlas | None:
        """Return the archive as it is now; None where the run has not changed.

        Raises:
            RunError: the search keeps no archive, or the run cannot be read.
            GaitsimError: its experiment has problems.
        """
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
                f"the search {name!r} of this run keeps no archive, so there is no map",
                remedy="evolve with map-elites, as the preset spider-atlas does",
            )
        return Atlas(run, view)

    def words(self, atlas: Atlas) -> dict[str, str]:
        """Return the axes and the score as the map has them: with units once an elite moved."""
        plain = {name: name for name in ("score", *atlas.view.names)}
        return plain | self._words

    def kept(self, atlas: Atlas, member: int) -> Elite | None:
        """Return a member that was moved before; None where it was not."""
        return self._elites.get(_key(atlas, member))

    def elite(self, atlas: Atlas, member: int) -> Elite:
        """Move a member, and name its gait.

        Raises:
            GaitsimError: the body cannot be moved or drawn.
        """
        shown = shown_of(atlas.run, Member(member))
        try:
            gait = analyse_individual(shown.individual).name
        except GaitsimError:
            gait = None
        self._words = words_of(shown.individual, atlas.view)
        elite = self._elites[_key(atlas, member)] = Elite(shown, gait)
        if len(self._elites) > KEPT:
            self._elites.popitem(last=False)
        return elite


def shared_words(names: Sequence[str]) -> str:
    """Return the words with which all of several names begin, with the space after them."""
    first, last = min(names), max(names)
    alike = [one == other for one, other in zip(first, last, strict=False)]
    shared = first[: [*alike, False].index(False)] if len(names) > 1 else ""
    return shared[: shared.rfind(" ") + 1]


def _key(atlas: Atlas, member: int) -> bytes:
    """Return what stays the same where others become members, and their numbers change."""
    genome: bytes = atlas.view.members.genomes[member - 1].tobytes()
    return len(atlas.run.stages).to_bytes(4, "little") + genome

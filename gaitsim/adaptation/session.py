"""The trials of an adaptation in the folder of its atlas: `adaptations/NAME.json`."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import ClassVar, Literal

from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.adaptation.settings import MOST_TRIALS, Settings
from gaitsim.adaptation.trials import Trial
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation.scoring import LARGEST_SCORE
from gaitsim.opening import read_regular
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import ADAPTATIONS, own_folder
from gaitsim.runs.files.schema import EXACT_KEYS, first_problem
from gaitsim.toml import checksum

LARGEST = 1_000_000  # bytes
_REMEDY = "remove it, or begin again with --fresh"
_NAME = re.compile(r"[^\W_][\w.-]{0,99}", re.ASCII)

Place = Literal["simulation", "physics", "robot"]
"""Where trials are made: in simulation, on the physical twin, or on a robot by a person."""


@dataclass(frozen=True)
class Session:
    """What is adapted and how, and the trials so far.

    Attributes:
        atlas: checksum of the members of the atlas, see `prior.checksum_of`.
        place: where the trials are made.
        damage: of the simulated body, in alphabetical order.
        measure: name of the measure that is the performance.
        settings: of the adaptation.
        trials: in their order.
        intact: what the most promising gaits measured on the intact twin, by member, for trials
            in physics; {} before they are measured.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    atlas: str
    place: Place
    damage: tuple[str, ...]
    measure: str
    settings: Settings
    trials: tuple[Trial, ...] = ()
    intact: dict[int, float] = field(default_factory=dict)


_SESSION = TypeAdapter(Session)


def session_file(run: Path, name: str) -> Path:
    """Return the file of a session.

    Raises:
        GaitsimError: no file can have this name.
        RunError: the folder cannot be created, or is a link.
    """
    if not _NAME.fullmatch(name):
        raise GaitsimError(
            f"{name!r:.120} cannot be the name of an adaptation",
            where="name",
            allowed="up to 100 letters, digits, '-', '_' and '.', a letter or digit first",
        )
    return own_folder(run, ADAPTATIONS) / f"{name}.json"


def default_name(place: Place, damage: Sequence[str]) -> str:
    """Return the name of a session that is given none, such as 'L2-lost' or 'robot'."""
    parts = ["-".join(re.findall(r"[a-zA-Z0-9.-]+", text)) for text in damage]
    if place != "simulation" or not parts:
        parts.append(place)
    name = "_".join(filter(None, parts))
    return name if _NAME.fullmatch(name) else f"damage-{checksum(name)[:12]}"


def canonical(damage: Sequence[str]) -> tuple[str, ...]:
    """Return damage in alphabetical order, with single spaces; one text is one damage."""
    texts = [damage] if isinstance(damage, str) else damage
    return tuple(sorted(" ".join(text.split()) for text in texts))


def read_session(path: Path) -> Session | None:
    """Read a session; None without a file.

    Raises:
        RunError: it is damaged, or cannot be read.
    """
    try:
        session = _SESSION.validate_json(read_regular(path, LARGEST), strict=True)
        reason = _contradiction(session)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}", remedy=_REMEDY) from None
    except ValidationError as error:
        key, what = first_problem(error, "adaptation")
        reason = f"{key}: {what}"
    except GaitsimError as error:  # of the settings
        reason = error.what
    if reason:
        raise RunError(f"{path} is damaged: {reason}", remedy=_REMEDY)
    return session


def replace_session(path: Path, read: Session | None, session: Session) -> None:
    """Write a session in place of the one that was read from its file.

    Raises:
        RunError: another process has changed the file since, or it cannot be written.
    """
    if read_session(path) != read:
        raise RunError(
            f"{path} has changed meanwhile: another process adapts with it",
            remedy="run the same command again, which continues it, or choose another --name",
        )
    write_session(path, session)


def write_session(path: Path, session: Session) -> None:
    """Write a session atomically, whatever its file holds.

    Raises:
        RunError: it cannot be written.
    """
    write_bytes(path, _SESSION.dump_json(session, indent=1) + b"\n", follow=False)


def mismatch(found: Session, wanted: Session) -> str:
    """Return by what a session differs from the wanted one so that it cannot continue, or ''.

    More trials, or another condition to stop, are no difference: the trials before are the same.
    """
    if found.atlas != wanted.atlas:
        return "the atlas has changed since"
    for name in ("place", "damage", "measure"):
        one, other = getattr(found, name), getattr(wanted, name)
        if one != other:
            return f"its {name} is {_words(one)}, not {_words(other)}"
    for name in (one.name for one in fields(Settings)):
        one, other = (getattr(session.settings, name) for session in (found, wanted))
        if one != other and name not in ("trials", "stop"):
            return f"its {name.replace('_', ' ')} is {one:g}, not {other:g}"
    return ""


def _words(value: str | tuple[str, ...]) -> str:
    return repr(value) if isinstance(value, str) else ", ".join(value) or "none"


def _contradiction(session: Session) -> str:
    """Return what no adaptation writes, or ''."""
    trials = session.trials
    if len(trials) > MOST_TRIALS:
        return f"it has {len(trials)} trials, of at most {MOST_TRIALS}"
    if [trial.number for trial in trials] != [*range(1, len(trials) + 1)]:
        return "its trials are not numbered in order"
    members = [trial.member for trial in trials]
    if len({*members}) < len(members) or not all(0 < member < 2**40 for member in members):
        return "its trials are not of different members"
    numbers = (
        value for trial in trials for value in (trial.expected, trial.deviation, trial.measured)
    )
    if not all(abs(value) < LARGEST_SCORE for value in (*numbers, *session.intact.values())):
        return "a measured value is not a finite number"
    if session.intact and not max(session.intact.values()) > 0:
        return "no gait walks on the intact twin"
    return ""

"""The file that stores an adaptation in the folder of its atlas: `adaptations/NAME.json`."""

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
from gaitsim.runs.files.folder import ADAPTATIONS, create_subfolder
from gaitsim.runs.files.schema import EXACT_KEYS, first_problem
from gaitsim.toml import checksum

LARGEST = 1_000_000  # bytes
REMEDY = "delete the file, or start over with --fresh"
_NAME = re.compile(r"[^\W_][\w.-]{0,99}", re.ASCII)

Place = Literal["simulation", "physics", "robot"]
"""Place of the trials: the simulated body, its twin in rigid-body physics, or a real robot."""


@dataclass(frozen=True)
class Session:
    """The conditions of an adaptation, and its trials so far.

    Attributes:
        atlas: checksum of the members of the atlas; see `prior.atlas_checksum`.
        place: where the trials take place.
        damage: damage to the simulated body, in alphabetical order.
        measure: name of the performance measure.
        settings: settings of the adaptation.
        trials: trials in order.
        intact: for trials in physics, the measured performance of the most promising gaits on the
            intact body in rigid-body physics, by member; {} before they are measured.
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
    """Return the file of a session."""
    if not _NAME.fullmatch(name):
        raise GaitsimError(
            f"invalid name for an adaptation: {name!r:.120}",
            where="name",
            allowed="up to 100 letters, digits, '-', '_' and '.', starting with a letter or digit",
        )
    return create_subfolder(run, ADAPTATIONS) / f"{name}.json"


def default_name(place: Place, damage: Sequence[str]) -> str:
    """Return the default name of a session, such as 'L2-lost' or 'robot'."""
    parts = ["-".join(re.findall(r"[a-zA-Z0-9.-]+", text)) for text in damage]
    if place != "simulation" or not parts:
        parts.append(place)
    name = "_".join(filter(None, parts))
    return name if _NAME.fullmatch(name) else f"damage-{checksum(name)[:12]}"


def normalise_damage(damage: Sequence[str]) -> tuple[str, ...]:
    """Return damage in alphabetical order, with single spaces; a plain string is one damage."""
    texts = [damage] if isinstance(damage, str) else damage
    return tuple(sorted(" ".join(text.split()) for text in texts))


def read_session(path: Path) -> Session | None:
    """Return the session in a file; None if the file does not exist."""
    try:
        session = _SESSION.validate_json(read_regular(path, LARGEST), strict=True)
        reason = _inconsistency(session)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}", remedy=REMEDY) from None
    except ValidationError as error:
        key, what = first_problem(error, "adaptation")
        reason = f"{key}: {what}"
    except GaitsimError as error:  # invalid settings
        reason = error.what
    if reason:
        raise RunError(f"{path} is damaged: {reason}", remedy=REMEDY)
    return session


def replace_session(path: Path, read: Session | None, session: Session) -> None:
    """Write a session to the file from which it was read.

    Args:
        path: the file.
        read: content of the file when it was read; None if it did not exist.
        session: new content.
    """
    if read_session(path) != read:
        raise RunError(
            f"{path} has changed since it was read: another process is using it",
            remedy="run the same command again to continue the adaptation, or choose a different "
            "--name",
        )
    write_session(path, session)


def write_session(path: Path, session: Session) -> None:
    """Write a session atomically, replacing any existing file."""
    write_bytes(path, _SESSION.dump_json(session, indent=1) + b"\n", follow=False)


def mismatch(found: Session, wanted: Session) -> str:
    """Return why the session in a file cannot be continued as the wanted session, or ''.

    The settings `trials` and `stop` may differ, as they do not change the earlier trials.
    """
    if found.atlas != wanted.atlas:
        return "the atlas has changed since the adaptation began"
    for name in ("place", "damage", "measure"):
        one, other = getattr(found, name), getattr(wanted, name)
        if one != other:
            return f"its {name} is {_format_value(one)}, not {_format_value(other)}"
    for name in (one.name for one in fields(Settings)):
        one, other = (getattr(session.settings, name) for session in (found, wanted))
        if one != other and name not in ("trials", "stop"):
            return f"its {name.replace('_', ' ')} is {one:g}, not {other:g}"
    return ""


def _format_value(value: str | tuple[str, ...]) -> str:
    return repr(value) if isinstance(value, str) else ", ".join(value) or "none"


def _inconsistency(session: Session) -> str:
    """Return why the content of a session is inconsistent, or ''."""
    trials = session.trials
    if len(trials) > MOST_TRIALS:
        return f"it has {len(trials)} trials, more than {MOST_TRIALS}"
    if [trial.number for trial in trials] != [*range(1, len(trials) + 1)]:
        return "its trials are not numbered in order"
    members = [trial.member for trial in trials]
    if len({*members}) < len(members) or not all(0 < member < 2**40 for member in members):
        return "a member is invalid or was tried twice"
    numbers = (
        value for trial in trials for value in (trial.expected, trial.deviation, trial.measured)
    )
    if not all(abs(value) < LARGEST_SCORE for value in (*numbers, *session.intact.values())):
        return "a measured value is not a finite number"
    if session.intact and not max(session.intact.values()) > 0:
        return "no gait of the atlas walks on the intact body in rigid-body physics"
    return ""

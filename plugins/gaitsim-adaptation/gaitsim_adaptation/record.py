"""The record of an adaptation: its conditions and trials, in a file of the atlas."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import ClassVar, Literal

from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.plugin import (
    GaitFormat,
    GaitsimError,
    RunError,
    checksum,
    read_regular,
)
from gaitsim.plugin.runs import (
    ADAPTATIONS,
    EXACT_KEYS,
    LARGEST_SCORE,
    Experiment,
    create_subfolder,
    first_problem,
    write_bytes,
)
from gaitsim_adaptation.settings import MOST_TRIALS, AdaptationSettings
from gaitsim_adaptation.trials import (
    Trial,
    fit,
)

LARGEST = 1_000_000  # bytes
REMEDY = "delete the file, or start over with --fresh"
_NAME = re.compile(r"[^\W_][\w.-]{0,99}", re.ASCII)

Place = Literal["simulation", "physics", "robot"]
"""Place of the trials: the simulated body, its twin in rigid-body physics, or a real robot."""


@dataclass(frozen=True)
class AdaptationRecord:
    """The conditions of an adaptation and its trials, which its file holds.

    Each proposal follows from the atlas, the settings, `intact`, and the earlier trials.

    Attributes:
        atlas: checksum of the members of the atlas; see `prior.atlas_checksum`.
        place: where the trials take place.
        damage: damage to the simulated body, in alphabetical order; for a robot, the damage that
            the user knows.
        measure: name of the performance measure.
        settings: settings of the adaptation.
        trials: trials in order.
        intact: for trials in physics, the measured performance of the most promising gaits on the
            intact body in rigid-body physics, by member; {} before they are measured.
        known: whether the damage to the body in simulation also serves the predictions.
        gait_format: format of the gait files for a robot.
        unit: unit of results without a unit; '' for that of the measure.
        course: distance for which a robot's time is measured, m; None for other results.
        format: format of the file.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    atlas: str
    place: Place
    damage: tuple[str, ...]
    measure: str
    settings: AdaptationSettings
    trials: tuple[Trial, ...] = ()
    intact: dict[int, float] = field(default_factory=dict)
    known: bool = False
    gait_format: GaitFormat = "mat"
    unit: str = ""
    course: float | None = None
    format: Literal[3] = 3


_RECORD = TypeAdapter(AdaptationRecord)


def adaptation_file(run: Path, name: str) -> Path:
    """Return the file of an adaptation."""
    if not _NAME.fullmatch(name):
        raise GaitsimError(
            f"invalid name for an adaptation: {name!r:.120}",
            where="name",
            allowed="up to 100 letters, digits, '-', '_' and '.', starting with a letter or digit",
        )
    return create_subfolder(run, ADAPTATIONS) / f"{name}.json"


def default_name(place: Place, damage: Sequence[str]) -> str:
    """Return the default name of an adaptation, such as 'L2-lost' or 'robot'."""
    parts = ["-".join(re.findall(r"[a-zA-Z0-9.-]+", text)) for text in damage]
    if place != "simulation" or not parts:
        parts.append(place)
    name = "_".join(filter(None, parts))
    return name if _NAME.fullmatch(name) else f"damage-{checksum(name)[:12]}"


def normalise_damage(damage: Sequence[str]) -> tuple[str, ...]:
    """Return damage in alphabetical order, with single spaces; a plain string is one damage."""
    texts = [damage] if isinstance(damage, str) else damage
    return tuple(sorted(" ".join(text.split()) for text in texts))


def read_record(path: Path) -> AdaptationRecord | None:
    """Return the record in a file; None if the file does not exist."""
    try:
        data = read_regular(path, LARGEST)
        record = _RECORD.validate_json(data, strict=True)
        reason = _inconsistency(record)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RunError(f"cannot read {path}: {error.strerror}", remedy=REMEDY) from None
    except ValidationError as error:
        if b'"said": [' in data or b'"measured": ' in data:
            raise RunError(
                f"{path} was written by an older version of gaitsim, which recorded trials "
                "differently",
                remedy="start over with --fresh, or start a new adaptation with --name",
            ) from None
        key, what = first_problem(error, "adaptation")
        reason = f"{key}: {what}"
    except GaitsimError as error:  # invalid settings
        reason = error.what
    if reason:
        raise RunError(f"{path} is damaged: {reason}", remedy=REMEDY)
    return record


def replace_record(path: Path, read: AdaptationRecord | None, record: AdaptationRecord) -> None:
    """Write a record to the file from which it was read; None if the file did not exist."""
    if read_record(path) != read:
        raise RunError(
            f"{path} has changed since it was read: another process is using it",
            remedy="run the same command again to continue the adaptation, or choose a different "
            "--name",
        )
    write_record(path, record)


def write_record(path: Path, record: AdaptationRecord) -> None:
    """Write a record atomically, replacing any existing file."""
    write_bytes(path, _RECORD.dump_json(record, indent=1) + b"\n", follow=False)


LATER = "trials", "stop", "refine", "repeats"


def mismatch(found: AdaptationRecord, wanted: AdaptationRecord) -> str:
    """Return why the adaptation in a file cannot be continued as the wanted one, or ''.

    The settings in `LATER` may differ, as they do not change the earlier trials.
    """
    if found.atlas != wanted.atlas:
        return "the atlas has changed since the adaptation began"
    for name in ("place", "damage", "measure", "known", "course"):
        one, other = getattr(found, name), getattr(wanted, name)
        if one != other:
            return f"its {name} is {_format_value(one)}, not {_format_value(other)}"
    for name in (one.name for one in fields(AdaptationSettings)):
        one, other = (getattr(record.settings, name) for record in (found, wanted))
        if one != other and name not in LATER:
            return f"its {name.replace('_', ' ')} is {one}, not {other}"
    return ""


def check_gaits(path: Path, record: AdaptationRecord, experiment: Experiment, members: int) -> None:
    """Check that the gaits of the adaptation in a file can belong to an atlas.

    Args:
        path: the file.
        record: its content.
        experiment: experiment of the atlas.
        members: number of members of the atlas.
    """
    named = (*record.intact, *(trial.member for trial in record.trials))
    reason = ""
    if not all(1 <= member <= members for member in named):
        reason = "it contains members that the atlas does not have"
    elif not fit(experiment, record.trials):
        reason = "a changed gait does not fit the body"
    if reason:
        raise RunError(f"{path} is damaged: {reason}", remedy=REMEDY)


def _format_value(value: object) -> str:
    return ", ".join(value) or "none" if isinstance(value, tuple) else repr(value)


def _inconsistency(record: AdaptationRecord) -> str:
    """Return why the content of a file is inconsistent, or ''."""
    trials = record.trials
    if len(trials) > MOST_TRIALS:
        return f"it has {len(trials)} trials, more than {MOST_TRIALS}"
    if [trial.number for trial in trials] != [*range(1, len(trials) + 1)]:
        return "its trials are not numbered in order"
    if not all(trial.values for trial in trials):
        return "a trial has no value"
    members = [trial.member for trial in trials if not trial.genome]
    if len({*members}) < len(members) or not all(0 < trial.member < 2**40 for trial in trials):
        return "a member is invalid or was tried twice"
    numbers = [
        value for one in trials for value in (*one.values, one.expected, one.deviation, *one.genome)
    ]
    if not all(abs(value) < LARGEST_SCORE for value in (*numbers, *record.intact.values())):
        return "a measured value is not a finite number"
    if record.intact and not max(record.intact.values()) > 0:
        return "no gait of the atlas walks on the intact body in rigid-body physics"
    return ""

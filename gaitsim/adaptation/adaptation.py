"""An adaptation in progress: its trials, its next proposal and its file."""

import re
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.adaptation.prior import (
    DEFAULT_MEASURE,
    OnProgress,
    Prior,
    atlas_checksum,
    atlas_members,
    read_prior,
)
from gaitsim.adaptation.settings import MOST_TRIALS, AdaptationSettings
from gaitsim.adaptation.trials import (
    MeasureGait,
    Proposal,
    Trial,
    best_of,
    create_trial,
    ending,
    measure_intact,
    propose,
    simulated_robot,
    transfer_map,
)
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation.executors import cores
from gaitsim.evaluation.processes import OnWarning
from gaitsim.evaluation.scoring import LARGEST_SCORE
from gaitsim.individual import Individual
from gaitsim.opening import read_regular
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import ADAPTATIONS, create_subfolder
from gaitsim.storage.files.schema import EXACT_KEYS, first_problem
from gaitsim.storage.snapshot import RunSnapshot
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
    settings: AdaptationSettings
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
    for name in (one.name for one in fields(AdaptationSettings)):
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


class Adaptation(ReprMixin, Iterator[Trial]):
    """Trials of an atlas's gaits on a damaged body; an iterator that performs the next trial.

    Each trial is saved in the session's file, if it has one, before it is yielded.

    Args:
        prior: map of the intact body.
        session: conditions of the adaptation, and its trials so far.
        measure_gait: function that returns the performance of a gait; None if the caller records
            each value.
        path: file of the session; None saves nothing.

    Attributes:
        prior: map of the intact body.
        session: conditions of the adaptation, and its trials so far.
        path: file of the session; None if nothing is saved.
        proposal: gait to try next; None once the adaptation has ended.
    """

    def __init__(
        self, prior: Prior, session: Session, measure_gait: MeasureGait | None, path: Path | None
    ) -> None:
        self.prior, self.session, self.path = prior, session, path
        self._measure_gait = measure_gait
        self.proposal: Proposal | None = propose(prior, session.trials, session.settings)

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Trials so far, in order."""
        return self.session.trials

    @property
    def best(self) -> Trial | None:
        """Trial with the best measured performance; None before the first trial."""
        return best_of(self.trials)

    @property
    def gait(self) -> Individual | None:
        """Gait of the best trial, on the intact body; None before the first trial."""
        best = self.best
        return None if best is None else self.prior.individual(best.member)

    @property
    def ending(self) -> str:
        """Reason why the adaptation has ended, one sentence; '' until then."""
        return ending(self.prior, self.trials, self.session.settings)

    def __next__(self) -> Trial:
        if self.proposal is None:
            raise StopIteration
        if self._measure_gait is None:
            raise GaitsimError(
                "the adaptation has no function that measures a gait",
                remedy="add the next trial with record()",
            )
        return self.record(self._measure_gait(self.prior.individual(self.proposal.member)))

    def record(self, measured: float) -> Trial:
        """Add the trial of the proposed gait.

        Raises:
            GaitsimError: `measured` is not a finite number, or the adaptation has ended.
            RunError: the file cannot be written, or another process has changed it.
        """
        if self.proposal is None:
            raise GaitsimError(
                f"the adaptation has ended: {self.ending}",
                remedy="increase 'trials' or change 'stop' to continue",
            )
        trial = create_trial(self.proposal, measured)
        session = replace(self.session, trials=(*self.trials, trial))
        proposal = propose(self.prior, session.trials, session.settings)
        if self.path is not None:
            replace_session(self.path, self.session, session)
        self.session, self.proposal = session, proposal
        return trial

    def _repr_fields(self) -> Mapping[str, ReprField]:
        best = self.best
        return {
            "atlas": str(self.prior.source),
            "damage": ", ".join(self.session.damage),
            "trials": len(self.trials),
            "best": best.measured if best else "",
        }


def open_adaptation(
    run: RunSnapshot,
    damage: Sequence[str] = (),
    *,
    place: Place = "simulation",
    robot: MeasureGait | None = None,
    measure: str | None = None,
    settings: Mapping[str, Any] | None = None,
    record: bool = True,
    name: str | None = None,
    fresh: bool = False,
    workers: int | None = None,
    on_progress: OnProgress = lambda done: None,
    on_warning: OnWarning = lambda text: None,
) -> Adaptation:
    """Start an adaptation, or continue the adaptation in its file.

    For trials in physics, the most promising gaits are first measured on the intact body in
    rigid-body physics, and these measurements correct the map.

    Args:
        run: run of the atlas.
        damage: damage to the simulated body, such as 'L2 lost'.
        place: where the trials take place: 'simulation', 'physics' or 'robot'.
        robot: function that returns the performance of a gait on a robot; None if the caller
            records each value.
        measure: name of the performance measure; None for the measure in the file, or 'forward'.
        settings: fields of `AdaptationSettings` by name. Other fields have their values from the
            file, or their defaults without a file.
        record: whether to save the trials in a file in the run's folder.
        name: name of that file; None for a name that describes the damage or the place.
        fresh: whether to start over and replace the file.
        workers: number of workers that evaluate the map; None for a number that suits the body.
        on_progress: called with the number of gaits evaluated since the last call.
        on_warning: called with a message for the user.

    Raises:
        GaitsimError: the body does not support the damage, a setting is invalid, the body does not
            have the measure, or `robot` is combined with damage or physics.
        RunError: the run is not an atlas, or the file is damaged or belongs to a different
            adaptation.
    """
    members = atlas_members(run)
    experiment, wanted = run.experiment_at(run.generation), normalise_damage(damage)
    path = session_file(run.path, name or default_name(place, wanted)) if record else None
    found = None if path is None or fresh else read_session(path)
    stored = found.settings if found else AdaptationSettings()
    session = Session(
        atlas_checksum(members),
        place,
        wanted,
        measure or (found.measure if found else DEFAULT_MEASURE),
        replace(stored, **(settings or {})),
        found.trials if found else (),
        found.intact if found else {},
    )
    if found and (reason := mismatch(found, session)):
        raise RunError(
            f"the adaptation in {path} cannot be continued: {reason}",
            allowed="the same atlas, damage, measure and settings, except 'trials' and 'stop'",
            remedy="start over with --fresh, or start a new adaptation with --name",
        )
    named = (*session.intact, *(trial.member for trial in session.trials))
    if not all(1 <= member <= len(members.scores) for member in named):
        raise RunError(
            f"{path} is damaged: it contains members that the atlas does not have", remedy=REMEDY
        )
    measure_gait = robot
    if robot is not None and place != "robot":
        raise GaitsimError(
            "'damage' and 'physics' apply to trials in simulation, not on a robot", where="robot"
        )
    if place != "robot":
        physics = place == "physics"
        measure_gait = simulated_robot(experiment, wanted, session.measure, physics=physics)
    prior = read_prior(
        run, session.measure, workers=workers, on_progress=on_progress, on_warning=on_warning
    )
    if place == "physics":
        if not session.intact:
            intact_body = simulated_robot(experiment, (), session.measure, physics=True)
            with ThreadPoolExecutor(workers or cores(), "gaitsim") as pool:
                intact = measure_intact(prior, intact_body, pool, on_progress)
            session = replace(session, intact=intact)
        prior = transfer_map(prior, session.intact)
    if path is not None and fresh:
        write_session(path, session)
    elif path is not None and session != found:
        replace_session(path, found, session)
    return Adaptation(prior, session, measure_gait, path)

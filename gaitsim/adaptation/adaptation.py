"""An adaptation in progress: its trials, its next proposal and its file."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from gaitsim.adaptation.performance import DEFAULT_MEASURE
from gaitsim.adaptation.prior import OnProgress, Prior, atlas_checksum, atlas_members, read_prior
from gaitsim.adaptation.session import (
    REMEDY,
    Place,
    Session,
    default_name,
    mismatch,
    normalise_damage,
    read_session,
    replace_session,
    session_file,
    write_session,
)
from gaitsim.adaptation.settings import Settings
from gaitsim.adaptation.simulation import simulated_robot
from gaitsim.adaptation.transfer import measure_intact, transfer_map
from gaitsim.adaptation.trials import (
    MeasureGait,
    Proposal,
    Trial,
    best_of,
    create_trial,
    ending,
    propose,
)
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation.executors import cores
from gaitsim.evaluation.processes import OnWarning
from gaitsim.individual import Individual
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.runs.snapshot import RunSnapshot


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

        Args:
            measured: measured performance of the gait.

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
        settings: fields of `Settings` by name. Other fields have their values from the file, or
            their defaults without a file.
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
    stored = found.settings if found else Settings()
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
        run,
        session.measure,
        workers=workers,
        on_progress=on_progress,
        on_warning=on_warning,
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

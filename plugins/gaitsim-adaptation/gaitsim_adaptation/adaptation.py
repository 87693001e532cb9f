"""An adaptation: its trials, its next proposal, and how it begins or continues."""

import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

from gaitsim.plugin import (
    GaitsimError,
    ReprField,
    ReprMixin,
    RunError,
)
from gaitsim.plugin.gait import gait_of, write_gait
from gaitsim.plugin.runs import (
    Individual,
    OnWarning,
    RunSnapshot,
    cores,
    exports_folder,
)
from gaitsim_adaptation.answers import Answer, AnswerReader
from gaitsim_adaptation.champion import Reference, find_reference
from gaitsim_adaptation.changes import genes_of
from gaitsim_adaptation.prior import (
    DEFAULT_MEASURE,
    OnProgress,
    Prior,
    atlas_checksum,
    atlas_members,
    poverty,
    read_prior,
)
from gaitsim_adaptation.record import (
    LATER,
    AdaptationRecord,
    Place,
    adaptation_file,
    check_gaits,
    default_name,
    mismatch,
    normalise_damage,
    read_record,
    replace_record,
    write_record,
)
from gaitsim_adaptation.settings import AdaptationSettings
from gaitsim_adaptation.trials import (
    OUTCOMES,
    MeasureGait,
    Outcome,
    Proposal,
    Trial,
    best_of,
    check_measured,
    ending,
    individual_of,
    measure_intact,
    predict_performance,
    propose,
    simulated_robot,
    transfer_map,
)

DOUBTFUL = 2.0  # times the best expected performance


class Reply(NamedTuple):
    """The answer of a user to a proposal, or a change of an earlier trial.

    Attributes:
        kind: 'trial' for the result of the proposed gait, 'repeat' for another attempt at the gait
            of an earlier trial, 'correct' for a result that replaces that of an earlier trial, or
            'undo' to remove the last trial.
        trial: number of the trial; 0 for 'undo'.
        answer: the result; None for 'undo'.
    """

    kind: Literal["trial", "repeat", "correct", "undo"]
    trial: int = 0
    answer: Answer | None = None


class Adaptation(ReprMixin, Iterator[Trial]):
    """Trials of an atlas's gaits on a damaged body; an iterator that performs the next trial.

    Each trial is saved in the file of the adaptation, if it has one, before it is yielded.

    Args:
        prior: map of the intact body.
        record: conditions of the adaptation, and its trials so far.
        measure_gait: function that returns the performance of a gait; None if the caller records
            each value.
        path: file of the adaptation; None saves nothing.
        reference: the champion to compare with; None without one.

    Attributes:
        prior: map of the intact body.
        path: file of the adaptation; None if nothing is saved.
        reference: the champion to compare with; None without one.
        proposal: gait to try next; None once the adaptation has ended.
    """

    def __init__(
        self,
        prior: Prior,
        record: AdaptationRecord,
        measure_gait: MeasureGait | None,
        path: Path | None = None,
        reference: Reference | None = None,
    ) -> None:
        self.prior, self.path, self.reference = prior, path, reference
        self._record, self._measure_gait = record, measure_gait
        self.proposal: Proposal | None = propose(prior, record.trials, record.settings)

    @classmethod
    def unsaved(cls, prior: Prior, measure_gait: MeasureGait, settings: AdaptationSettings) -> Self:
        """Return an adaptation in simulation that saves nothing; threads may share the prior."""
        record = AdaptationRecord("", "simulation", (), prior.measure, settings)
        return cls(prior, record, measure_gait)

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Trials so far, in order."""
        return self._record.trials

    @property
    def place(self) -> Place:
        """The place of the trials."""
        return self._record.place

    @property
    def damage(self) -> tuple[str, ...]:
        """Damage to the simulated body; for a robot, the damage that the user knows."""
        return self._record.damage

    @property
    def settings(self) -> AdaptationSettings:
        """Settings of the adaptation."""
        return self._record.settings

    @property
    def best(self) -> Trial | None:
        """Trial with the best measured performance; None before the first trial."""
        return best_of(self.trials)

    @property
    def gait(self) -> Individual | None:
        """Gait of the best trial, on the intact body; None before the first trial."""
        best = self.best
        return None if best is None else self.individual(best)

    @property
    def ending(self) -> str:
        """Reason why the adaptation has ended, one sentence; '' until then."""
        return ending(self.prior, self.trials, self.settings)

    @property
    def shares(self) -> str:
        """The best trial, such as '2.37 m, 86% of the best in the atlas'; '' without a trial."""
        if (best := self.best) is None:
            return ""
        unit, value = f" {self.prior.unit}".rstrip(), best.measured
        text = f"{value:.3f}{unit}, {value / self.prior.best:.0%} of the best in the atlas"
        if self.reference is None:
            return text
        whole = self.reference.performance
        return f"{text}, {value / whole:.0%} of the champion's {whole:.3g}{unit}"

    @cached_property
    def reading(self) -> AnswerReader:
        """The meaning of numbers that a user types."""
        course, seconds = self._record.course, math.nan
        if course is not None:
            skeleton = self.prior.individual(1).skeleton
            seconds = len(skeleton.path) / skeleton.frame_rate
        return AnswerReader(self.prior.unit, self._record.unit, course, seconds)

    def individual(self, proposal: Proposal) -> Individual:
        """Return the gait of a proposal or trial, on the intact body."""
        return individual_of(self.prior, proposal)

    def __next__(self) -> Trial:
        if self.proposal is None:
            raise StopIteration
        if self._measure_gait is None:
            raise GaitsimError(
                "the adaptation has no function that measures a gait",
                remedy="add the next trial with record()",
            )
        return self.record(self._measure_gait(self.individual(self.proposal)))

    def record(self, measured: float | str | Answer) -> Trial:
        """Add the result of the proposed gait.

        Args:
            measured: performance in the unit of the map, or the answer of a user, such as '62cm'.

        Returns:
            The trial, which is an earlier one if the proposal repeats it.

        Raises:
            GaitsimError: `measured` is not a finite number, or the adaptation has ended.
            RunError: the file cannot be written, or another process has changed it.
        """
        proposal = self.proposal
        if proposal is None:
            raise GaitsimError(
                f"the adaptation has ended: {self.ending}",
                remedy="increase 'trials' or 'refine', or change 'stop' to continue",
            )
        if proposal.number <= len(self.trials):
            return self.repeat(proposal.number, measured)
        answer = self._answer(measured, proposal.number)
        self._replace(
            (*self.trials, Trial(**vars(proposal), values=answer.values, outcome=answer.outcome))
        )
        return self.trials[-1]

    def repeat(self, number: int, measured: float | str | Answer) -> Trial:
        """Add the result of another attempt at the gait of an earlier trial; see `record`."""
        trial, answer = self._earlier(number), self._answer(measured, number)
        outcome = max(trial.outcome, answer.outcome, key=OUTCOMES.index)
        return self._revise(trial, (*trial.values, *answer.values), outcome)

    def correct(self, number: int, measured: float | str | Answer) -> Trial:
        """Replace the result of an earlier trial, all its attempts included; see `record`."""
        trial, answer = self._earlier(number), self._answer(measured, number)
        return self._revise(trial, answer.values, answer.outcome)

    def undo(self) -> Trial:
        """Remove the last trial, and return it.

        Raises:
            GaitsimError: there is no trial.
        """
        if not self.trials:
            raise GaitsimError("there is no result to undo", where="undo")
        last = self.trials[-1]
        self._replace(self.trials[:-1])
        return last

    def understand(self, text: str) -> Reply:
        """Return the meaning of a reply: a result, 'undo', 'correct N RESULT' or 'repeat N RESULT'.

        Raises:
            GaitsimError: the reply is invalid.
        """
        if text.strip().lower() == "undo":
            return Reply("undo")
        action, _, rest = text.strip().partition(" ")
        number, _, result = rest.strip().partition(" ")
        match action.lower():
            case "correct":
                return Reply("correct", trial_number(number), self.reading.read(result))
            case "repeat":
                return Reply("repeat", trial_number(number), self.reading.read(result))
        return Reply("trial", len(self.trials) + 1, self.reading.read(text))

    def carry_out(self, reply: Reply) -> Trial:
        """Carry out a reply; return the trial that was added, changed or removed."""
        if reply.answer is None:
            return self.undo()
        if reply.kind == "trial":
            return self.record(reply.answer)
        change = self.correct if reply.kind == "correct" else self.repeat
        return change(reply.trial, reply.answer)

    @property
    def question(self) -> str:
        """The question for the result of a trial."""
        course, unit = self._record.course, self._record.unit
        if course is not None:
            return f"time of the robot for {course:g} m, {unit or 's'}"
        return f"{self.prior.measure} of the robot, {unit or self.prior.unit}".rstrip(", ")

    @property
    def name(self) -> str:
        """Name of the file of the adaptation, or its default name."""
        return default_name(self.place, self.damage) if self.path is None else self.path.stem

    def export(self, proposal: Proposal, part: str = "") -> Path:
        """Write a gait file for the robot to the exports of the atlas, and return its path.

        The file has the name of the adaptation, followed by `part` or the number of the trial.
        """
        stem = f"{self.name}-{part or f'trial-{proposal.number}'}"
        path = exports_folder(self.prior.source) / f"{stem}.{self._record.gait_format}"
        write_gait(gait_of(self.individual(proposal)), path, self._record.gait_format)
        return path

    def doubt(self, answer: Answer | None) -> str:
        """Return a sentence on why an answer is probably a mistake, or ''.

        An answer above twice the best performance that is expected of any gait is doubtful.
        """
        if answer is None:
            return ""
        prediction = predict_performance(self.prior, self.trials, self.settings)
        value, limit = max(answer.values), float(prediction.mean.max())
        if limit <= 0 or value <= DOUBTFUL * limit:
            return ""
        unit = f" {self.prior.unit}".rstrip()
        return (
            f"{value:.3g}{unit} is {value / limit:.3g} times the best expected, {limit:.3g}{unit}"
        )

    def _answer(self, measured: float | str | Answer, number: int) -> Answer:
        if isinstance(measured, str):
            return self.reading.read(measured)
        if isinstance(measured, Answer):
            return measured
        return Answer((check_measured(measured, number),))

    def _earlier(self, number: int) -> Trial:
        if not 1 <= number <= len(self.trials):
            raise GaitsimError(
                f"there is no trial {number}", allowed=f"1 to {len(self.trials)}", where="trial"
            )
        return self.trials[number - 1]

    def _revise(self, trial: Trial, values: tuple[float, ...], outcome: Outcome) -> Trial:
        """Change the result of an earlier trial."""
        revised = replace(trial, values=values, outcome=outcome, revised=True)
        at = trial.number
        self._replace((*self.trials[: at - 1], revised, *self.trials[at:]))
        return revised

    def _replace(self, trials: tuple[Trial, ...]) -> None:
        """Save the trials, and choose the next gait."""
        record = replace(self._record, trials=trials)
        proposal = propose(self.prior, trials, record.settings)
        if self.path is not None:
            replace_record(self.path, self._record, record)
        self._record, self.proposal = record, proposal

    def _repr_fields(self) -> Mapping[str, ReprField]:
        best = self.best
        return {
            "atlas": str(self.prior.source),
            "damage": ", ".join(self.damage),
            "trials": len(self.trials),
            "best": best.measured if best else "",
        }


def open_adaptation(
    run: RunSnapshot,
    damage: Sequence[str] | None = None,
    *,
    place: Place = "simulation",
    robot: MeasureGait | None = None,
    measure: str | None = None,
    settings: Mapping[str, Any] | None = None,
    known: bool = False,
    answers: Mapping[str, Any] | None = None,
    saved: bool = True,
    name: str | None = None,
    fresh: bool = False,
    champion: str | None = None,
    workers: int | None = None,
    on_progress: OnProgress = lambda done: None,
    on_warning: OnWarning = lambda text: None,
) -> Adaptation:
    """Start an adaptation, or continue the adaptation in its file.

    For trials in physics, the most promising gaits are first measured on the intact body in
    rigid-body physics, and these measurements correct the map.

    Args:
        run: run of the atlas.
        damage: damage to the simulated body, such as 'L2 lost'; for a robot, damage that the user
            sees, which serves the predictions. None for the damage in the file, or no damage.
        place: where the trials take place: 'simulation', 'physics' or 'robot'.
        robot: function that returns the performance of a gait on a robot; None if the caller
            records each value.
        measure: name of the performance measure; None for the measure in the file, or 'forward'.
        settings: fields of `AdaptationSettings` by name. Other fields have their values from the
            file, or their defaults without a file; for a robot, the scale is then unknown, and the
            best gait is measured twice more after changed gaits.
        known: whether the damage to the body in simulation also serves the predictions.
        answers: fields `gait_format`, `unit` and `course` of `AdaptationRecord`; others are from
            the file.
        saved: whether to save the trials in a file in the run's folder.
        name: name of that file; None for a name that describes the damage or the place.
        fresh: whether to start over and replace the file.
        champion: run of the champion to compare with; see `find_reference`.
        workers: number of workers that evaluate the map; None for a number that suits the body.
        on_progress: called with the number of gaits evaluated since the last call.
        on_warning: called with a message for the user.

    Raises:
        GaitsimError: the body does not support the damage, a setting is invalid, the body does not
            have the measure, or `robot` is combined with physics.
        RunError: the run is not an atlas, or the file is damaged or belongs to a different
            adaptation.
    """
    members = atlas_members(run)
    experiment, wanted = run.experiment_at(run.generation), normalise_damage(damage or ())
    path = adaptation_file(run.path, name or default_name(place, wanted)) if saved else None
    found = None if path is None or fresh else read_record(path)
    of_robot = place == "robot"
    start = AdaptationSettings(scale=None, repeats=2) if of_robot else AdaptationSettings()
    kept = found or AdaptationRecord("", place, wanted, DEFAULT_MEASURE, start)
    record = replace(
        kept,
        atlas=atlas_checksum(members),
        place=place,
        damage=kept.damage if damage is None and of_robot else wanted,
        measure=measure or kept.measure,
        settings=replace(kept.settings, **(settings or {})),
        known=known or (of_robot and bool(kept.damage)),
        **(answers or {}),
    )
    if found and (reason := mismatch(found, record)):
        raise RunError(
            f"the adaptation in {path} cannot be continued: {reason}",
            allowed="the same atlas, damage, measure and settings, except "
            + ", ".join(f"'{one}'" for one in LATER),
            remedy="start over with --fresh, or start a new adaptation with --name",
        )
    if path is not None:
        check_gaits(path, record, experiment, len(members.scores))
    if record.settings.refine:
        genes_of(experiment)
    measure_gait = robot
    if robot is not None and not of_robot:
        raise GaitsimError(
            "'physics' applies to trials in simulation, not on a robot", where="robot"
        )
    if not of_robot:
        physics = place == "physics"
        measure_gait = simulated_robot(experiment, wanted, record.measure, physics=physics)
    reference = find_reference(run, champion, record.measure, physics=place == "physics")
    prior = read_prior(
        run,
        record.measure,
        record.damage if record.known else (),
        workers=workers,
        on_progress=on_progress,
        on_warning=on_warning,
    )
    if place == "physics":
        if not record.intact:
            intact_body = simulated_robot(experiment, (), record.measure, physics=True)
            with ThreadPoolExecutor(workers or cores(), "gaitsim") as pool:
                intact = measure_intact(run, prior, intact_body, pool, on_progress)
            record = replace(record, intact=intact)
        prior = transfer_map(prior, record.intact)
    if reason := poverty(prior):
        on_warning(reason)
    if path is not None and fresh:
        write_record(path, record)
    elif path is not None and record != found:
        replace_record(path, found, record)
    return Adaptation(prior, record, measure_gait, path, reference)


def trial_number(text: str) -> int:
    """Return the number of a trial in a text."""
    if not (text.isascii() and text.isdecimal() and len(text) < 10):
        raise GaitsimError(f"invalid number of a trial: {text!r:.40}", allowed="a number from 1")
    return int(text)


def measured_scale(run: RunSnapshot, name: str) -> float:
    """Return the scale of a robot from the trials of an adaptation of the intact robot.

    This is the median ratio of the measured to the expected performance in the map.

    Raises:
        GaitsimError: there is no such adaptation, it is of a damaged robot, or no gait walked.
    """
    record = read_record(adaptation_file(run.path, name))
    if record is None or record.place != "robot" or record.damage:
        raise GaitsimError(
            f"{name!r} is not an adaptation of an intact robot",
            where="--scale",
            allowed="a number, such as 0.6, or the --name of trials on the intact robot",
        )
    performance = read_prior(run, record.measure).performance
    ratios = [
        trial.measured / float(performance[trial.member - 1])
        for trial in record.trials
        if trial.outcome == "walked" and not trial.genome and performance[trial.member - 1] > 0
    ]
    if not ratios or not statistics.median(ratios) > 0:
        raise GaitsimError(f"no gait of the adaptation {name!r} walked", where="--scale")
    return statistics.median(ratios)

"""Intelligent trial and error: choose the next gait of a damaged body, and decide when to stop.

    map ─▶ propose ─▶ gait ─▶ measure on the damaged body ─▶ predict ─▶ propose ─▶ …

Source: the map-based Bayesian optimisation (M-BOA) of Cully, Clune, Tarapore and Mouret 2015,
"Robots that can adapt like animals". Each member is tried at most once: as the noise is small, a
second trial of the same gait would add almost no information.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from gaitsim.adaptation.prior import (
    DEFAULT_MEASURE,
    OnProgress,
    Prior,
    atlas_members,
    performance_of,
)
from gaitsim.adaptation.settings import AdaptationSettings
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.scoring import LARGEST_SCORE
from gaitsim.experiment import Experiment
from gaitsim.gait.changed import damage_body, play_on, twin_of
from gaitsim.gaussian_process import Prediction, posterior
from gaitsim.individual import Individual
from gaitsim.storage.snapshot import RunSnapshot

MeasureGait = Callable[[Individual], float]
"""Function that returns the performance of a gait on the damaged body, in the unit of the map."""


@dataclass(frozen=True)
class Proposal:
    """A gait to try.

    Attributes:
        number: number of the trial, counted from 1.
        member: number of the atlas's member, counted from 1.
        expected: expected performance, given the earlier trials.
        deviation: standard deviation of `expected`.
    """

    number: int
    member: int
    expected: float
    deviation: float


@dataclass(frozen=True)
class Trial(Proposal):
    """A gait that was tried.

    Attributes:
        measured: measured performance on the damaged body.
    """

    measured: float


def predict_performance(
    prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings
) -> Prediction:
    """Predict the performance of each member on the damaged body, given the trials so far.

    Returns:
        Mean and standard deviation, (members,) each, in the unit of the map.
    """
    tried = np.array([trial.member - 1 for trial in trials], np.intp)
    measured = np.array([trial.measured for trial in trials], np.float64)
    best = prior.best
    mean, deviation = posterior(
        prior.performance / best,
        prior.behaviour,
        tried,
        measured / best,
        settings.length_scale,
        settings.noise,
    )
    return Prediction(mean * best, deviation * best)


def propose(prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings) -> Proposal | None:
    """Return the gait to try next; None once the adaptation has ended.

    The untried gait with the highest sum of mean and `kappa` standard deviations is chosen. Ties go
    to the first member.
    """
    prediction = predict_performance(prior, trials, settings)
    if _ending(prior, trials, settings, prediction):
        return None
    bound = prediction.mean + settings.kappa * prediction.deviation
    bound[[trial.member - 1 for trial in trials]] = -np.inf
    chosen = int(np.argmax(bound))
    mean, deviation = float(prediction.mean[chosen]), float(prediction.deviation[chosen])
    return Proposal(len(trials) + 1, chosen + 1, mean, deviation)


def ending(prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings) -> str:
    """Return why the adaptation has ended, one sentence; '' until then."""
    return _ending(prior, trials, settings, predict_performance(prior, trials, settings))


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """Return the trial with the best measured performance; ties go to the first trial."""
    return max(trials, key=lambda trial: trial.measured, default=None)


def adapt(
    prior: Prior,
    measure_gait: MeasureGait,
    settings: AdaptationSettings,
    trials: Sequence[Trial] = (),
) -> Iterator[Trial]:
    """Try gaits on the damaged body until one is good enough.

    Several threads may use the same prior at the same time.

    Args:
        prior: map of the intact body.
        measure_gait: function that returns the performance of a gait on the damaged body.
        settings: settings of the adaptation.
        trials: earlier trials, from which to continue.

    Yields:
        The next trial.
    """
    done = [*trials]
    while (proposal := propose(prior, done, settings)) is not None:
        trial = create_trial(proposal, measure_gait(prior.individual(proposal.member)))
        done.append(trial)
        yield trial


def create_trial(proposal: Proposal, measured: float) -> Trial:
    """Return the trial of a proposed gait with its measured performance."""
    try:
        value = float(measured)
    except (TypeError, ValueError):
        value = np.nan
    if not abs(value) < LARGEST_SCORE:
        raise GaitsimError(
            f"invalid measured value: {measured!r:.80}",
            where=f"trial {proposal.number}",
            allowed="a finite number",
        )
    return Trial(proposal.number, proposal.member, proposal.expected, proposal.deviation, value)


def _ending(
    prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings, prediction: Prediction
) -> str:
    best = best_of(trials)
    if best is None:
        return ""
    expected, unit = float(prediction.mean.max()), f" {prior.unit}".rstrip()
    if best.measured >= settings.stop * expected:
        return (
            f"trial {best.number} reached {best.measured:.3g}{unit}, at least "
            f"{settings.stop:.0%} of the best expected performance, {expected:.3g}{unit}"
        )
    if len(trials) >= settings.trials:
        return f"the limit of {settings.trials} trials was reached"
    if len(trials) >= len(prior.performance):
        return f"all {len(trials)} gaits of the atlas were tried"
    return ""


def simulated_robot(
    experiment: Experiment,
    damage: Sequence[str],
    measure: str = DEFAULT_MEASURE,
    *,
    physics: bool = False,
) -> MeasureGait:
    """Return a function that measures gaits on the damaged body in simulation.

    A failed gait has a performance of 0. Several threads may call the function at the same time.

    Args:
        experiment: experiment with the intact body.
        damage: damaged legs and joints, such as 'L2 lost' or 'R1 femur stuck 20'.
        measure: name of the performance measure.
        physics: whether to use the body's twin, its version in rigid-body physics.
    """
    if physics:
        body = twin_of(experiment, damage)
    else:
        body = damage_body(experiment, damage) if damage else experiment

    def measure_gait(individual: Individual) -> float:
        moved = play_on(individual, body) if physics else replace(individual, experiment=body)
        return float(performance_of(body, moved.motion, measure)[0])

    return measure_gait


MAX_MEASURED = 100  # number of gaits measured on the other body


def count_intact_gaits(run: RunSnapshot, *, physics: bool) -> int:
    """Return the largest number of gaits measured on intact bodies before an adaptation."""
    members = len(atlas_members(run).scores)
    return members + (min(members, MAX_MEASURED) if physics else 0)


def measure_intact(
    prior: Prior,
    measure_gait: MeasureGait,
    pool: Executor,
    on_progress: OnProgress = lambda done: None,
) -> dict[int, float]:
    """Measure the most promising gaits on another intact body.

    Args:
        prior: map for the atlas's own body.
        measure_gait: function that measures a gait on the other body.
        pool: thread pool in which the gaits are measured.
        on_progress: called with the number of gaits measured since the last call.

    Returns:
        The measured performance by member, counted from 1.
    """
    members = most_promising(prior, MAX_MEASURED)
    found: dict[int, float] = {}
    for member, value in zip(
        members, pool.map(measure_gait, map(prior.individual, members)), strict=True
    ):
        found[member] = value
        on_progress(1)
    if not max(found.values()) > 0:
        raise GaitsimError(
            f"the measure {prior.measure!r} is not above 0 for any of the {len(found)} best "
            f"gaits of the atlas {prior.source} on the intact body in rigid-body physics",
            remedy="evolve the atlas further with 'gaitsim resume', or omit --physics",
        )
    return found


def most_promising(prior: Prior, count: int) -> tuple[int, ...]:
    """Return the numbers, from 1, of the members with the best performance above 0, best first."""
    order = np.argsort(-prior.performance, kind="stable")[:count]
    return tuple(int(index) + 1 for index in order if prior.performance[index] > 0)


def transfer_map(prior: Prior, measured: Mapping[int, float]) -> Prior:
    """Return the map for another intact body, given measurements of some gaits on that body.

    Measured gaits get their measured performance. The performance of all other gaits is scaled by
    the median ratio of measured performance to performance in the map.

    Args:
        prior: map for the atlas's own body.
        measured: performance on the other body by member, counted from 1. Each of these members
            must have a performance above 0 in the map.
    """
    indices, values = np.array([*measured]) - 1, np.array([*measured.values()])
    performance = prior.performance * np.median(values / prior.performance[indices])
    performance[indices] = values
    return replace(prior, performance=performance)

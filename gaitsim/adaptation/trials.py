"""Intelligent trial and error: choose the next gait of a damaged body, and decide when to stop.

    map ─▶ propose ─▶ gait ─▶ measure on the damaged body ─▶ predict ─▶ propose ─▶ …

Source: the map-based Bayesian optimisation (M-BOA) of Cully, Clune, Tarapore and Mouret 2015,
"Robots that can adapt like animals". Each member is tried at most once: as the noise is small, a
second trial of the same gait would add almost no information.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gaitsim.adaptation.prior import Prior
from gaitsim.adaptation.settings import Settings
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.scoring import LARGEST_SCORE
from gaitsim.gaussian_process import Prediction, posterior
from gaitsim.individual import Individual

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


def predict_performance(prior: Prior, trials: Sequence[Trial], settings: Settings) -> Prediction:
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


def propose(prior: Prior, trials: Sequence[Trial], settings: Settings) -> Proposal | None:
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


def ending(prior: Prior, trials: Sequence[Trial], settings: Settings) -> str:
    """Return why the adaptation has ended, one sentence; '' until then."""
    return _ending(prior, trials, settings, predict_performance(prior, trials, settings))


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """Return the trial with the best measured performance; ties go to the first trial."""
    return max(trials, key=lambda trial: trial.measured, default=None)


def adapt(
    prior: Prior, measure_gait: MeasureGait, settings: Settings, trials: Sequence[Trial] = ()
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
    prior: Prior, trials: Sequence[Trial], settings: Settings, prediction: Prediction
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

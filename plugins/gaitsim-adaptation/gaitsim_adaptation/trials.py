"""Intelligent trial and error: choose the next gait of a damaged body, and decide when to stop.

    map ─▶ propose ─▶ gait ─▶ measure on the damaged body ─▶ predict ─▶ propose ─▶ …

Source: the map-based Bayesian optimisation (M-BOA) of Cully, Clune, Tarapore and Mouret 2015,
"Robots that can adapt like animals". Each member is tried at most once: as the noise is small, a
second trial of the same gait would add almost no information.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from gaitsim.plugin import GaitsimError, Genomes
from gaitsim.plugin.gait import damage_body, play_on, twin_of
from gaitsim.plugin.runs import LARGEST_SCORE, Experiment, Individual, RunSnapshot
from gaitsim.plugin.toolkit import (
    Prediction,
    cholesky,
    distances,
    exp,
    log,
    matern,
    posterior,
    solve_triangular,
)
from gaitsim_adaptation.changes import best_change
from gaitsim_adaptation.prior import (
    DEFAULT_MEASURE,
    Floats,
    OnProgress,
    Prior,
    atlas_members,
    cache_key,
    performance_of,
    read_intact,
    write_intact,
)
from gaitsim_adaptation.settings import AdaptationSettings

MeasureGait = Callable[[Individual], float]
"""Function that returns the performance of a gait on the damaged body, in the unit of the map."""


Outcome = Literal["walked", "fell", "could not play"]
"""Outcome of a trial; the performance of a gait that the robot could not play is 0."""
OUTCOMES: tuple[Outcome, ...] = get_args(Outcome)


@dataclass(frozen=True)
class Proposal:
    """A gait to try.

    Attributes:
        number: number of the trial, counted from 1; that of an earlier trial to repeat it.
        member: number of the atlas's member, counted from 1; for a changed gait, the member from
            which the changes began.
        expected: expected performance, given the earlier trials.
        deviation: standard deviation of `expected`.
        genome: genes of a changed gait; () for the gait of the member.
    """

    number: int
    member: int
    expected: float
    deviation: float
    genome: tuple[float, ...] = field(default=(), kw_only=True)


@dataclass(frozen=True)
class Trial(Proposal):
    """A gait that was tried.

    Attributes:
        values: measured performance of each attempt on the damaged body, in the unit of the map.
        outcome: outcome of the trial.
        revised: whether its result was corrected, or measured again after later trials were
            proposed.
    """

    values: tuple[float, ...]
    outcome: Outcome = "walked"
    revised: bool = False

    @property
    def measured(self) -> float:
        """Mean measured performance."""
        return math.fsum(self.values) / len(self.values)

    @property
    def lowest(self) -> float:
        """Lowest measured performance."""
        return min(self.values)


# The scale of the robot has a log-normal prior with the median 1. A gait's performance differs from
# the scaled map by a standard deviation of SPREAD, as a share of the best in the map. Both were
# chosen on one atlas in kinematics, for the loss of each leg and pair of legs.
SCALES = 33
SMALLEST_SCALE, LARGEST_SCALE = 0.25, 4.0
SCALE_DEVIATION, SPREAD = 0.7, 0.2
LEAST_TRIALS = 3  # with an unknown scale, as a single trial cannot tell a weak robot from damage


def predict_performance(
    prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings
) -> Prediction:
    """Predict the performance of each member on the damaged body, given the trials so far.

    Returns:
        Mean and standard deviation, (members,) each, in the unit of the map.
    """
    best, of_map = prior.best, [trial for trial in trials if not trial.genome]
    tried = np.array([trial.member - 1 for trial in of_map], np.intp)
    measured = np.array([trial.measured for trial in of_map], np.float64)
    mean, deviation = posterior(
        prior_mean(prior, of_map, settings) / best,
        prior.behaviour,
        tried,
        measured / best,
        settings.length_scale,
        settings.noise,
    )
    return Prediction(mean * best, deviation * best)


def prior_mean(prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings) -> Floats:
    """Return the performance of each member that the maps predict, (members,).

    The maps are those of the intact body and of the body with the damage that is known, multiplied
    by the scale. If more than one map or scale is possible, the mean over all of them is taken,
    weighted by their likelihood in the Gaussian process, given the trials without a fall
    (Rasmussen and Williams 2006, eq. 5.4).
    """
    maps = [prior.performance] if prior.damaged is None else [prior.performance, prior.damaged]
    scales, log_prior = np.array([settings.scale]), np.zeros(1)
    if settings.scale is None:
        logarithms = np.linspace(float(log(SMALLEST_SCALE)), float(log(LARGEST_SCALE)), SCALES)
        scales = exp(logarithms)
        log_prior = -0.5 * np.square(logarithms / SCALE_DEVIATION)
    walked = [trial for trial in trials if trial.outcome == "walked"]
    likelihood = np.tile(log_prior, (len(maps), 1))  # (maps, scales)
    if walked and likelihood.size > 1:
        tried = np.array([trial.member - 1 for trial in walked], np.intp)
        measured = np.array([trial.measured for trial in walked])
        predicted = np.stack(maps)[:, None, tried] * scales[:, None]  # (maps, scales, trials)
        rest = (measured - predicted).reshape(-1, len(walked)) / prior.best / SPREAD
        points = prior.behaviour[tried]
        covariance = matern(distances(points, points), settings.length_scale)
        lower = cholesky(covariance + settings.noise * np.eye(len(walked)))
        squares = np.square(solve_triangular(lower, rest.T)).sum(axis=0)
        likelihood -= 0.5 * squares.reshape(likelihood.shape)
    elif settings.scale is None and not walked:
        return np.asarray(sum(maps) / len(maps))
    weights = exp(likelihood - likelihood.max())
    shares = (weights * scales).sum(axis=1) / weights.sum()
    return np.asarray(sum(share * map for share, map in zip(shares, maps, strict=True)))


def propose(prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings) -> Proposal | None:
    """Return the gait to try next; None once the adaptation has ended.

    The untried gait with the highest sum of mean and `kappa` standard deviations is chosen. Ties go
    to the first member. After the gaits of the map, changes of the best gait are tried.
    """
    prediction = predict_performance(prior, trials, settings)
    if _ending_of_map(prior, trials, settings, prediction):
        if refinements(trials) < settings.refine:
            return propose_change(prior, trials)
        return _repetition(trials, settings)
    return _propose_of_map(prediction, trials, settings)


def _propose_of_map(
    prediction: Prediction, trials: Sequence[Trial], settings: AdaptationSettings
) -> Proposal:
    bound = prediction.mean + settings.kappa * prediction.deviation
    bound[[trial.member - 1 for trial in trials]] = -np.inf
    chosen = int(np.argmax(bound))
    mean, deviation = float(prediction.mean[chosen]), float(prediction.deviation[chosen])
    return Proposal(len(trials) + 1, chosen + 1, mean, deviation)


def propose_change(prior: Prior, trials: Sequence[Trial]) -> Proposal:
    """Return a change of the best gait to try next; see `best_change`."""
    root = best_of([trial for trial in trials if not trial.genome])
    assert root is not None, "the gaits of the map are tried first"
    tried = [root, *(trial for trial in trials if trial.genome)]
    genomes = np.stack([genome_of(prior, trial) for trial in tried])
    measured = np.array([trial.lowest for trial in tried])
    number = len(trials) + 1
    genome, expected, deviation = best_change(prior, genomes, measured, number)
    return Proposal(number, root.member, expected, deviation, genome=genome)


def right_proposal(
    prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings, proposal: Proposal
) -> Proposal:
    """Return the proposal that follows from earlier trials, in place of a recorded one.

    When the trials of the map end does not matter, as a user may change `trials` and `stop`.
    """
    if (proposal.genome or refinements(trials)) and not all(trial.genome for trial in trials):
        return propose_change(prior, trials)
    return _propose_of_map(predict_performance(prior, trials, settings), trials, settings)


def fit(experiment: Experiment, trials: Sequence[Trial]) -> bool:
    """Return whether the genomes of changed gaits fit a body."""
    changed, space = [trial.genome for trial in trials if trial.genome], experiment.space()
    return {*map(len, changed)} <= {space.genes} and (
        not changed or space.contains(np.array(changed))
    )


def refinements(trials: Sequence[Trial]) -> int:
    """Return the number of changed gaits among the trials."""
    return sum(bool(trial.genome) for trial in trials)


def ending(prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings) -> str:
    """Return why the adaptation has ended, one sentence; '' until then."""
    reason = _ending_of_map(prior, trials, settings, predict_performance(prior, trials, settings))
    count = refinements(trials)
    if not reason or count < settings.refine or _repetition(trials, settings):
        return ""
    return f"{count} changes of the best gait were tried" if count else reason


def _repetition(trials: Sequence[Trial], settings: AdaptationSettings) -> Proposal | None:
    """Return the best gait if it is to be measured again after changed gaits."""
    best = best_of(trials)
    if best is None or not refinements(trials) or len(best.values) > settings.repeats:
        return None
    return Proposal(best.number, best.member, best.measured, 0.0, genome=best.genome)


def individual_of(prior: Prior, proposal: Proposal) -> Individual:
    """Return the proposed gait on the intact body; a change of a member has no number."""
    individual = prior.individual(proposal.member)
    if not proposal.genome:
        return individual
    return replace(individual, genome=genome_of(prior, proposal), member=None, generation=0)


def genome_of(prior: Prior, proposal: Proposal) -> Genomes:
    """Return the genome of a proposed gait, (genes,)."""
    if proposal.genome:
        return np.array(proposal.genome)
    return np.asarray(prior.genomes[proposal.member - 1])


def best_of(trials: Sequence[Trial]) -> Trial | None:
    """Return the trial with the best performance; ties go to the first trial.

    The lowest value counts for a gait that was measured several times.
    """
    return max(trials, key=lambda trial: trial.lowest, default=None)


def check_measured(measured: float, number: int) -> float:
    """Return the measured performance of a trial as a float."""
    try:
        value = float(measured)
    except (TypeError, ValueError):
        value = np.nan
    if not abs(value) < LARGEST_SCORE:
        raise GaitsimError(
            f"invalid measured value: {measured!r:.80}",
            where=f"trial {number}",
            allowed="a finite number",
        )
    return value


def _ending_of_map(
    prior: Prior, trials: Sequence[Trial], settings: AdaptationSettings, prediction: Prediction
) -> str:
    """Return why no further gait of the map is tried, or ''."""
    best = best_of(trials)
    if best is None:
        return ""
    if refinements(trials):
        return "changes of the best gait were tried"
    expected, unit = float(prediction.mean.max()), f" {prior.unit}".rstrip()
    enough = settings.scale is not None or len(trials) >= LEAST_TRIALS
    if enough and best.measured >= settings.stop * expected:
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


def count_gaits(run: RunSnapshot, *, physics: bool, known: bool = False) -> int:
    """Return the largest number of gaits that are measured before an adaptation.

    Args:
        run: run of the atlas.
        physics: whether the trials take place in physics.
        known: whether the damage is known, so that gaits are also measured on the damaged body.
    """
    members = len(atlas_members(run).scores)
    return members * (1 + known) + (min(members, MAX_MEASURED) if physics else 0)


def measure_intact(
    run: RunSnapshot,
    prior: Prior,
    measure_gait: MeasureGait,
    pool: Executor,
    on_progress: OnProgress = lambda done: None,
    *,
    cached: bool = True,
) -> dict[int, float]:
    """Measure the most promising gaits on the intact twin in rigid-body physics.

    Args:
        run: run of the atlas.
        prior: map for the atlas's own body.
        measure_gait: function that measures a gait on the twin.
        pool: thread pool in which the gaits are measured.
        on_progress: called with the number of gaits measured since the last call.
        cached: whether to read and write a file in the run's folder, which serves adaptations to
            other damage.

    Returns:
        The measured performance by member, counted from 1.
    """
    members = most_promising(prior, MAX_MEASURED)
    first = measure_gait(prior.individual(members[0]))  # loads the engine, which the key names
    name, key = f"{prior.measure} physics", cache_key(run, prior.measure, twin_of(prior.experiment))
    values = read_intact(run.path, name, key, len(members)) if cached else None
    if values is None:
        found = [first]
        on_progress(1)
        for value in pool.map(measure_gait, map(prior.individual, members[1:])):
            found.append(value)
            on_progress(1)
        values = np.array(found)
        if cached:
            write_intact(run.path, name, key, values)
    else:
        on_progress(len(members))
    if not values.max() > 0:
        raise GaitsimError(
            f"the measure {prior.measure!r} is not above 0 for any of the {len(values)} best "
            f"gaits of the atlas {prior.source} on the intact body in rigid-body physics",
            remedy="evolve the atlas further with 'gaitsim resume', or omit --physics",
        )
    return dict(zip(members, values.tolist(), strict=True))


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
    ratios = np.full(len(prior.performance), np.median(values / prior.performance[indices]))
    ratios[indices] = values / prior.performance[indices]
    performance = prior.performance * ratios
    performance[indices] = values
    damaged = None if prior.damaged is None else prior.damaged * ratios
    return replace(prior, performance=performance, damaged=damaged)

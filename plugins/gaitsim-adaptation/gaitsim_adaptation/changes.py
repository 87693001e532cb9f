"""Changes of the best gait, which search beyond the gaits of the map."""

import numpy as np

from gaitsim.plugin import GaitsimError, Genomes, RealSpace
from gaitsim.plugin.runs import Experiment
from gaitsim.plugin.toolkit import posterior, standard_normal
from gaitsim_adaptation.prior import Floats, Prior

# Chosen on one atlas in kinematics, for the loss of each leg and each adjacent pair. With visible
# damage, 3 trials keep 106 and 96 %; with two rounds, 99 and 91 %. With unknown damage and two
# rounds, 20 trials keep 103 and 88 %; without the prediction by simulation, 91 and 83 %, as with a
# (1+1) evolution strategy.
CANDIDATES = 300
STEPS = (0.01, 0.03, 0.06)  # standard deviations of a changed gene, as a share of its range
SHARE = 1 / 3  # of the genes that change
ROUNDS, KEPT = 8, 50  # rounds that change the best candidates again, and the candidates kept
LENGTH_SCALE = 0.3  # distance in genes, as a share of their ranges
NOISE = 0.01  # variance of a measurement, as a share of that of the trials
KAPPA = 0.5  # weight of the uncertainty


def genes_of(experiment: Experiment) -> RealSpace:
    """Return the genes of a body, which can be changed in small steps."""
    space = experiment.space()
    if not isinstance(space, RealSpace):
        raise GaitsimError(
            f"the gaits of {experiment.entries['organism']} cannot be changed in small steps: its "
            f"genes are {space.name}s",
            where="refine",
            allowed="0, or a body whose genes are real numbers",
        )
    return space


def best_change(
    prior: Prior, genomes: Genomes, measured: Floats, number: int
) -> tuple[tuple[float, ...], float, float]:
    """Return the most promising of some random changes of the best gait.

    The simulation predicts their performance, and a Gaussian process over the genes corrects the
    prediction by the trials. The change with the highest sum of mean and `KAPPA` standard
    deviations is chosen. A body in rigid-body physics is not simulated, as that takes too long.

    Args:
        prior: map whose body predicts the performance.
        genomes: tried gaits, the best of the map and its changes, (trials, genes).
        measured: their performance, (trials,).
        number: number of the trial, which seeds the draws.

    Returns:
        The genome, its expected performance and the standard deviation of that.
    """
    space, rng, count = genes_of(prior.experiment), np.random.default_rng(number), len(measured)
    best = int(np.argmax(measured))
    known = prior.simulate(genomes)
    weight = max(float(measured[best]), 0.0) / known[best] if known[best] > 0 else 0.0
    candidates = _changed(space, np.repeat(genomes[best : best + 1], CANDIDATES, axis=0), rng)
    predicted = weight * prior.simulate(candidates)
    for _ in range(ROUNDS if weight else 0):
        kept = candidates[np.argsort(-predicted, kind="stable")[:KEPT]]
        candidates = _changed(space, np.repeat(kept, CANDIDATES // KEPT, axis=0), rng)
        candidates[:KEPT] = kept
        predicted = weight * prior.simulate(candidates)
    rest = measured - weight * known
    spread = max(float(rest.std()), 0.02 * abs(float(measured[best])), 1e-12)
    mean, deviation = posterior(
        np.zeros(count + CANDIDATES),
        np.concatenate([genomes, candidates]) / space.width,
        np.arange(count),
        (rest - rest.mean()) / spread,
        LENGTH_SCALE,
        NOISE,
    )
    expected = predicted + rest.mean() + spread * mean[count:]
    chosen = int(np.argmax(expected + KAPPA * spread * deviation[count:]))
    genome = tuple(candidates[chosen].tolist())
    return genome, float(expected[chosen]), spread * float(deviation[count + chosen])


def _changed(space: RealSpace, genomes: Genomes, rng: np.random.Generator) -> Genomes:
    """Return changes of genomes, (candidates, genes)."""
    sizes = np.array(STEPS)[np.arange(len(genomes)) % len(STEPS), None]
    steps = standard_normal(rng, genomes.shape) * space.width * sizes
    return space.repair(genomes + np.where(rng.random(genomes.shape) < SHARE, steps, 0.0))

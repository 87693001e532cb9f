"""Changes of the best gait, which search beyond the gaits of the map."""

import numpy as np

from gaitsim.adaptation.prior import Floats
from gaitsim.contracts import Genomes, RealSpace
from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment
from gaitsim.gaussian_process import posterior
from gaitsim.portable import standard_normal

# Chosen on one atlas in kinematics: after 100 changes, the loss of one leg kept 101 %, and 96 %
# with a (1+1) evolution strategy of the same changes.
CANDIDATES = 100
STEP = 0.03  # standard deviation of a changed gene, as a share of its range; twice this for half
SHARE = 1 / 3  # of the genes that change
LENGTH_SCALE = 0.6  # distance in genes, as a share of their ranges
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
    space: RealSpace, genomes: Genomes, measured: Floats, number: int
) -> tuple[tuple[float, ...], float, float]:
    """Return the most promising of some random changes of the best gait.

    A Gaussian process over the genes predicts their performance from that of the tried gaits; the
    change with the highest sum of mean and `KAPPA` standard deviations is chosen.

    Args:
        space: genes of the gaits.
        genomes: tried gaits, the best of the map and its changes, (trials, genes).
        measured: their performance, (trials,).
        number: number of the trial, which seeds the draws.

    Returns:
        The genome, its expected performance and the standard deviation of that.
    """
    rng = np.random.default_rng(number)
    steps = standard_normal(rng, (CANDIDATES, space.genes)) * space.width * STEP
    steps[::2] *= 2
    changed = rng.random(steps.shape) < SHARE
    candidates = space.repair(genomes[np.argmax(measured)] + np.where(changed, steps, 0.0))
    spread = max(float(measured.std()), 0.02 * abs(float(measured.max())), 1e-12)
    middle, count = float(measured.mean()), len(measured)
    mean, deviation = posterior(
        np.zeros(count + CANDIDATES),
        np.concatenate([genomes, candidates]) / space.width,
        np.arange(count),
        (measured - middle) / spread,
        LENGTH_SCALE,
        NOISE,
    )
    chosen = int(np.argmax((mean + KAPPA * deviation)[count:])) + count
    genome = tuple(candidates[chosen - count].tolist())
    return genome, middle + spread * float(mean[chosen]), spread * float(deviation[chosen])

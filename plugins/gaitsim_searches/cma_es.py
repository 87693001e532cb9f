"""CMA-ES: samples from a normal distribution with adaptive mean, covariance and step size."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Context, Genomes, GenomeSpace, RealSpace, Results, Search, State, option
from gaitsim.plugin.toolkit import exp, log, matmul, power, principal_axes, standard_normal
from gaitsim_searches.real import real_space

MARGIN = 0.025
"""Distance from a bound, in widths, within which the fold is a parabola."""

REDRAWS = 3
"""Number of times that a sample beyond the bounds is redrawn.

The distribution learns wrong directions from samples mirrored at the bounds. More draws would keep
the mean away from optima on the bounds. With 3, the area under the ECDF on BBOB with 10 genes was
a fifth larger than with 0 (seven functions, six instances), and three quarters instead of two
fifths of 30 spiders from random starts reached a score of 2.6 in 10,000 evaluations.
"""


def beyond(points: NDArray[np.float64], space: RealSpace) -> NDArray[np.bool_]:
    """Return which points, (points, genes), are beyond a bound of a gene that is not periodic."""
    outside = (points < 0) | (points > 1)
    if space.periodic is not None:
        outside &= ~space.periodic
    return np.asarray(outside.any(axis=1))


def genomes(points: NDArray[np.float64], space: RealSpace) -> NDArray[np.float64]:
    """Return the genomes at unbounded points, (points, genes) in widths above `lower`.

    Genomes equal their points inside the box. Points are mirrored at the bounds along a parabola,
    so that the fold is smooth; periodic genes wrap (`BoundTransform` of pycma).
    """
    period = 2 + 4 * MARGIN
    # The distance from the middle of the fold at the lower bound is at most half a period.
    distance = np.mod(points + MARGIN, period)
    distance = np.minimum(distance, period - distance)
    # Distances to the nearer bound; short ones are flattened.
    near = np.minimum(distance, period / 2 - distance)
    inside = np.where(near < 2 * MARGIN, np.square(near) / (4 * MARGIN), near - MARGIN)
    folded = np.where(distance < period / 4, inside, 1 - inside)
    if space.periodic is not None:
        folded = np.where(space.periodic, np.mod(points, 1.0), folded)
    return space.repair(space.lower + space.width * folded)


def point(genome: NDArray[np.float64], space: RealSpace) -> NDArray[np.float64]:
    """Return a point that `genomes` maps to a genome, (genes,)."""
    share = np.clip((genome - space.lower) / space.width, 0, 1)
    near = np.minimum(share, 1 - share)
    inside = np.where(near < MARGIN, np.sqrt(4 * MARGIN * near) - MARGIN, near)
    unfolded = np.where(share < 0.5, inside, 1 - inside)
    return unfolded if space.periodic is None else np.where(space.periodic, share, unfolded)


@dataclass(frozen=True, eq=False)
class Rates:
    """Parameters of Hansen 2016, "The CMA evolution strategy: a tutorial", table 1, eq. 49 to 58.

    Attributes:
        weights: weights of the samples from best to worst, (samples,); positive weights sum to 1.
        parents: number of positive weights, µ.
        mass: variance effective selection mass, µ_eff.
        step: learning rate of the path of the step size, c_σ.
        damping: damping of the step size, d_σ.
        path: learning rate of the path of the covariance, c_c.
        rank_one: learning rate of the covariance's rank-one update, c_1.
        rank_mu: learning rate of the covariance's rank-µ update, c_µ.
        length: expected length of a vector of standard normal numbers.
    """

    weights: NDArray[np.float64]
    parents: int
    mass: float
    step: float
    damping: float
    path: float
    rank_one: float
    rank_mu: float
    length: float


@lru_cache
def rates(genes: int, samples: int, *, separable: bool, active: bool) -> Rates:
    """Return the default weights and learning rates.

    Args:
        genes: number of genes, n.
        samples: number of samples in each update, λ.
        separable: whether to learn only variances, (n + 2) / 3 times as fast (Ros and Hansen 2008,
            "A simple modification in CMA-ES achieving linear time and space complexity").
        active: whether bad samples shrink the covariance (Jastrebski and Arnold 2006, "Improving
            evolution strategies through active covariance matrix adaptation").
    """
    raw = log((samples + 1) / 2) - log(np.arange(1, samples + 1))
    parents = samples // 2
    good, bad = raw[:parents], raw[parents:]
    mass = np.square(good.sum()) / np.square(good).sum()
    bad_mass = np.square(bad.sum()) / np.square(bad).sum()

    # 3 as in pycma. With the tutorial's 5, the area under the ECDF on BBOB with two genes is 3 %
    # smaller.
    step = (mass + 2) / (genes + mass + 3)
    damping = 1 + 2 * max(0.0, np.sqrt((mass - 1) / (genes + 1)) - 1) + step
    path = (4 + mass / genes) / (genes + 4 + 2 * mass / genes)
    rank_one = 2 / (np.square(genes + 1.3) + mass)
    rank_mu = 2 * (0.25 + mass - 2 + 1 / mass) / (np.square(genes + 2) + mass)
    faster = (genes + 2) / 3 if separable else 1.0
    rank_one = min(1.0, faster * rank_one)
    rank_mu = min(1 - rank_one, faster * rank_mu)

    total = 0.0
    if active:
        total = min(
            1 + rank_one / rank_mu,  # the covariance neither grows nor shrinks overall
            1 + 2 * bad_mass / (mass + 2),
            (1 - rank_one - rank_mu) / (genes * rank_mu),  # the covariance stays positive definite
        )
    weights = np.concatenate([good / good.sum(), total * bad / np.abs(bad).sum()])
    length = np.sqrt(genes) * (1 - 1 / (4 * genes) + 1 / (21 * genes * genes))
    weights.setflags(write=False)
    return Rates(weights, parents, mass, step, damping, path, rank_one, rank_mu, length)


SMALLEST_SQUARE = 1e-200  # of the length of a sample; a start point has the length 0
LARGEST_CONDITION = 1e14  # condition number of the covariance
LONGEST_HISTORY = 20_000  # number of updates remembered


REASONS = (
    "",
    "the deviations of all genes are below the tolerance",
    "steps are too small to change the mean",
    "the covariance is nearly singular",
    "the range of recent best scores is below the tolerance",
    "scores have stopped rising",
)
"""Why a search has converged; '' if it has not."""


def converged(state: Mapping[str, NDArray[Any]], tolerance: float, score_tolerance: float) -> int:
    """Return why the search has converged, as an index of `REASONS` (Hansen 2016, appendix B.3).

    Args:
        state: state after an update.
        tolerance: smallest standard deviation worth sampling, in widths.
        score_tolerance: smallest range of the best scores of recent updates worth continuing for.
    """
    genes, samples, updates = len(state["mean"]), int(state["samples"]), int(state["updates"])
    step, mean, lengths = float(state["step"]), state["mean"], state["lengths"]
    covariance = state["covariance"]
    deviations = step * np.sqrt(np.diag(covariance) if covariance.ndim == 2 else covariance)
    axis = updates % genes
    along = np.eye(genes)[axis] if covariance.ndim == 1 else state["axes"][axis]
    if (deviations < tolerance).all() and (step * np.abs(state["path"]) < tolerance).all():
        return 1
    if (mean == mean + 0.1 * step * lengths[axis] * along).all():
        return 2
    if (mean == mean + 0.2 * deviations).any():
        return 2
    if lengths.max() > np.sqrt(LARGEST_CONDITION) * lengths.min():
        return 3
    best, middle = state["best scores"], state["middle scores"]
    recent = 10 + int(np.ceil(30 * genes / samples))
    if len(best) >= recent and _range(best[-recent:]) < score_tolerance:
        return 4
    stagnates = len(best) >= _history_length(genes, samples, updates) and all(
        _median(scores[-(len(scores) * 3 // 10) :]) <= _median(scores[: len(scores) * 3 // 10])
        for scores in (best, middle)
    )
    return 5 if stagnates else 0


def history(
    scores: NDArray[np.float64], latest: float, genes: int, samples: int, updates: int
) -> NDArray[np.float64]:
    """Append the latest score to a history, and drop scores that `converged` no longer needs."""
    return np.append(scores, latest)[-_history_length(genes, samples, updates) :]


def _history_length(genes: int, samples: int, updates: int) -> int:
    """Return the number of updates whose scores `converged` compares."""
    shortest = 120 + 30 * genes // samples
    return min(max(shortest, updates // 5), LONGEST_HISTORY)


def _median(scores: NDArray[np.float64]) -> float:
    """Return the median, in a fifth of the time of `np.median`."""
    ordered: list[float] = np.sort(scores).tolist()
    half = len(ordered) // 2
    return ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2


def _range(scores: NDArray[np.float64]) -> float:
    lowest, highest = scores.min(), scores.max()
    return 0.0 if lowest == highest else float(highest - lowest)  # 0 even if all are −inf


LARGEST_DEVIATION = 1 / 3
"""Largest standard deviation of a gene, in widths; larger ones already sample the whole range."""


class CmaEs(Search):
    """Learns which combined changes of genes raise the score, using only the ranks of scores.

    Samples come from a normal distribution whose mean, covariance and step size adapt to the best
    samples. The search begins around the first start point. After convergence, it restarts
    at the next start point, and after the last one at the first again. Without start points, it
    begins and restarts at random genomes.

    Hansen 2016, "The CMA evolution strategy: a tutorial"; Auger and Hansen 2005, "A restart CMA
    evolution strategy with increasing population size" (IPOP); Hansen 2009, "Benchmarking a
    BI-population CMA-ES on the BBOB-2009 function testbed" (BIPOP); Ros and Hansen 2008 for
    `separable`; Jastrebski and Arnold 2006 for `active`.
    """

    covariance: Literal["full", "separable"] = option(
        "full",
        "covariance matrix: 'full' learns dependencies between genes; 'separable' learns "
        "only variances, and is faster",
    )
    step: float = option(
        0.2,
        "standard deviation of the first samples, as a share of the gene's range, unless the body "
        "defines its own",
        gt=0,
        le=1,
    )
    start_step: float = option(
        0.1,
        "standard deviation of the first samples around a start point, as a share of the gene's "
        "range; if the body defines its own deviations, they shrink by the ratio to 'step'",
        gt=0,
        le=1,
    )
    active: bool = option(True, "whether bad samples shrink the covariance in their direction")
    restarts: Literal["ipop", "bipop", "stop", "none"] = option(
        "ipop",
        "after convergence: 'ipop' restarts, each time with twice the samples; 'bipop' spends as "
        "many evaluations again on restarts with fewer samples and smaller steps; 'stop' ends the "
        "run; 'none' continues",
    )
    tolerance: float = option(
        1e-12,
        "standard deviation of all genes below which the search has converged, as a share of their "
        "ranges",
        gt=0,
        lt=0.1,
    )
    score_tolerance: float = option(
        1e-12,
        "range of the best scores of recent updates below which the search has converged, in the "
        "unit of the score",
        ge=0,
        le=1e9,
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the population is too small, or ''."""
        if population < 4:
            return f"'cma-es' needs a population of at least 4, not {population}"
        return ""

    def initial(self, context: Context) -> State:
        """Return the state that holds the distribution of the first samples."""
        return self._initial_state(context, context.starts)

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Draw samples, (population, genes), for the next update of the distribution.

        The very first is the start point itself, if there is one.
        """
        space = real_space(context.space)
        drawn = self._draw(state, context.population, context)
        for _ in range(REDRAWS):
            outside = np.flatnonzero(beyond(state["mean"] + state["step"] * drawn, space))
            if not len(outside):
                break
            drawn[outside] = self._draw(state, len(outside), context)
        if len(context.starts):
            drawn[0] = 0
        points = state["mean"] + state["step"] * drawn
        return genomes(points, space), {**state, "drawn": drawn}

    def _draw(self, state: State, count: int, context: Context) -> NDArray[np.float64]:
        """Draw steps from the mean, (count, genes), in units of the step size."""
        drawn: NDArray[np.float64] = standard_normal(context.rng, (count, context.space.genes))
        drawn *= state["lengths"]
        return matmul(drawn, state["axes"]) if self.covariance == "full" else drawn

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Collect results; update the distribution once all samples of an update are evaluated.

        After convergence, or once a small run has used its evaluations, the search restarts.
        """
        steps = np.concatenate([state["steps"], state["drawn"]])
        scores = np.concatenate([state["scores"], results.scores])
        collected = {
            **state,
            "steps": steps,
            "scores": scores,
            "drawn": state["drawn"][:0],
            "evaluations": np.array(state["evaluations"] + len(results.scores)),
            "converged": np.array(0),
        }
        if len(scores) < state["samples"]:
            return {**collected, "waiting": np.concatenate([state["waiting"], results.genomes])}
        updated = self._updated(collected)
        reason = converged(updated, self.tolerance, self.score_tolerance)
        if self.restarts in ("stop", "none"):
            return {**updated, "converged": np.array(reason)}
        spent = 0 < updated["limit"] <= updated["evaluations"]
        return self._restarted(updated, context) if reason or spent else updated

    def centre(self, state: State, space: GenomeSpace) -> Genomes | None:
        """Return the mean of the distribution."""
        mean: Genomes = genomes(state["mean"][None], real_space(space))[0]
        return mean

    def finished(self, state: State) -> str:
        """Return why the search has converged, if the option `restarts` is 'stop'."""
        reason = REASONS[int(state["converged"])] if self.restarts == "stop" else ""
        return (
            f"'cma-es' has converged: {reason}; with 'search.restarts=ipop', it restarts"
            if reason
            else ""
        )

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the step size in widths, the condition number and the number of restarts."""
        lengths = state["lengths"]
        return {
            "step size": float(state["step"]),
            "condition number": float(np.square(lengths.max() / lengths.min())),
            "restarts": float(state["restarts"]),
        }

    def remembered(self, state: State) -> Genomes | None:
        """Return the samples whose update is not complete; None without any.

        Other scores matter only as ranks within an update.
        """
        return state["waiting"] if len(state["waiting"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with new scores of the waiting samples, and without a history.

        The distribution stays: what it has learned may hold for the new scores as well.
        """
        none = np.empty(0)
        return {
            **state,
            "scores": results.scores,
            "best scores": none,
            "middle scores": none,
            "converged": np.array(0),
        }

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit the space or the covariance, or ''."""
        genes = context.space.genes
        if state["mean"].shape != (genes,):
            return f"its distribution has {state['mean'].size} genes, but the body has {genes}"
        expected = (genes, genes) if self.covariance == "full" else (genes,)
        if state["covariance"].shape != expected:
            return f"its covariance is not {self.covariance}"
        samples = int(state["samples"])
        if samples <= 0 or samples % context.population or state["converged"] not in range(6):
            return f"its updates of {samples} samples do not fit the population"
        return ""

    def _restarted(self, state: State, context: Context) -> State:
        """Return the state after a restart, Hansen 2009, section 2.

        The number of samples is a multiple of the population. As in pycma, the evaluations of the
        first run count as those of a small one, and a small run takes at most half the evaluations
        of all large runs so far.
        """
        doublings, large = int(state["doublings"]), int(state["large evaluations"])
        small = int(state["small evaluations"])
        if doublings and not state["limit"]:
            large += int(state["evaluations"])
        else:
            small += int(state["evaluations"])
        shrinkage, limit = 1.0, 0
        if self.restarts == "bipop" and small < large:
            share, exponent = context.rng.random(2)
            multiple = int(power(2.0, (doublings - 1) * np.square(share)))
            shrinkage, limit = float(power(10.0, -2 * exponent)), large // 2
        else:
            doublings += 1
            multiple = 2**doublings
        return {
            **self._initial_state(context, state["starts"], shrinkage),
            "samples": np.array(context.population * multiple),
            "restarts": np.array(state["restarts"] + 1),
            "doublings": np.array(doublings),
            "large evaluations": np.array(large),
            "small evaluations": np.array(small),
            "limit": np.array(limit),
        }

    def _initial_state(self, context: Context, starts: Genomes, shrinkage: float = 1.0) -> State:
        """Return the state around the first start point, or around a random genome without any.

        Args:
            context: space, population and randomness.
            starts: start points, the next one first, (starts, genes).
            shrinkage: factor of the first step size.
        """
        space = real_space(context.space)
        genes = space.genes
        deviations = np.full(genes, self.step)
        if space.initial_sigma is not None:
            deviations = space.initial_sigma / space.width
        if len(starts):
            deviations = deviations * (self.start_step / self.step)
        deviations = deviations * shrinkage
        step = np.sqrt(np.mean(np.square(deviations)))
        lengths = deviations / step
        full = self.covariance == "full"
        return {
            "mean": point(starts[0] if len(starts) else context.random(1)[0], space),
            "step": np.array(step),
            "covariance": np.diag(np.square(lengths)) if full else np.square(lengths),
            "lengths": lengths,
            "axes": np.eye(genes if full else 0),
            "path": np.zeros(genes),
            "step path": np.zeros(genes),
            "updates": np.array(0),
            "decomposed": np.array(0),
            "samples": np.array(context.population),
            "evaluations": np.array(0),
            "converged": np.array(0),
            "restarts": np.array(0),
            "doublings": np.array(0),
            "large evaluations": np.array(0),
            "small evaluations": np.array(0),
            "limit": np.array(0),
            "starts": np.roll(np.asarray(starts, np.float64).reshape(-1, genes), -1, axis=0),
            "drawn": np.empty((0, genes)),
            "steps": np.empty((0, genes)),
            "waiting": np.empty((0, genes)),
            "scores": np.empty(0),
            "best scores": np.empty(0),
            "middle scores": np.empty(0),
        }

    def _updated(self, state: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Return the state after one generation of CMA-ES, Hansen 2016, figure 6."""
        scores, covariance, lengths = state["scores"], state["covariance"], state["lengths"]
        samples, genes = state["steps"].shape
        full = self.covariance == "full"
        rate = rates(genes, samples, separable=not full, active=self.active)
        updates = int(state["updates"]) + 1

        steps = state["steps"][np.argsort(-scores, kind="stable")]
        # The samples in coordinates in which they are standard normal.
        white = matmul(steps, state["axes"].T) if full else steps
        white = white / lengths
        best = rate.weights[: rate.parents]
        move = matmul(best[None], steps[: rate.parents])[0]
        white_move = matmul(best[None], white[: rate.parents])[0]
        if full:
            white_move = matmul(white_move[None], state["axes"])[0]

        step_path = (1 - rate.step) * state["step path"]
        step_path += np.sqrt(rate.step * (2 - rate.step) * rate.mass) * white_move
        length = np.sqrt(np.sum(np.square(step_path)))
        # After many updates, the path no longer remembers its start: 1 − e⁻³⁸ rounds to 1.
        bias = power(1 - rate.step, 2 * updates) if 2 * updates * rate.step < 38 else 0.0
        unbiased = length / np.sqrt(1 - bias)
        steady = float(unbiased < (1.4 + 2 / (genes + 1)) * rate.length)
        path = (1 - rate.path) * state["path"]
        path += steady * np.sqrt(rate.path * (2 - rate.path) * rate.mass) * move

        weights = rate.weights.copy()
        squares = np.sum(np.square(white[rate.parents :]), axis=1)
        weights[rate.parents :] *= genes / np.maximum(squares, SMALLEST_SQUARE)
        kept = 1 - rate.rank_one - rate.rank_mu * rate.weights.sum()
        kept += rate.rank_one * (1 - steady) * rate.path * (2 - rate.path)
        if full:
            rank_mu_update = matmul((weights[:, None] * steps).T, steps)
            covariance = (
                kept * covariance
                + rate.rank_one * np.outer(path, path)
                + rate.rank_mu * rank_mu_update
            )
            covariance = (covariance + covariance.T) / 2
        else:
            rank_mu_update = matmul(weights[None], np.square(steps))[0]
            covariance = (
                kept * covariance + rate.rank_one * np.square(path) + rate.rank_mu * rank_mu_update
            )

        step = state["step"] * exp(min(1, rate.step / rate.damping * (length / rate.length - 1)))
        variances = np.diag(covariance) if full else covariance
        excess = np.maximum(1, step * np.sqrt(variances) / LARGEST_DEVIATION)
        if (excess > 1).any():
            covariance = covariance / (np.outer(excess, excess) if full else np.square(excess))
        updated = {
            **state,
            "mean": state["mean"] + state["step"] * move,
            "step": np.array(step),
            "covariance": covariance,
            "path": path,
            "step path": step_path,
            "updates": np.array(updates),
            "steps": state["steps"][:0],
            "waiting": state["waiting"][:0],
            "scores": scores[:0],
            "best scores": history(state["best scores"], scores.max(), genes, samples, updates),
            "middle scores": history(
                state["middle scores"], _median(scores), genes, samples, updates
            ),
        }
        if not full:
            updated["lengths"] = np.sqrt(covariance)
        elif updates - int(state["decomposed"]) > 1 / (10 * genes * (rate.rank_one + rate.rank_mu)):
            variances, axes = principal_axes(covariance)
            updated["lengths"], updated["axes"] = np.sqrt(np.maximum(variances, 1e-300)), axes
            updated["decomposed"] = np.array(updates)
        return updated

"""Differential evolution with adaptive scale factor and crossover rate: SHADE."""

from collections.abc import Mapping
from math import ceil
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import Context, Genomes, GenomeSpace, RealSpace, Results, Search, State, option
from gaitsim.plugin.toolkit import arctan, standard_normal, tan
from gaitsim_searches.real import differences, halved_past_bounds, real_space

SMALLEST = 4  # individuals: the one to move, one of the best, and two others
SPREAD = 0.1  # spread of F and CR around the memory; Tanabe and Fukunaga 2013, eq. 1 and 2
# The paper starts with 0.5 for both. On BBOB in 2 dimensions, three instances, an initial CR of
# 0.9 raised the area under the ECDF from 0.308 to 0.326.
FIRST_SCALE, FIRST_RATE = 0.5, 0.9
EQUAL = 1e-12  # relative difference of scores that counts as rounding
NARROW = 1e-9  # largest spread of converged genomes, as a share of a gene's width

Floats = NDArray[np.float64]


class DifferentialEvolution(Search):
    """Moves every genome towards one of the best and along the difference of two others.

    SHADE draws the scale factor F and the crossover rate CR of each trial around values that
    worked before. Once all genomes or all scores are equal, the search restarts from random
    genomes.

    Tanabe and Fukunaga 2013, "Success-history based parameter adaptation for differential
    evolution"; mutation towards the p best, archive and bounds: Zhang and Sanderson 2009, "JADE:
    adaptive differential evolution with optional external archive"; restarts: Tanabe and Fukunaga
    2015, "Tuning differential evolution for cheap, medium, and expensive computational budgets".
    """

    greediness: float = option(
        0.1,
        "share of the population, at least two individuals, that counts as the best, towards which "
        "all others move",
        gt=0,
        le=1,
    )
    memory: int = option(
        6,
        "number of remembered pairs of scale factor F and crossover rate CR that worked",
        ge=1,
        le=1000,
    )
    archive: float = option(
        1.0, "size of the archive of replaced genomes, in populations", ge=0, le=10
    )
    restarts: bool = option(
        True, "whether to restart after convergence; otherwise, the run ends at convergence"
    )
    start_share: float = option(
        0.25,
        "share of the first genomes that are start points and genomes near them, if the body has "
        "start points; the rest is random",
        gt=0,
        le=1,
    )
    spread: float = option(
        0.1,
        "standard deviation of the first genomes around a start point, as a share of the gene's "
        "range",
        gt=0,
        le=1,
    )

    portable: ClassVar[bool] = True
    spaces: ClassVar[tuple[type[GenomeSpace], ...]] = (RealSpace,)

    def objection(self, space: GenomeSpace, population: int) -> str:
        """Return why the population is too small, or ''."""
        if population < SMALLEST:
            return (
                f"'differential-evolution' needs a population of at least {SMALLEST}, "
                f"not {population}"
            )
        return ""

    def initial(self, context: Context) -> State:
        """Return a state without genomes, which the first call of `tell` adds."""
        nothing = np.zeros((0, context.space.genes))
        return {
            "genomes": nothing,
            "scores": np.zeros(0),
            "archive": nothing,
            "memory F": np.full(self.memory, FIRST_SCALE),
            "memory CR": np.full(self.memory, FIRST_RATE),
            "next": np.array(0),
            "trial F": np.zeros(0),
            "trial CR": np.zeros(0),
            "restarts": np.array(0),
            "converged": np.array(False),
        }

    def ask(self, state: State, last: Results | None, context: Context) -> tuple[Genomes, State]:
        """Return the first genomes, then one trial for each genome, (population, genes)."""
        space, rng, genomes = real_space(context.space), context.rng, state["genomes"]
        if not len(genomes):
            return context.begin(self.start_share, lambda one: self._near(one, context)), state
        place = rng.integers(self.memory, size=len(genomes))
        scale = draw_scales(state["memory F"][place], rng)
        rate = np.clip(
            state["memory CR"][place] + SPREAD * standard_normal(rng, len(genomes)), 0, 1
        )
        best, one, other = self._draw_others(state, rng)
        itself = np.arange(len(genomes))
        context.record_parents(np.stack([itself, np.where(best == itself, one, best)], axis=1))
        steps = differences(genomes[best], genomes, space)
        steps += differences(genomes[one], other, space)
        mutants = halved_past_bounds(genomes + scale[:, None] * steps, genomes, space)
        crossed = rng.random(genomes.shape) < rate[:, None]
        # At least one gene is crossed; otherwise the trial would equal the genome.
        crossed[np.arange(len(genomes)), rng.integers(space.genes, size=len(genomes))] = True
        trials = np.where(crossed, mutants, genomes)
        return trials, {**state, "trial F": scale, "trial CR": rate}

    def _near(self, genomes: Genomes, context: Context) -> Genomes:
        """Return genomes near others; they must be repaired."""
        space = real_space(context.space)
        near: Genomes = genomes + self.spread * space.width * standard_normal(
            context.rng, genomes.shape
        )
        return near

    def _draw_others(
        self, state: State, rng: np.random.Generator
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Genomes]:
        """Draw for each genome the rows of one of the best and of another, and a third genome.

        The third may be from the archive.
        """
        genomes, everyone = state["genomes"], np.concatenate([state["genomes"], state["archive"]])
        count, itself = len(genomes), np.arange(len(genomes))
        ranked = np.argsort(-state["scores"], kind="stable")
        best = ranked[rng.integers(max(2, ceil(self.greediness * count)), size=count)]
        # Draw from a smaller range, then skip the indices that are taken.
        one = rng.integers(count - 1, size=count)
        one += one >= itself
        other = rng.integers(len(everyone) - 2, size=count)
        other += other >= np.minimum(itself, one)
        other += other >= np.maximum(itself, one)
        return best, one, everyone[other]

    def tell(self, state: State, results: Results, context: Context) -> State:
        """Replace genomes by trials with scores at least as high; update the memory of F and CR."""
        genomes, scores = state["genomes"], state["scores"]
        if not len(genomes):
            return self.rescored(state, results, context)
        kept, better = results.scores >= scores, results.scores > scores
        archive = np.concatenate([state["archive"], genomes[better]])
        size = round(self.archive * len(genomes))
        if len(archive) > size:
            archive = archive[context.rng.permutation(len(archive))[:size]]
        updated = {
            **state,
            **self._updated_memory(state, results.scores, better),
            "genomes": np.where(kept[:, None], results.genomes, genomes),
            "scores": np.where(kept, results.scores, scores),
            "archive": archive,
        }
        done = converged(updated["genomes"], updated["scores"], real_space(context.space))
        if done and self.restarts:
            return {**self.initial(context), "restarts": np.array(state["restarts"] + 1)}
        return {**updated, "converged": np.array(done)}

    def finished(self, state: State) -> str:
        """Return that all genomes or all scores are equal, if the search does not restart."""
        if self.restarts or not state["converged"]:
            return ""
        return (
            "'differential-evolution' has converged: all genomes or all scores are equal; with "
            "'search.restarts=true', it restarts"
        )

    def _updated_memory(self, state: State, scores: Floats, better: NDArray[np.bool_]) -> State:
        """Return the memory after F and CR of better trials have replaced its oldest entry."""
        if not better.any():
            return {}
        weights, place = gains(state["scores"][better], scores[better]), int(state["next"])
        scale, rate = state["memory F"].copy(), state["memory CR"].copy()
        scale[place] = lehmer_mean(state["trial F"][better], weights)
        rate[place] = np.sum(weights * state["trial CR"][better])
        following = np.array((place + 1) % self.memory)
        return {"memory F": scale, "memory CR": rate, "next": following}

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the mean F and CR of the memory, and the number of restarts."""
        return {
            "mean F": float(state["memory F"].mean()),
            "mean CR": float(state["memory CR"].mean()),
            "restarts": float(state["restarts"]),
        }

    def remembered(self, state: State) -> Genomes | None:
        """Return the genomes that trials are compared with, (population, genes)."""
        return state["genomes"] if len(state["genomes"]) else None

    def rescored(self, state: State, results: Results, context: Context) -> State:
        """Return the state with the new scores of its genomes."""
        new = {"genomes": results.genomes.copy(), "scores": results.scores.copy()}
        return {**state, **new, "converged": np.array(False)}

    def mismatch(self, state: State, context: Context) -> str:
        """Return why a state does not fit the genes, the population or the memory, or ''."""
        genomes, memory = state["genomes"], len(state["memory F"])
        if genomes.shape[1:] != (context.space.genes,):
            return (
                f"its genomes have {genomes.shape[-1]} genes, but the body has "
                f"{context.space.genes}"
            )
        if len(genomes) not in (0, context.population):
            return f"it holds {len(genomes)} genomes, but the population is {context.population}"
        if memory != self.memory:
            return f"it holds {memory} pairs of F and CR, but the option 'memory' is {self.memory}"
        return ""


def draw_scales(middle: Floats, rng: np.random.Generator) -> Floats:
    """Draw scale factors above 0 and at most 1, Cauchy distributed around `middle` with scale 0.1.

    Tanabe and Fukunaga repeat draws until a factor is above 0; inverting the distribution above 0
    gives the same result with one draw.
    """
    below = 0.5 - arctan(middle / SPREAD) / np.pi
    share = 1 - (1 - below) * rng.random(len(middle))  # above `below`, at most 1
    # tan(π/2) is large, but finite; rounding may put the smallest factors below 0.
    drawn = middle + SPREAD * tan(np.pi * (share - 0.5))
    return np.clip(drawn, np.finfo(float).tiny, 1)


def gains(before: Floats, after: Floats) -> Floats:
    """Return weights in proportion to the gains of scores; their sum is 1.

    The gain over a failed genome, whose score is −inf, counts as the largest other gain.
    """
    gained = after - before
    finite = np.isfinite(gained)
    gained = np.where(finite, gained, gained[finite].max(initial=0) or 1)
    return gained / np.sum(gained)


def lehmer_mean(values: Floats, weights: Floats) -> float:
    """Return Σ w v² / Σ w v, which favours large values because small steps succeed more often."""
    return float(np.sum(weights * np.square(values)) / np.sum(weights * values))


def converged(genomes: Genomes, scores: Floats, space: RealSpace) -> bool:
    """Return whether all scores or all genomes are equal up to rounding."""
    best = scores.max()
    if (scores >= best - EQUAL * abs(best)).all():
        return True
    spread = differences(genomes, genomes[:1], space) / space.width
    return bool((np.abs(spread) < NARROW).all())

"""Constraints: a search sees scores with penalties, which lead it to the best feasible individual.

    evaluate ─▶ scores and constraint values ─▶ penalised scores ─▶ tell ─▶ adapt the penalties

The penalties are those of an augmented Lagrangian, so that the penalised optimum is the constrained
one. With the violation g of each constraint, at most 0 if it is satisfied, the penalty is
λ g + µ g² / 2, or −λ² / (2 µ) if g is below −λ / µ. The multipliers λ and the weights µ adapt to
the individual with the best penalised score of each generation.

Source: Atamna, Auger and Hansen 2017, "Linearly convergent evolution strategies via augmented
Lagrangian constraint handling"; Dufossé and Hansen 2021, "Augmented Lagrangian, penalty techniques
and surrogate modeling for constrained optimization with CMA-ES". The coefficients adapt as in
`ConstrainedFitnessAL` of pycma 4.5, for a score that is maximised.

"""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Results, State
from gaitsim.evolution.context import CheckedContext, WrappedSearch, check_state
from gaitsim.evolution.transferability import rows_of
from gaitsim.portable import power

Floats = NDArray[np.float64]

PREFIX = "constraints: "
"""Prefix of the names of the coefficients in the state of a search."""

DAMPING = 5  # of changes of the multipliers


@dataclass(frozen=True, eq=False)
class Lagrangian:
    """The coefficients of an augmented Lagrangian.

    Attributes:
        multipliers: multiplier λ of each constraint, (constraints,).
        weights: weight µ of each squared violation, (constraints,); 0 until individuals violate the
            constraint.
        initialised: whether both have their initial values, (constraints,) bool.
        streaks: number of successive increases of each weight, or minus that of decreases,
            (constraints,) int64.
        recent: violations of the best individuals of recent generations, (generations,
            constraints).
        updates: number of updates, () int64.
        feasible: share of feasible individuals in the last generation, ().
        kept_scores: scores, without penalties, of the genomes that the search remembers, (kept,).
        kept_violations: their violations, (kept, constraints).
    """

    multipliers: Floats
    weights: Floats
    initialised: NDArray[np.bool_]
    streaks: NDArray[np.int64]
    recent: Floats
    updates: NDArray[np.int64]
    feasible: Floats
    kept_scores: Floats
    kept_violations: Floats

    @classmethod
    def initial(cls, constraints: int) -> "Lagrangian":
        """Return coefficients without penalties."""
        zeros = np.zeros(constraints)
        return cls(
            multipliers=zeros,
            weights=zeros,
            initialised=np.zeros(constraints, np.bool_),
            streaks=np.zeros(constraints, np.int64),
            recent=np.empty((0, constraints)),
            updates=np.array(0),
            feasible=np.array(0.0),
            kept_scores=np.empty(0),
            kept_violations=np.empty((0, constraints)),
        )

    @classmethod
    def of(cls, state: State) -> "Lagrangian":
        """Return the coefficients in the state of a search."""
        return cls(**{one.name: state[PREFIX + one.name] for one in fields(cls)})

    def join(self, state: State) -> State:
        """Return the state of the inner search with the coefficients."""
        return {**state, **{PREFIX + one.name: getattr(self, one.name) for one in fields(self)}}

    def penalties(self, violations: Floats) -> Floats:
        """Return the penalty of each individual, (individuals,).

        Args:
            violations: violation of each constraint, (individuals, constraints).
        """
        started = self.weights > 0
        lowest = -self.multipliers / np.where(started, self.weights, 1.0)
        g = np.where(started, np.maximum(violations, lowest), 0.0)
        return np.asarray((self.multipliers * g + self.weights * np.square(g) / 2).sum(axis=1))

    def penalised(self, scores: Floats, violations: Floats) -> Floats:
        """Return scores minus penalties, (individuals,); −inf for failed individuals."""
        alive = np.isfinite(scores)
        found = np.full(scores.shape, -np.inf)
        found[alive] = scores[alive] - self.penalties(violations[alive])
        return found

    def keep(
        self, genomes: Genomes | None, pool: Genomes, scores: Floats, violations: Floats
    ) -> "Lagrangian":
        """Return the coefficients with the values of the genomes that the search remembers.

        Args:
            genomes: genomes that the search remembers, (kept, genes), or None.
            pool: genomes among which they are, (pool, genes).
            scores: scores of the pool without penalties, (pool,).
            violations: violations of the pool, (pool, constraints).
        """
        rows = np.empty(0, np.intp) if genomes is None else rows_of(genomes, pool)
        return replace(self, kept_scores=scores[rows], kept_violations=violations[rows])

    def adapted(self, costs: Floats, violations: Floats, genes: int) -> "Lagrangian":
        """Return the coefficients after a generation.

        Args:
            costs: negative score of each individual that did not fail otherwise, (individuals,).
            violations: their violations, (individuals, constraints).
            genes: number of genes.
        """
        feasible = np.array((violations <= 0).all(axis=1).mean())
        best = int(np.argmin(costs + self.penalties(violations)))
        penalised = np.any(self.weights * violations > -self.multipliers, axis=0)
        started = replace(self, feasible=feasible)
        if not self.initialised.all():
            started = started._initialised(costs, violations, genes)
        return started._updated(violations[best], penalised, genes)

    def _initialised(self, costs: Floats, violations: Floats, genes: int) -> "Lagrangian":
        """Return the coefficients, with initial values for constraints that are violated."""
        balance = 2 * (violations > 0).mean(axis=0) - 1  # −1 if all satisfy it, 1 if none does
        chosen = (~self.initialised | (self.weights == 0)) & (balance > -0.8)
        spread = _quartile_range(costs[:, None])[0]
        spreads = _quartile_range(violations)
        squares = _quartile_range(np.square(violations))
        tiny = 1e-11 * (spread + 1)
        weights = 0.4 * spread / genes / (spreads + 1e-6 * squares + tiny)
        multipliers = spread / (genes * spreads + tiny)
        lower = (balance <= 0.2) & (self.weights > weights)
        multipliers *= np.where(lower, weights / np.where(lower, self.weights, 1.0), 1.0)
        largest = multipliers / (1e-22 + np.abs(violations).max(axis=0))
        weights = np.minimum(20 * weights, np.maximum(weights, largest))
        settled = (np.abs(balance) < 0.8) | (self.updates > 2 + genes)
        return replace(
            self,
            multipliers=np.where(chosen, multipliers, self.multipliers),
            weights=np.where(chosen, weights, self.weights),
            initialised=self.initialised | (chosen & settled),
        )

    def _updated(self, best: Floats, penalised: NDArray[np.bool_], genes: int) -> "Lagrangian":
        """Return the coefficients, adapted to the violations of the best individual.

        Args:
            best: violation of each constraint, (constraints,).
            penalised: whether any individual has a penalty that depends on the constraint,
                (constraints,).
            genes: number of genes.
        """
        horizon = 5 + genes
        recent = np.concatenate([self.recent, best[None]])[-horizon:]
        satisfied = ((recent < 0) + 0.5 * (recent == 0)).mean(axis=0)
        active = self.weights > 0
        moved = active & (penalised | (self.weights * best > -self.multipliers))
        shifted = self.multipliers + np.where(moved, self.weights * best / DAMPING, 0.0)
        multipliers = np.maximum(shifted, 0.0)
        # A constraint that stays satisfied keeps its weight, which would diverge.
        relevant = active & (shifted >= 0) & (self.weights * best >= -multipliers)
        inside = self.weights * best > -multipliers
        up = relevant & ((best > 0) | (inside & (satisfied > 0.95)))
        down = relevant & ~up & (best < 0) & (satisfied < 0.9)
        change = up.astype(np.int64) - down.astype(np.int64)
        streaks = np.where(change * self.streaks < 0, 0, self.streaks) + change
        # The longer a weight changes in one direction, the faster.
        patience = 2 + len(best)
        extra = 4 / patience * np.clip(np.abs(streaks) - patience, 0, patience)
        factors = power(2.0, change * 0.25 * (1 + extra) / (5 * genes))
        return replace(
            self,
            multipliers=multipliers,
            weights=self.weights * factors,
            streaks=streaks,
            recent=recent,
            updates=np.asarray(self.updates + 1),
        )


def _quartile_range(values: Floats) -> Floats:
    """Return the interquartile range of each column, (columns,), interpolated linearly."""
    ordered = np.sort(values, axis=0)
    found = []
    for share in (0.25, 0.75):
        place = share * (len(values) - 1)
        below = int(place)
        above = min(below + 1, len(values) - 1)
        found.append(ordered[below] + (place - below) * (ordered[above] - ordered[below]))
    return np.asarray(found[1] - found[0])


class ConstrainedSearch(WrappedSearch):
    """A search that sees penalised scores; it has the methods of `Search`.

    The state is that of the inner search, with the coefficients of the penalties.
    """

    prefix = PREFIX

    def initial(self, context: CheckedContext) -> State:
        """Return the state before the first generation."""
        start = Lagrangian.initial(len(self._experiment.constraints.names))
        return start.join(self._search.initial(context))

    def ask(
        self, state: State, last: Results | None, context: CheckedContext
    ) -> tuple[Genomes, State]:
        """Return the genomes of a generation, and the state for `tell`."""
        found, before = Lagrangian.of(state), self._inner(state)
        if last is not None:
            last = self._penalised(found, last)
        genomes, after = self._search.ask(before, last, context)
        return genomes, found.join(after)

    def tell(self, state: State, results: Results, context: CheckedContext) -> State:
        """Return the state after a generation, with adapted penalties."""
        found, before = Lagrangian.of(state), self._inner(state)
        genomes = self._search.remembered(before)
        genomes = results.genomes[:0] if genomes is None else genomes
        # The penalties have changed, so earlier scores cannot be compared with new ones.
        earlier = Results(genomes, found.penalised(found.kept_scores, found.kept_violations))
        details = replace(context, rng=deepcopy(context.rng))
        before = self._search.rescored(before, earlier, details)
        after = self._search.tell(before, self._penalised(found, results), context)
        after = check_state(self._experiment, after)
        scores, violations = self._values(results)
        found = found.keep(
            self._search.remembered(after),
            np.concatenate([genomes, results.genomes]),
            np.concatenate([found.kept_scores, scores]),
            np.concatenate([found.kept_violations, violations]),
        )
        alive = np.isfinite(scores)
        if alive.any():
            found = found.adapted(-scores[alive], violations[alive], results.genomes.shape[1])
        return found.join(after)

    def remembered(self, state: State) -> Genomes | None:
        """Return the genomes that the inner search remembers."""
        return self._search.remembered(self._inner(state))

    def rescored(self, state: State, results: Results, context: CheckedContext) -> State:
        """Return the state with new scores of the genomes in `remembered`."""
        found, before = Lagrangian.of(state), self._inner(state)
        if len(results.genomes):
            found = found.keep(results.genomes, results.genomes, *self._values(results))
            results = self._penalised(found, results)
        return found.join(self._search.rescored(before, results, context))

    def figures(self, state: State) -> Mapping[str, float]:
        """Return the figures of the inner search, and the share of feasible individuals."""
        return {**super().figures(state), "feasible share": float(Lagrangian.of(state).feasible)}

    def mismatch(self, state: State, context: CheckedContext) -> str:
        """Return why a stored state does not fit; '' if it does."""
        if wrong := self._search.mismatch(self._inner(state), context):
            return wrong
        found, number = Lagrangian.of(state), len(self._experiment.constraints.names)
        columns = (found.multipliers, found.weights, found.initialised, found.streaks)
        if any(one.shape != (number,) for one in columns) or found.recent.shape[1:] != (number,):
            return f"its penalties are not those of {number} constraints"
        genomes = self._search.remembered(self._inner(state))
        kept = 0 if genomes is None else len(genomes)
        if found.kept_scores.shape != (kept,) or found.kept_violations.shape != (kept, number):
            return f"it does not have the values of {kept} remembered genomes"
        return ""

    def _penalised(self, found: Lagrangian, results: Results) -> Results:
        """Return results with penalised scores, also for infeasible individuals."""
        return replace(results, scores=found.penalised(*self._values(results)))

    def _values(self, results: Results) -> tuple[Floats, Floats]:
        """Return the scores without constraints and the violations; −inf for failed individuals."""
        violations = self._experiment.constraints.violations(results.values)
        scores = np.asarray(results.values["score"])
        failed = ~(np.isfinite(violations).all(axis=1) & np.isfinite(scores))
        return np.where(failed, -np.inf, scores), violations

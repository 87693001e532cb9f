"""The transferability approach: from a few tests in reality, learn where the simulation is wrong.

    evaluate ─▶ predict the transferability from the tests ─▶ tell ─▶ every few generations, test
    one individual in reality ─▶ update the predictions of the individuals that the search keeps

Source: Koos, Mouret and Doncieux 2013, "The transferability approach: crossing the reality gap in
evolutionary robotics". The disparity between simulation and reality is learnt by Kriging over a few
features of behaviour. The individual to test is the one whose behaviour differs most from that of
the individuals tested before. Here, the disparity is the absolute difference between the scores.
"""

import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Genomes, GenomeSpace, Results, State
from gaitsim.evaluation import evaluate
from gaitsim.evaluation.worlds import in_reality
from gaitsim.evolution.context import CheckedContext, WrappedSearch, check_state
from gaitsim.experiment import FEATURES, TRANSFERABILITY, Experiment
from gaitsim.gaussian_process import posterior
from gaitsim.portable import distances
from gaitsim.registry import plugin_errors

Floats = NDArray[np.float64]

PREFIX = f"{TRANSFERABILITY}: "
"""Prefix of the names of the model's arrays in the state of a search."""

NOISE = 0.01
"""Variance of a measured disparity, as a share of the variance between individuals."""


@dataclass(frozen=True, eq=False)
class RealityTests:
    """The tests in reality so far, and the values of the individuals that the search keeps.

    Attributes:
        genomes: genomes of the individuals tested, (tests, genes).
        generations: number of the generation of each test, (tests,) int64.
        features: features of the simulated motions, (tests, features).
        simulated: scores in simulation, (tests,).
        real: scores in reality, (tests,); −inf for individuals that failed there.
        predicted: disparities that were predicted before the tests, (tests,); 0 for the first.
        centre: value of each feature that is standardised to 0, (features,).
        spread: distance from the centre that is standardised to 1, (features,).
        kept_scores: scores of the individuals that the search keeps, (kept,).
        kept_values: values of these individuals that the search and the model read,
            (kept, values).
    """

    genomes: Genomes
    generations: NDArray[np.int64]
    features: Floats
    simulated: Floats
    real: Floats
    predicted: Floats
    centre: Floats
    spread: Floats
    kept_scores: Floats
    kept_values: Floats

    @property
    def count(self) -> int:
        """The number of tests."""
        return len(self.real)

    @classmethod
    def none(cls, space: GenomeSpace) -> "RealityTests":
        """Return an empty set of tests for genomes of a space."""
        shapes: dict[str, tuple[int, ...]] = {"features": (0, 0), "kept_values": (0, 0)}
        empty = {one.name: np.empty(shapes.get(one.name, (0,))) for one in fields(cls)}
        genomes = np.empty((0, space.genes), space.dtype)
        return cls(**{**empty, "genomes": genomes, "generations": np.empty(0, np.int64)})

    @classmethod
    def of(cls, state: State) -> "RealityTests | None":
        """Return the tests in the state of a search; None without a model."""
        if not any(name.startswith(PREFIX) for name in state):
            return None
        return cls(**{one.name: state[PREFIX + one.name] for one in fields(cls)})

    def arrays(self) -> dict[str, Array]:
        """Return the tests as arrays for the state of a search."""
        return {PREFIX + one.name: getattr(self, one.name) for one in fields(self)}

    def mismatch(self, genes: int) -> str:
        """Return why stored tests are inconsistent; '' if they are consistent."""
        count, features, kept = self.count, self.features.shape[-1], len(self.kept_scores)
        shapes: dict[str, tuple[int, ...]] = dict.fromkeys(
            ("generations", "simulated", "real", "predicted"), (count,)
        )
        shapes |= {"genomes": (count, genes), "features": (count, features)}
        shapes |= {"centre": (features,), "spread": (features,), "kept_scores": (kept,)}
        shapes["kept_values"] = (kept, self.kept_values.shape[-1])
        wrong = [name for name, shape in shapes.items() if getattr(self, name).shape != shape]
        return f"{PREFIX}{wrong[0]} has the shape {getattr(self, wrong[0]).shape}" if wrong else ""

    @property
    def disparity(self) -> Floats:
        """Absolute difference between the scores, (tests,); a failed score counts as 0."""
        simulated, real = (np.where(np.isfinite(s), s, 0.0) for s in (self.simulated, self.real))
        disparity: Floats = np.abs(simulated - real)
        return disparity

    def to_dicts(self) -> list[dict[str, float]]:
        """Return the generation, scores and disparities of each test, in order of time."""
        columns = (self.generations, self.simulated, self.real, self.disparity, self.predicted)
        names = ("generation", "in simulation", "in reality", "disparity", "predicted")
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return [dict(zip(names, row, strict=True)) for row in rows]

    def predict(self, features: Floats) -> Floats:
        """Return the expected disparity of individuals, (individuals,).

        Source: Rasmussen and Williams 2006, "Gaussian Processes for Machine Learning", eq. 2.25,
        around the mean of the tests, with the Matérn covariance ν = 5/2.

        Args:
            features: features of the individuals, (individuals, features).
        """
        count = self.count
        if not count:
            return np.zeros(len(features))
        points = np.concatenate([self._standard(self.features), self._standard(features)])
        disparity = self.disparity
        expected = posterior(
            np.full(len(points), disparity.mean()),
            points,
            np.arange(count),
            disparity,
            math.sqrt(points.shape[1]),
            NOISE,
        )
        return np.maximum(expected.mean[count:], 0.0)

    def rescaled(self, features: Floats) -> "RealityTests":
        """Return the tests, with `centre` and `spread` computed from their and these features."""
        known = np.concatenate([self.features.reshape(-1, features.shape[1]), features])
        known = np.where(np.isfinite(known), known, np.nan)
        # Not nanmean, which warns of a feature that is NaN for all individuals.
        number = np.maximum((~np.isnan(known)).sum(axis=0), 1)
        centre = np.nansum(known, axis=0) / number
        spread = np.sqrt(np.nansum(np.square(known - centre), axis=0) / number)
        return replace(self, centre=centre, spread=np.where(spread > 0, spread, 1.0))

    def choose(self, features: Floats, scores: Floats) -> int | None:
        """Return the index of the individual to test; None if a test would add no information.

        The first test chooses the best individual; later ones choose the individual whose features
        are farthest from those of all tests.

        Args:
            features: features of the individuals, (individuals, features).
            scores: scores of the individuals, (individuals,).
        """
        succeeded = np.isfinite(scores)
        if not succeeded.any():
            return None
        if not self.count:
            return int(scores.argmax())
        near = distances(self._standard(features), self._standard(self.features)).min(axis=1)
        distance = np.where(succeeded, near, 0.0)
        return int(distance.argmax()) if distance.max() > 0 else None

    def _standard(self, features: Floats) -> Floats:
        """Return standardised features; a non-finite value counts as the average, 0."""
        found = (np.where(np.isfinite(features), features, np.nan) - self.centre) / self.spread
        return np.where(np.isnan(found), 0.0, found)


class TransferabilitySearch(WrappedSearch):
    """A search whose individuals are tested in reality; it has the methods of `Search`.

    The state is that of the inner search, with the arrays of the tests.
    """

    prefix = PREFIX

    def initial(self, context: CheckedContext) -> State:
        """Return the state before the first generation."""
        return _joined(self._search.initial(context), RealityTests.none(context.space))

    def ask(
        self, state: State, last: Results | None, context: CheckedContext
    ) -> tuple[Genomes, State]:
        """Return the genomes of a generation, and the state for `tell`."""
        tests, before = self._split(state)
        if last is not None:
            last = with_predictions(self._experiment, tests, last)
        genomes, after = self._search.ask(before, last, context)
        return genomes, _joined(after, tests)

    def tell(self, state: State, results: Results, context: CheckedContext) -> State:
        """Return the state after a generation, and after a test in reality if one is due."""
        tests, before = self._split(state)
        rng = deepcopy(context.rng)
        seen = with_predictions(self._experiment, tests, results)
        after = check_state(self._experiment, self._search.tell(before, seen, context))
        pool = pool_results(tests, self._kept(before), results)
        tests, kept = with_kept_values(tests, pool, self._kept(after))
        if (context.generation - 1) % self._experiment.transferability.every == 0:
            more = run_reality_test(self._experiment, tests, kept, context.generation)
            if more is not None:
                again = with_predictions(self._experiment, more, kept)
                with plugin_errors(self._experiment.entries["search"], "receiving new scores"):
                    after = self._search.rescored(after, again, replace(context, rng=rng))
                after = check_state(self._experiment, after)
                tests, _ = with_kept_values(more, kept, self._kept(after))
        return _joined(after, tests)

    def remembered(self, state: State) -> Genomes | None:
        """Return the genomes that the inner search remembers, followed by those tested."""
        tests, before = self._split(state)
        kept = self._kept(before)
        return np.concatenate([kept, tests.genomes]) if len(kept) else None

    def rescored(self, state: State, results: Results, context: CheckedContext) -> State:
        """Return the state with new scores of the genomes in `remembered`.

        The tests in reality are costly, and are not repeated if only the worlds were redrawn.
        """
        tests, before = self._split(state)
        if not len(results.genomes):
            return _joined(self._search.rescored(before, results, context), tests)
        count = len(results.genomes) - tests.count
        kept, tested = _rows(results, slice(None, count)), _rows(results, slice(count, None))
        if tests.count:
            again = not context.redrawn
            tests = repeat_reality_tests(self._experiment, tests, tested, kept, in_reality=again)
        seen = with_predictions(self._experiment, tests, kept)
        after = check_state(self._experiment, self._search.rescored(before, seen, context))
        tests, _ = with_kept_values(tests, kept, self._kept(after))
        return _joined(after, tests)

    def mismatch(self, state: State, context: CheckedContext) -> str:
        """Return why a stored state does not fit; '' if it does."""
        tests = RealityTests.of(state)
        wrong = self._search.mismatch(self._inner(state), context)
        if wrong or tests is None:
            return wrong or "it lacks the tests in reality"
        return tests.mismatch(context.space.genes)

    def _split(self, state: State) -> tuple[RealityTests, State]:
        """Return the tests and the state of the inner search."""
        tests = RealityTests.of(state)
        if tests is None:
            raise ValueError("the state lacks the tests in reality")
        return tests, self._inner(state)

    def _kept(self, state: State) -> Genomes:
        """Return the genomes that the inner search remembers, (genomes, genes)."""
        with plugin_errors(self._experiment.entries["search"], "listing the genomes it remembers"):
            genomes = self._search.remembered(state)
        if genomes is None:
            return self._experiment.space().no_genomes
        return genomes


def _joined(state: State, tests: RealityTests) -> State:
    return {**state, **tests.arrays()}


def _rows(results: Results, rows: slice) -> Results:
    values = {name: column[rows] for name, column in results.values.items()}
    return Results(results.genomes[rows], results.scores[rows], values)


def features_of(experiment: Experiment, names: Sequence[str], values: Floats) -> Floats:
    """Return the columns of values, (individuals, values), that are features of the model."""
    features = experiment.transferability.features or [name for name in FEATURES if name in names]
    return values[:, [names.index(name) for name in features]]


def with_predictions(experiment: Experiment, tests: RealityTests, results: Results) -> Results:
    """Return the results with the transferability, which is the negative predicted disparity."""
    names, values = _columns(results.values)
    disparity = tests.predict(features_of(experiment, names, values))
    return replace(results, values={**results.values, TRANSFERABILITY: 0.0 - disparity})


def with_kept_values(
    tests: RealityTests, pool: Results, genomes: Genomes
) -> tuple[RealityTests, Results]:
    """Return the tests with the values of the individuals that the search keeps, and their results.

    Args:
        tests: tests with the values of the individuals that the search kept before.
        pool: results of those individuals, and of all individuals that it may have added.
        genomes: genomes that the search keeps now, (kept, genes).
    """
    names, values = _columns(pool.values)
    at = rows_of(genomes, pool.genomes)
    scores, found = pool.scores[at], values[at]
    kept = Results(genomes, scores, dict(zip(names, found.T, strict=True)))
    return replace(tests, kept_scores=scores, kept_values=found), kept


def pool_results(tests: RealityTests, before: Genomes, results: Results) -> Results:
    """Return the results of the individuals that the search has kept, and of new ones."""
    names, values = _columns(results.values)
    kept = tests.kept_values.reshape(-1, values.shape[1])
    return Results(
        np.concatenate([before, results.genomes]),
        np.concatenate([tests.kept_scores, results.scores]),
        dict(zip(names, np.concatenate([kept, values]).T, strict=True)),
    )


def rows_of(genomes: Genomes, pool: Genomes) -> NDArray[np.intp]:
    """Return the index of the first equal genome in a pool, (pool, genes), for each genome."""
    rows = np.ascontiguousarray(np.concatenate([pool, genomes]))
    keys = rows.view(np.dtype((np.void, rows.strides[0]))).reshape(-1)
    _, first, same = np.unique(keys, return_index=True, return_inverse=True)
    return np.asarray(first[same[len(pool) :]])


def run_reality_test(
    experiment: Experiment, tests: RealityTests, kept: Results, generation: int
) -> RealityTests | None:
    """Test a kept individual in reality; return None if a test would add no information."""
    names, values = _columns(kept.values)
    features = features_of(experiment, names, values)
    tests = tests.rescaled(features)
    chosen = tests.choose(features, kept.scores)
    if chosen is None:
        return None
    row = slice(chosen, chosen + 1)
    count = features.shape[1]
    return replace(
        tests,
        genomes=np.concatenate([tests.genomes, kept.genomes[row]]),
        generations=np.append(tests.generations, np.int64(generation)),
        features=np.concatenate([tests.features.reshape(-1, count), features[row]]),
        simulated=np.append(tests.simulated, kept.scores[row]),
        predicted=np.append(tests.predicted, tests.predict(features[row])),
        real=np.append(tests.real, _in_reality(experiment, kept.genomes[row])),
    )


def repeat_reality_tests(
    experiment: Experiment,
    tests: RealityTests,
    tested: Results,
    kept: Results,
    *,
    in_reality: bool,
) -> RealityTests:
    """Repeat the tests of the same individuals under a changed experiment or in other worlds."""
    names, values = _columns(tested.values)
    tests = replace(
        tests,
        features=features_of(experiment, names, values),
        simulated=tested.scores,
        real=_in_reality(experiment, tests.genomes) if in_reality else tests.real,
    )
    return tests.rescaled(features_of(experiment, *_columns(kept.values)))


def _in_reality(experiment: Experiment, genomes: Genomes) -> Floats:
    return evaluate(in_reality(experiment), genomes).scores


def _columns(values: Mapping[str, Floats]) -> tuple[list[str], Floats]:
    """Return the names of all values except the prediction, and an (individuals, values) array."""
    names = [name for name in values if name != TRANSFERABILITY]
    return names, np.stack([values[name] for name in names], axis=-1)

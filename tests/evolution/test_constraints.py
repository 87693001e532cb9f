"""Constraints: penalties that adapt, and champions that satisfy every constraint."""

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.contracts import Array
from gaitsim.evolution.constraints import Lagrangian

SPACE = gs.RealSpace(np.full(5, -5.0), np.full(5, 5.0))


@gs.scalar
def sphere(x: Array) -> dict[str, float]:
    """Return the negative squared distance from 0, and a sum that should be at least 2."""
    return {"score": -float((x**2).sum()), "short": 2 - float(x[0] + x[1])}


@gs.scalar
def g06(x: Array) -> dict[str, float]:
    """Return problem g06 of Michalewicz and Schoenauer 1996; its optimum is −6961.81388."""
    a, b = x.tolist()
    return {
        "score": -((a - 10) ** 3) - (b - 20) ** 3,
        "inner": -((a - 5) ** 2) - (b - 5) ** 2 + 100,
        "outer": (a - 6) ** 2 + (b - 5) ** 2 - 82.81,
    }


def run_to_end(search: gs.RunningSearch) -> gs.RunningSearch:
    for _ in search:
        pass
    return search


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("body", "space", "names", "best", "point", "error"),
    [
        (sphere, SPACE, ["short"], -2.0, [1, 1, 0, 0, 0], 1e-8),
        (
            g06,
            gs.RealSpace(np.array([13.0, 0.0]), np.full(2, 100.0)),
            ["inner", "outer"],
            6961.81388,
            [14.095, 0.84296],
            0.05,
        ),
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_the_champion_is_the_constrained_optimum(
    body: Any,
    space: Any,
    names: list[str],
    best: float,
    point: list[float],
    error: float,
    seed: int,
) -> None:
    search = run_to_end(
        gs.evolve(
            body=body,
            space=space,
            constraints=dict.fromkeys(names, 0.0),
            generations=300,
            seed=seed,
        )
    )
    assert search.champion is not None
    values = body(search.champion.genome)
    assert all(values[name] <= 0 for name in names)
    assert values["score"] == search.champion.score
    assert search.champion.score == pytest.approx(best, abs=error)
    assert search.champion.genome == pytest.approx(point, abs=1e-3)


def test_penalties_adapt_as_in_pycma() -> None:
    """The same costs and violations give the same coefficients, generation after generation."""
    handler = pytest.importorskip("cma").constraints_handler
    rng, genes, count = np.random.default_rng(4), 6, 3
    theirs, ours = handler.AugmentedLagrangian(genes), Lagrangian.initial(count)
    theirs.logging = 0
    centre = np.array([1.5, -0.5, 0.2])
    for generation in range(200):
        # The first constraint is violated at first; the second never is, and the last one may be.
        centre[0] *= 0.95
        costs = rng.normal(10, 2, 9)
        violations = centre + rng.normal(0, [0.3, 0.05, 0.6], (9, count))
        penalties = np.array([sum(theirs(g)) for g in violations])
        assert np.allclose(ours.penalties(violations), penalties, rtol=1e-9, atol=1e-12)
        best = int(np.argmin(costs + penalties))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if not theirs.is_initialized:
                theirs.set_coefficients(costs, violations)
            theirs.update(costs[best], violations[best])
        ours = ours.adapted(costs, violations, genes)
        assert np.allclose(ours.multipliers, theirs.lam, rtol=1e-9), generation
        assert np.allclose(ours.weights, theirs.mu, rtol=1e-9), generation
    assert ours.multipliers[0] > 0


def test_searches_that_keep_scores_respect_constraints_too() -> None:
    search = run_to_end(
        gs.evolve(
            body=sphere,
            space=SPACE,
            constraints={"short": 0.0},
            set={"search.plugin": "differential-evolution"},
            population=30,
            generations=100,
        )
    )
    assert search.champion is not None
    assert search.champion.score == pytest.approx(-2, abs=0.01)
    assert 0 < search.history["search:feasible share"][-1] < 1


def test_a_constrained_run_is_resumed_and_told_to_the_same_bits(tmp_path: Path) -> None:
    def search(out: Path | None = None, generations: int = 40) -> gs.RunningSearch:
        return gs.evolve(
            body=sphere, space=SPACE, constraints={"short": 0.0}, generations=generations, out=out
        )

    whole = run_to_end(search())
    run_to_end(search(tmp_path / "run", 15))
    resumed = run_to_end(gs.load(tmp_path / "run", body=sphere, space=SPACE).resume(40))
    optimiser = gs.Optimiser(SPACE, constraints={"short": 0.0}, generations=40)
    while not optimiser.stop:
        optimiser.tell(sphere(optimiser.ask()))
    for last in (resumed.last, optimiser.last):
        assert last is not None
        assert whole.last is not None
        assert np.array_equal(last.genomes, whole.last.genomes)
        assert np.array_equal(last.scores, whole.last.scores)
    infeasible = sphere(optimiser.last.genomes)["short"] > 0  # type: ignore[union-attr]
    assert np.array_equal(np.isfinite(optimiser.last.scores), ~infeasible)  # type: ignore[union-attr]


def test_measures_of_a_body_are_constrained_on_both_sides() -> None:
    search = gs.evolve(
        "spider",
        constraints={"slip ratio": 0.6},
        set={"constraints.at_least": {"body height": 0.097}},
        population=60,
        generations=2,
    )
    run_to_end(search)
    assert search.last is not None
    measures = search.experiment.organism.measures(
        search.experiment.organism.move(search.last.genomes.copy())
    )
    feasible = (measures["slip ratio"].values <= 0.6) & (measures["body height"].values >= 0.097)
    assert 0 < feasible.sum() < len(feasible)
    assert np.array_equal(np.isfinite(search.last.scores), feasible)


@gs.scalar
def undefined(x: Array) -> dict[str, float]:
    return {"score": float(x[0]), "short": np.nan if x[0] < 0 else -1.0}


def test_an_individual_whose_constraint_is_nan_fails() -> None:
    search = run_to_end(
        gs.evolve(body=undefined, space=SPACE, constraints={"short": 0.0}, generations=3)
    )
    assert search.last is not None
    assert np.array_equal(np.isfinite(search.last.scores), search.last.genomes[:, 0] >= 0)


@pytest.mark.parametrize(
    ("start", "told"),
    [
        (lambda: gs.evolve(body=sphere, space=SPACE, constraints={"long": 0.0}), "measure 'long'"),
        (
            lambda: gs.evolve("spider", constraints={"yaw": 0.0}, set={"islands.number": 2}),
            "cannot be combined with islands",
        ),
        (
            lambda: gs.evolve(
                body=sphere,
                space=SPACE,
                constraints={"short": 0.0},
                set={"constraints.at_least": {"short": 1.0}},
            ),
            "cannot be at least 1 and at most 0",
        ),
    ],
)
def test_wrong_constraints_are_explained(start: Callable[[], gs.RunningSearch], told: str) -> None:
    with pytest.raises(gs.GaitsimError, match=told):
        run_to_end(start())


def test_a_search_without_a_feasible_individual_says_so() -> None:
    search = gs.evolve(body=sphere, space=SPACE, constraints={"short": -99.0}, generations=2)
    with pytest.warns(UserWarning, match="no individual satisfied all constraints"):
        run_to_end(search)
    assert search.champion is None
    assert search.last is not None
    assert "must be at most -99" in search.last.evaluation.reasons[0]

"""Every installed search gives the same bits when resumed, repeated, verified and killed."""

import os
import random
import signal
import time
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.scoring import evaluate
from gaitsim.evolution import evolve
from gaitsim.registry import entries
from gaitsim.storage.creation import create_run, fork_run
from gaitsim.storage.files.checkpoint import write_checkpoint
from gaitsim.storage.files.folder import CHECKPOINT
from gaitsim.storage.overview import list_overviews
from gaitsim.storage.resume import plan_resume
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import verify_run
from gaitsim.storage.writer import RunWriter

NEEDED = {
    "nsga-2": ["search.objectives.reach=max", "search.objectives.price=max"],
    "designs": ["search.dimensions=['c']", "search.sample=4", "search.original=3"],
    "map-elites": ["search.axes.reach=[-2, 3]", "search.cells=[8]"],
    "novelty": ["search.axes.reach=[-2, 3]"],
}
"""Options without a default."""

TESTED = "nsga-2 with tests in reality"
REALITY = [
    "search.plugin=nsga-2",
    "search.objectives.score=max",
    "search.objectives.transferability=max",
    "transferability.reality.load=0.5",
    "transferability.every=2",
    "transferability.features=['reach', 'price']",
]
VORONOI = "map-elites over Voronoi cells"
AXES = [f"search.axes.{name}=[-2, 3]" for name in ("reach", "price", "score", "term:reach")]
ALL = [name for name in entries("search") if name != "puppet"]


@pytest.fixture(params=[*ALL, VORONOI, TESTED])
def searching(request, puppet):
    """A function that creates an experiment of puppets, for each installed search."""
    name = request.param
    chosen = [] if name == "genetic" else [f"search.plugin={name}", *NEEDED.get(name, [])]
    if name == VORONOI:
        chosen = ["search.plugin=map-elites", *AXES, "search.cells=20"]
    if name == TESTED:
        chosen = REALITY
    return lambda *more: puppet("evolution.population=12", *chosen, *more)


WINDY = (
    "organism.plugin=windy-puppet",
    "worlds.cases=[{wind=0.3}, {}]",
    "worlds.number=2",
    "worlds.redraw=3",
)
"""Two cases, and worlds that are redrawn."""


def evolved(experiment, path, generations=None):
    path = path if path.exists() else create_run(experiment, path)
    with RunWriter.open(path, generations=generations) as writer:
        for _ in writer.evolve(partial(evaluate, writer.experiment)):
            pass
    return path


def test_a_run_in_steps_is_identical_to_a_run_in_one_go(searching, tmp_path):
    experiment = searching("evolution.generations=9", *WINDY)
    whole = RunSnapshot(evolved(experiment, tmp_path / "whole"))
    steps = tmp_path / "steps"
    evolved(searching("evolution.generations=1", *WINDY), steps)
    for generations in (2, 3, 5, 9):
        evolved(experiment, steps, generations)
    assert RunSnapshot(steps).fingerprint() == whole.fingerprint()
    assert verify_run(whole, everything=True).identical
    assert verify_run(whole, everything=False).identical
    # Generations 7 to 9 have the same worlds, as has all that the search remembers.
    assert whole.first_comparable == 7
    kept = experiment.search.remembered(whole.finished.state)
    if kept is not None and experiment.search.keeps:
        scores = evaluate(experiment, whole.members.genomes, 9).scores
        np.testing.assert_array_equal(whole.members.scores, scores)
        assert whole.finished.evaluations > 9 * 12


def test_workers_and_forks_make_no_difference(searching, tmp_path):
    experiment = searching("evolution.generations=4", *WINDY)
    here = RunSnapshot(evolved(experiment, tmp_path / "here"))
    with Evaluator(experiment, workers=2) as evaluator:
        *_, last = evolve(experiment, evaluator.evaluate)
    assert np.array_equal(last.genomes, here.finished.genomes)
    assert all(
        np.array_equal(last.state[n], a, equal_nan=True) for n, a in here.finished.state.items()
    )
    copy = fork_run(here.path, tmp_path / "copy")
    for path in (copy, here.path):
        evolved(experiment, path, 7)
    assert RunSnapshot(copy).fingerprint() == RunSnapshot(here.path).fingerprint()


def test_a_changed_state_is_found_and_a_damaged_one_rejected(searching, tmp_path):
    path = evolved(searching("evolution.generations=3"), tmp_path / "run")
    checkpoint = RunSnapshot(path).finished
    for name, values in checkpoint.state.items():
        other = values.copy()
        if not other.size:
            continue
        other.flat[0] = 1 if other.flat[0] == 0 else 0
        write_checkpoint(
            path / CHECKPOINT, replace(checkpoint, state={**checkpoint.state, name: other})
        )
        with suppress(GaitsimError):  # such a state may be rejected, too
            assert not verify_run(RunSnapshot(path), everything=True).identical, name
    if checkpoint.state:
        write_checkpoint(path / CHECKPOINT, replace(checkpoint, state={}))
        with pytest.raises(RunError, match="cannot continue from the state"):
            plan_resume(RunSnapshot(path), generations=5, any_version=False)


def test_the_search_of_a_run_cannot_change(searching, tmp_path):
    path = evolved(searching("evolution.generations=2"), tmp_path / "run")
    name = RunSnapshot(path).experiment.entries["search"].name
    other = "cma-es" if name == "genetic" else "genetic"
    operators = {
        f"{kind}.plugin": f"puppet-{what}"
        for kind, what in (("selection", "best"), ("crossover", "mean"), ("mutation", "jitter"))
    }
    more = operators if other == "genetic" else {}
    with pytest.raises(GaitsimError, match="search of a run cannot change"):
        plan_resume(
            RunSnapshot(path), {"search.plugin": other, **more}, generations=5, any_version=False
        )


@pytest.mark.slow
def test_twenty_kills_change_no_bit(searching, tmp_path, monkeypatch):
    monkeypatch.setattr("gaitsim.storage.writer.PERIOD", 0.01)  # s; kills come within 0.06 s
    experiment = searching("evolution.generations=120", *WINDY)
    whole = RunSnapshot(evolved(experiment, tmp_path / "whole")).fingerprint()
    moments, kills = random.Random(1), 0
    while kills < 20:  # a quick run may end before
        path = create_run(experiment, tmp_path / f"killed from {kills}")
        status = None
        while status != 0:
            child = os.fork()
            if not child:
                evolved(experiment, path)
                os._exit(0)
            if kills < 20:
                time.sleep(moments.uniform(0, 0.06))
                os.kill(child, signal.SIGKILL)
                kills += 1
            status = os.waitpid(child, 0)[1]
        assert RunSnapshot(path).fingerprint() == whole


def test_convergence_ends_a_run_and_other_options_continue_it(puppet, tmp_path):
    chosen = ("evolution.population=12", "search.plugin=cma-es", "search.score_tolerance=1e9")
    path = evolved(
        puppet(*chosen, "search.restarts=stop", "evolution.generations=40"), tmp_path / "run"
    )
    run = RunSnapshot(path)
    assert 10 < run.generation < 40
    assert "'cma-es' has converged: the range" in run.stop_reason
    assert [one.state for one in list_overviews(tmp_path, lambda path: None)] == ["finished"]
    assert verify_run(run, everything=True).identical
    assert RunSnapshot(evolved(None, path, 50)).generation == run.generation

    with RunWriter.open(path, overrides={"search.restarts": "ipop"}) as writer:
        last = [*writer.evolve(partial(evaluate, writer.experiment))][-1]
    assert last.number == 50
    assert last.figures["restarts"] >= 1
    assert RunSnapshot(path).stop_reason == "50 generations are done"
    assert verify_run(RunSnapshot(path), everything=True).identical

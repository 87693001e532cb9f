"""Runs with islands: their records, resuming, forks and verification."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from gaitsim.errors import ExperimentError, RunError
from gaitsim.evaluation import evaluate
from gaitsim.experiment import parse_assignments
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.checkpoint import pack, read_checkpoint
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import stages_of
from gaitsim.storage.verification import verify_run
from gaitsim.storage.writer import RunWriter

ISLANDS = (
    "islands.number=3",
    "islands.every=3",
    "islands.migrants=1",
    "evolution.generations=8",
    "evolution.fitness_threshold=0",
)


def evolve(path, *overrides, generations=None, until=None, parallel=False):
    with RunWriter.open(
        path, overrides=parse_assignments(overrides), generations=generations
    ) as writer:
        experiment = writer.experiment

        def over(function, tasks):
            return [function(experiment, task) for task in tasks]

        for generation in writer.evolve(partial(evaluate, experiment), over if parallel else None):
            if generation.number == until:
                break
    return RunSnapshot(path)


@pytest.fixture
def new(puppet, tmp_path):
    """Makes the folder of a run with islands."""
    return lambda *overrides: create_run(puppet(*ISLANDS, *overrides), tmp_path / "run")


@pytest.fixture
def run(new):
    """A run with islands, evolved to its end."""
    return evolve(new())


def test_the_best_score_of_each_island_is_recorded(run):
    checkpoint = run.checkpoint
    assert checkpoint.genomes.shape == (18, 3)
    assert run.islands.shape == (8, 3)
    assert np.array_equal(run.islands[-1], checkpoint.scores.reshape(3, 6).max(axis=1))
    assert np.array_equal(run.islands.max(axis=1), run.history["best"])
    assert run.history["evaluations"].tolist() == [18 * number for number in range(1, 9)]
    text = (run.path / "islands.csv").read_text().splitlines()
    assert text[0] == "generation,island 1,island 2,island 3"
    assert text[8].startswith("8,")
    for generation in (1, 8):
        found = run.individual(generation)
        assert evaluate(found.experiment, found.genome[None]).scores[0] == found.score
    assert [*(run.path / "champions").iterdir()]


@pytest.mark.parametrize("until", range(1, 8))
@pytest.mark.parametrize("parallel", [False, True])
def test_a_run_stopped_anywhere_resumes_identically(run, new, until, parallel):
    stopped = evolve(new(), until=until, parallel=parallel)
    assert stopped.generation == until
    again = evolve(stopped.path, parallel=not parallel)
    assert again.fingerprint() == run.fingerprint()
    assert (again.path / "islands.csv").read_text() == (run.path / "islands.csv").read_text()


def test_a_run_killed_while_writing_resumes_identically(run, new):
    stopped = evolve(new(), until=5)
    path = stopped.path / "islands.csv"
    path.write_bytes(path.read_bytes() + b"6,0.5,0.25,0.125\n7,0.")
    assert len(stopped.islands) == 5
    assert evolve(stopped.path).fingerprint() == run.fingerprint()
    assert path.read_text() == (run.path / "islands.csv").read_text()


def test_lost_islands_are_reported(run):
    path = run.path / "islands.csv"
    whole = path.read_text()
    path.write_text("".join(whole.splitlines(keepends=True)[:4]))
    for use in (lambda: run.islands, lambda: evolve(run.path, generations=9)):
        with pytest.raises(RunError, match=r"islands\.csv ends at generation 3"):
            use()
    for text in (whole.replace("island 3", "island 4"), whole.replace("\n5,", "\n6,"), "\n\n"):
        path.write_text(text)
        with pytest.raises(RunError, match=r"islands\.csv"):
            _ = run.islands


def test_islands_are_verified(run):
    verdict = verify_run(RunSnapshot(run.path), everything=True, workers=1)
    assert verdict.identical, verdict.differences
    sampled = verify_run(RunSnapshot(run.path), everything=False, workers=1)
    assert sampled.identical, sampled.differences
    assert not sampled.again
    path = run.path / "islands.csv"
    lines = path.read_text().splitlines()
    cells = lines[4].split(",")
    worse = 1 + int(np.argmin(run.islands[3]))
    cells[worse] = repr(float(cells[worse]) - 1e-9)
    lines[4] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    found = verify_run(RunSnapshot(run.path), everything=False, workers=1).differences
    assert {one.generation for one in found} == {4}
    found = verify_run(RunSnapshot(run.path), everything=True, workers=1).differences
    text = f"generation 4: islands.csv: the best score of island {worse} differs"
    assert text in map(str, found)


def test_stages_may_change_all_but_the_number(run):
    overrides = {"islands.migrants": 2, "islands.topology": "all", "fitness.price": 0.3}
    with RunWriter.open(run.path, overrides=overrides, generations=12) as writer:
        assert [change.key for change in writer.changes] == [
            "fitness.price",
            "islands.migrants",
            "islands.topology",
        ]
    changed = evolve(run.path)
    assert [stage.first for stage in stages_of(changed.checkpoint)] == [1, 9]
    assert verify_run(changed, everything=True, workers=1).identical
    with pytest.raises(ExperimentError) as refused:
        evolve(run.path, "islands.number=2")
    (problem,) = refused.value.problems
    assert problem.what == "the number of islands of a run cannot change"
    assert "islands.number" in problem.where
    with pytest.raises(ExperimentError, match="a problem") as refused:
        evolve(run.path, "evolution.population=9")
    assert refused.value.problems[0].allowed == "6"


def test_an_older_checkpoint_has_one_island(puppet, tmp_path):
    """A checkpoint of a version of gaitsim without islands."""
    plain = evolve(create_run(puppet(), tmp_path / "plain"))
    before = plain.fingerprint()
    path = plain.path / "population.pickle"
    checkpoint = read_checkpoint(path)
    text = checkpoint.experiment
    start, end = text.index("[islands]"), text.index("[organism]")
    older = text[:start] + text[end:]
    path.write_bytes(pack(replace(checkpoint, experiment=older)))
    (plain.path / "experiment.toml").write_text(older)
    run = RunSnapshot(plain.path)
    assert run.fingerprint() == before
    assert run.pending == ()
    assert len(stages_of(evolve(plain.path, generations=7).checkpoint)) == 1
    assert verify_run(RunSnapshot(plain.path), everything=True, workers=1).identical

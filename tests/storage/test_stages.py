"""Stages: runs whose experiment changes."""

import os
import shutil
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from run_helpers import THRESHOLD, Killed, continue_run, kill_at

from breeding import breed
from gaitsim.errors import ExperimentError, RunError
from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import with_overrides
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.checkpoint import read_checkpoint, write_checkpoint
from gaitsim.storage.files.history import COLUMNS, best_terms
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import Change
from gaitsim.storage.writer import RunWriter

CLIMB = {"fitness.plugin": "puppet-climb", "mutation.plugin": "puppet-jitter"}


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, climb):
    monkeypatch.chdir(tmp_path)


def begin(puppet, *overrides, generations=4, out="run"):
    """A run of four generations, or of a given number."""
    path = create_run(puppet(f"evolution.generations={generations}", *overrides), Path(out))
    continue_run(path)
    return path


@pytest.fixture
def plain(puppet, once):
    """A run of four generations."""
    return once("plain", Path("plain"), lambda: begin(puppet, THRESHOLD, out="plain"))


@pytest.fixture
def staged(puppet, once):
    """The same run, followed by a stage of four generations with another fitness."""

    def create():
        path = begin(puppet, THRESHOLD, out="staged")
        assert continue_run(path, overrides=CLIMB, generations=8) == ""

    return RunSnapshot(once("staged", Path("staged"), create))


def edit(path, *replacements):
    """Change the experiment by hand."""
    text = (path / "experiment.toml").read_text()
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new, 1)
    (path / "experiment.toml").write_text(text)


def content(path):
    """The content of a run's files, without locks."""
    return {
        item.relative_to(path): item.read_bytes()
        for item in sorted(path.rglob("*"))
        if item.is_file() and not item.name.startswith(".lock")
    }


def assert_same(one, other):
    """Assert that two runs are equal except for the times in their histories."""
    one, other = RunSnapshot(one.path), RunSnapshot(other.path)
    assert one.fingerprint() == other.fingerprint()
    held = [content(run.path) for run in (one, other)]
    assert held[0].keys() == held[1].keys()
    for name in held[0]:
        # The previous experiment depends on the number of generations planned in between, and the
        # saves on the times at which a process stopped.
        if name.name not in ("history.csv", "population.previous.pickle", "saves.bin"):
            assert held[0][name] == held[1][name], name
    columns = [run.history for run in (one, other)]
    assert list(columns[0]) == list(columns[1])


# What a stage is


def test_a_stage_breeds_from_the_re_evaluated_population(puppet, staged):
    first = puppet(THRESHOLD)
    second = with_overrides(first, CLIMB)
    generations = list(evolve(puppet(), partial(evaluate, first)))
    genomes = generations[3].genomes
    for number in range(5, 9):
        scores = evaluate(second, genomes).scores
        genomes = breed(second, second.space(), genomes, scores, number)
    checkpoint = staged.checkpoint
    assert checkpoint.genomes.tobytes() == genomes.tobytes()
    assert checkpoint.scores.tobytes() == evaluate(second, genomes).scores.tobytes()
    # The population of generation 4 was evaluated twice.
    assert checkpoint.evaluations == 9 * 6
    assert staged.history["evaluations"].tolist() == [6, 12, 18, 24, 36, 42, 48, 54]
    assert checkpoint.best_score == staged.history["best"][4:].max()
    assert list(checkpoint.terms) == ["height", "reach"]


def test_the_stages_of_a_run_are_listed(puppet, staged):
    one, two = staged.stages
    assert (one.number, one.first, one.last, one.changes) == (1, 1, 4, ())
    assert (two.number, two.first, two.last) == (2, 5, 8)
    assert [str(change) for change in two.changes] == [
        "fitness.plugin: puppet-reach, now puppet-climb"
    ]
    assert "fitness puppet-climb" in two.versions
    assert "fitness puppet-reach" in one.versions
    for generation, stage in [(1, one), (4, one), (5, two), (8, two)]:
        assert staged.stage_at(generation) == stage
        assert staged.experiment_at(generation).to_toml() == stage.experiment
    assert staged.experiment_at(2) is staged.experiment_at(3)  # read once
    assert staged.experiment_at(4).fitness == puppet().fitness
    assert staged.experiment_at(5) is staged.experiment
    for generation in (0, 9):
        with pytest.raises(RunError, match=f"has no generation {generation}"):
            staged.experiment_at(generation)
    assert staged.pending == ()


def test_terms_of_a_stage_have_their_own_columns(puppet, staged):
    history = staged.history
    terms = ["reach", "price", "height"]
    assert list(history) == [*COLUMNS, *terms, *(f"mean:{name}" for name in terms)]
    assert history["stage"].tolist() == [1, 1, 1, 1, 2, 2, 2, 2]
    for name in ("price", "mean:price"):
        assert np.isfinite(history[name]).tolist() == [True] * 4 + [False] * 4
    for name in ("height", "mean:height"):
        assert np.isfinite(history[name]).tolist() == [False] * 4 + [True] * 4
    assert np.isfinite(history["reach"]).all()
    for generation in range(1, 9):
        best = staged.individual(generation)
        score, genome = best.score, best.genome
        evaluation = evaluate(staged.experiment_at(generation), genome[None])
        assert score == evaluation.scores[0]
        assert best_terms(history, generation) == {n: v[0] for n, v in evaluation.terms.items()}
    text = (staged.path / "history.csv").read_text()
    assert text.splitlines()[1].startswith("1,1,6,")
    assert ",nan" in text


def test_the_champion_is_of_generations_that_can_be_compared(puppet, staged):
    history = staged.history
    assert history["best"][:4].max() > history["best"][4:].max()
    assert staged.first_comparable == 5
    best = staged.individual()
    number, score = best.generation, best.score
    assert number >= 5
    assert score == history["best"][4:].max()
    assert staged.individual(2).experiment.fitness == puppet().fitness
    assert staged.individual().experiment is staged.experiment


def test_other_rates_alone_keep_scores_and_progress(puppet):
    options = ("evolution.stagnation=50", THRESHOLD)
    path = begin(puppet, *options, generations=10)
    before = RunSnapshot(path).checkpoint
    rates = {"search.elites": 1, "crossover.children": 1}
    continue_run(path, overrides=rates, generations=11)
    run = RunSnapshot(path)
    after = run.checkpoint
    assert after.evaluations == 66
    assert after.best_score >= before.best_score
    assert after.best_score == run.history["best"].max()
    assert after.threshold >= before.threshold
    assert after.stagnation in (0, before.stagnation + 1)
    assert run.history["stage"].tolist() == [1] * 10 + [2]
    assert run.first_comparable == 1
    assert [str(change) for change in run.stages[1].changes] == [
        "crossover.children: 2, now 1",
        "search.elites: 2, now 1",
    ]


def test_the_length_of_a_run_does_not_start_a_stage(puppet, plain):
    options = {"evolution.generations": 8, "evolution.target_score": 90, "evolution.stagnation": 9}
    assert continue_run(plain, overrides=options) == ""
    run = RunSnapshot(plain)
    assert (run.generation, len(run.stages)) == (8, 1)
    assert run.experiment.evolution.target_score == 90
    whole = begin(puppet, THRESHOLD, generations=8, out="whole")
    assert run.fingerprint() == RunSnapshot(whole).fingerprint()


def test_a_changed_option_of_the_body_re_evaluates_the_population(plain):
    continue_run(plain, overrides={"organism.pause": 0.0001}, generations=5)
    run = RunSnapshot(plain)
    assert run.first_comparable == 5
    assert run.history["evaluations"][-1] == 36


# Stages are identical however they start and whatever happens


def test_an_experiment_edited_by_hand_starts_the_same_stage(plain, staged):
    edit(
        plain,
        ('plugin = "puppet-reach"', 'plugin = "puppet-climb"'),
        ("price = 0.1", "weight = 0.5"),
        ("generations = 4", "generations = 8"),
    )
    assert [str(change) for change in RunSnapshot(plain).pending] == [
        "fitness.plugin: puppet-reach, now puppet-climb"
    ]
    assert (
        "was changed after generation 4 (fitness.plugin: puppet-reach, now puppet-climb)"
        in continue_run(plain)
    )
    assert RunSnapshot(plain).fingerprint() == staged.fingerprint()


def killed_in(monkeypatch, owner, step, number, doing):
    """Call a function, killed at the n-th call of a step; return whether that call was reached."""
    with monkeypatch.context() as patch:
        kill_at(patch, owner, step, number)
        try:
            doing()
        except Killed:
            return True
    return False


STEPS = [(os, "write"), (os, "fsync"), (Path, "replace"), (os, "open")]


@pytest.mark.sampled
@pytest.mark.parametrize(("owner", "step"), STEPS)
def test_a_stage_killed_at_any_step_of_its_start_is_identical(
    plain, staged, monkeypatch, owner, step
):
    before = RunSnapshot(plain).fingerprint()
    for number in range(40):
        path = Path(f"killed-{number}")
        shutil.copytree(plain, path)
        came = killed_in(
            monkeypatch,
            owner,
            step,
            number,
            lambda path=path: continue_run(path, 5, overrides=CLIMB, generations=8),
        )
        run = RunSnapshot(path)
        # Until the first generation of the stage is written, the run is unchanged.
        if run.generation == 4:
            assert run.fingerprint() == before
            assert len(run.stages) == 1
            assert run.individual().generation == RunSnapshot(plain).individual().generation
        # A change that was not written yet is requested again.
        pending = run.generation > 4 or run.pending
        continue_run(path, **({} if pending else {"overrides": CLIMB, "generations": 8}))
        assert_same(run, staged)
        if not came:
            break
    assert not came
    assert number >= 2


def test_an_abandoned_stage_leaves_nothing(plain, puppet, monkeypatch):
    # Killed when the history has its columns, but no generation its row.
    assert killed_in(
        monkeypatch, os, "write", 0, lambda: continue_run(plain, overrides=CLIMB, generations=8)
    )
    assert "height" in (plain / "history.csv").read_text()
    run = RunSnapshot(plain)
    assert "height" not in run.history
    assert run.pending
    continue_run(plain, overrides={"fitness.plugin": "puppet-reach"})
    run = RunSnapshot(plain)
    whole = RunSnapshot(begin(puppet, THRESHOLD, generations=8, out="whole"))
    assert run.fingerprint() == whole.fingerprint()
    assert run.bests.tobytes() == whole.bests.tobytes()
    assert "height" not in (plain / "history.csv").read_text()


# Errors


REFUSED = {
    "another population": (
        {"evolution.population": 8},
        ["population size of a run cannot change", "allowed: 6"],
    ),
    "other labels": ({"organism.names": "abd"}, ["gene 3 is 'c', not 'd'"]),
    "narrower bounds": ({"organism.most": -0.9}, ["is out of bounds", "allowed -1 to -0.9"]),
    "with options that no run could have": (
        {"evolution.population": 8, "mutation.rat": 3, "fitness.price": -1},
        ["3 problems", "population size of a run cannot change", "mutation.rat", "fitness.price"],
    ),
}


@pytest.mark.parametrize(("overrides", "says"), REFUSED.values(), ids=REFUSED.keys())
def test_changes_that_do_not_fit_the_population_are_errors_and_change_nothing(
    puppet, overrides, says
):
    path = begin(puppet, "organism.plugin=shaped")
    before = content(path)
    with pytest.raises(ExperimentError) as error:
        RunWriter.open(path, overrides=overrides, generations=8)
    for text in says:
        assert text in str(error.value)
    assert content(path) == before
    continue_run(path, generations=5)


def test_a_stage_without_a_generation_is_an_error(plain):
    before = content(plain)
    for options in ({}, {"generations": 4}):
        with pytest.raises(RunError, match="no generation would be evolved") as error:
            RunWriter.open(plain, overrides=CLIMB, **options)
        assert "4 generations are done" in error.value.what
        assert "evolution.generations=" in error.value.remedy
    with pytest.raises(RunError, match="another generation would exceed 35 evaluations"):
        # Re-evaluating the population takes six of them.
        RunWriter.open(plain, overrides=CLIMB | {"evolution.max_evaluations": 35}, generations=8)
    assert content(plain) == before
    # A target that the former scores have reached does not stop the new ones.
    continue_run(plain, overrides=CLIMB | {"evolution.target_score": -50}, generations=8)
    assert RunSnapshot(plain).generation == 5


def test_changes_before_the_first_generation_do_not_start_a_stage(puppet):
    path = create_run(puppet())
    continue_run(path, overrides={"evolution.population": 8, "seed": 3})
    run = RunSnapshot(path)
    assert len(run.checkpoint.genomes) == 8
    assert len(run.stages) == 1
    other = begin(puppet, "evolution.population=8", "seed=3", generations=5, out="other")
    assert run.fingerprint() == RunSnapshot(other).fingerprint()


# Versions


def test_plugins_of_former_stages_may_be_missing(staged, monkeypatch, climb):
    continue_run(staged.path, overrides={"fitness.plugin": "puppet-reach"}, generations=9)
    path = staged.path / "population.pickle"
    checkpoint = read_checkpoint(path)
    assert checkpoint.stages[1].versions["fitness puppet-climb"] == "climb 1.0"
    checkpoint.stages[1].versions["fitness puppet-climb"] = "climb 0.1"
    checkpoint.stages[0].versions["fitness puppet-reach"] = "gaitsim-puppets 0.1"
    write_checkpoint(path, checkpoint)
    monkeypatch.syspath_prepend(str(climb))  # so that undoing it leaves the path as it was
    shutil.rmtree(climb)
    assert continue_run(staged.path, generations=10) == ""
    run = RunSnapshot(staged.path)
    assert run.individual().generation >= 9
    assert run.experiment_at(4).fitness == run.experiment.fitness
    assert run.stages[1].versions["fitness puppet-climb"] == "climb 0.1"
    assert str(run.stages[1].changes[0]).startswith(
        "fitness.plugin: puppet-reach, now puppet-climb"
    )
    with pytest.raises(ExperimentError, match="unknown fitness plugin 'puppet-climb'") as error:
        run.experiment_at(5)
    assert "the experiment of stage 2" in str(error.value)
    assert "pip install climb==0.1" in str(error.value)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ({"slope": (-3.0, 3.0)}, "{slope = [-3.0, 3.0]}"),
    ],
)
def test_a_changed_table_is_shown_as_toml(value, text):
    assert str(Change("worlds.x", {}, value)) == f"worlds.x: {{}}, now {text}"

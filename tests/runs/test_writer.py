"""A run is written generation by generation, whatever happens in the meantime."""

import errno
import math
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from run_helpers import (
    LONG,
    THRESHOLD,
    Killed,
    assert_same,
    continue_run,
    events,
    kill_at,
    names,
    record_all,
    reopen,
)

from gaitsim.errors import PluginError, RunError
from gaitsim.evaluation import evaluate
from gaitsim.runs.compatibility import versions
from gaitsim.runs.files.checkpoint import read_champion, read_checkpoint
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.files.history import best_terms
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.writer import RunWriter

pytestmark = pytest.mark.usefixtures("here")


def test_a_run_is_written_and_read(whole, puppet):
    assert names(whole.path) - {".lock", ".lock-owner"} == {
        "experiment.toml",
        "history.csv",
        "bests.bin",
        "checksums.bin",
        "provenance.json",
        "population.pickle",
        "population.previous.pickle",
        "champions",
        "exports",
    }
    checkpoint, warning = whole.checkpoint, whole.warning
    assert not warning
    assert (checkpoint.generation, checkpoint.evaluations) == (8, 48)
    assert checkpoint.experiment == puppet(LONG, THRESHOLD).to_toml()
    assert checkpoint.versions == versions(puppet())
    assert checkpoint.versions["organism puppet"] == "gaitsim-puppets 1.0"
    history, bests = whole.history, whole.bests
    assert history["generation"].tolist() == list(range(1, 9))
    assert np.array_equal(bests["score"], history["best"])
    for generation in (1, 5, 8):
        best = whole.individual(generation)
        number, score, genome = best.generation, best.score, best.genome
        evaluation = evaluate(puppet(), genome[None])
        assert (number, score) == (generation, evaluation.scores[0])
        assert best_terms(whole.history, generation) == {
            n: v[0] for n, v in evaluation.terms.items()
        }
        assert genome.flags.writeable
    assert whole.individual().generation == int(np.argmax(bests["score"])) + 1


def test_a_best_that_differs_from_the_history_is_an_error(whole):
    path = whole.path / "bests.bin"
    path.write_bytes(np.random.default_rng(0).bytes(path.stat().st_size))
    with pytest.raises(RunError, match=r"in bests\.bin, but .* in history\.csv"):
        RunSnapshot(whole.path).individual()


def test_champions_are_saved_each_time_the_best_beats_the_threshold(whole):
    files = sorted((whole.path / "champions").iterdir())
    threshold, expected = 0.0, []
    for number, best in enumerate(whole.history["best"], start=1):
        if best > threshold:
            expected.append(f"generation-{number:06d}.pickle")
            threshold += 0.1 * math.ceil((best - threshold) / 0.1)
    assert [file.name for file in files] == expected
    assert 1 < len(files) < 8
    for file in files:
        champion = read_champion(file)
        best = whole.individual(champion.generation)
        score, genome = best.score, best.genome
        assert champion.score == score
        assert champion.genome.tobytes() == genome.tobytes()
        assert champion.terms == best_terms(whole.history, champion.generation)


def test_a_run_grows_while_it_is_read(half, whole):
    assert (half.generation, len(half.history["best"]), len(half.bests)) == (4, 4, 4)
    continue_run(half.path)
    assert (half.generation, len(half.history["best"]), len(half.bests)) == (4, 4, 4)
    grown = reopen(half)
    assert (grown.generation, len(grown.history["best"]), len(grown.bests)) == (8, 8, 8)


def test_before_the_first_generation_there_is_no_individual(puppet):
    run = RunSnapshot(create_run(puppet()))
    assert run.checkpoint is None
    assert (run.generation, run.history, len(run.bests)) == (0, {}, 0)
    for ask in (run.individual, run.fingerprint, lambda: run.individual(1)):
        with pytest.raises(RunError, match="has no finished generation yet") as error:
            ask()
        assert "gaitsim resume runs/puppet" in error.value.remedy


def test_a_generation_that_is_not_there_is_refused(half):
    for number in (0, -1, 5):
        with pytest.raises(RunError, match=f"has no generation {number}") as error:
            half.individual(number)
        assert error.value.allowed == "1 to 4"


# The steps that write a generation, in order.
STEPS = [
    (os, "write", 0),
    (os, "write", 1),
    (os, "fsync", 0),
    (os, "fsync", 1),
    (os, "fsync", 2),
    (Path, "replace", 0),
    (Path, "replace", 1),
    (os, "fsync", 3),
]


@pytest.mark.parametrize(("owner", "step", "number"), STEPS)
@pytest.mark.parametrize("begun", [0, 3])
def test_a_run_killed_at_any_step_resumes_identically(
    whole, puppet, monkeypatch, begun, owner, step, number
):
    path = create_run(puppet(LONG, "evolution.fitness_threshold=0"))
    if begun:
        continue_run(path, begun)
    before = begun and RunSnapshot(path).fingerprint()
    with RunWriter.open(path) as writer, monkeypatch.context() as patch:
        event = next(events(writer))
        kill_at(patch, owner, step, number)
        with pytest.raises(Killed):
            writer.record(event)
    # Until the new checkpoint is written, the run is unchanged.
    run = RunSnapshot(path)
    if run.generation == begun:
        assert len(run.history.get("best", [])) == begun
        assert len(run.bests) == begun
        assert (begun and run.fingerprint()) == before
    continue_run(path)
    assert_same(run, whole)
    assert not [name for name in names(path) if name.endswith(".partial")]


@pytest.mark.parametrize("step", ["write", "fsync"])
@pytest.mark.parametrize("number", range(4))
def test_a_full_disk_stops_the_run_as_it_was(half, whole, monkeypatch, step, number):
    fingerprint = half.fingerprint()
    calls, real = iter(range(100)), getattr(os, step)

    def full(*arguments):
        if next(calls) >= number:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(*arguments)

    with monkeypatch.context() as patch, RunWriter.open(half.path) as writer:
        patch.setattr(os, step, full)
        with pytest.raises(RunError, match="No space left") as error:
            record_all(writer)
        assert "free some space" in error.value.remedy
        stopped = read_checkpoint(half.path / "population.pickle").generation
    assert stopped > 4 or reopen(half).fingerprint() == fingerprint
    continue_run(half.path)
    assert_same(half, whole)


@pytest.mark.parametrize("change", [shutil.rmtree, lambda path: path.rename("elsewhere")])
def test_a_folder_that_is_deleted_or_moved_stops_the_run(half, change):
    with RunWriter.open(half.path) as writer:
        event = next(events(writer))
        change(half.path)
        with pytest.raises(RunError, match="the folder of the run half was deleted or moved"):
            writer.record(event)
    assert not half.path.exists()


def test_a_folder_that_is_deleted_during_a_write_stops_the_run(half, monkeypatch):
    with RunWriter.open(half.path) as writer:
        event = next(events(writer))
        monkeypatch.setattr(
            "gaitsim.runs.writer.write_provenance", lambda path, *_: shutil.rmtree(path)
        )
        with pytest.raises(RunError, match="the folder of the run half was deleted or moved"):
            writer.record(event)
    assert not half.path.exists()


def replace(path):
    data = path.read_bytes()
    path.unlink()
    path.write_bytes(data)


@pytest.mark.parametrize("change", [Path.unlink, replace])
@pytest.mark.parametrize("name", ["history.csv", "bests.bin", "checksums.bin"])
def test_a_file_that_is_deleted_or_replaced_stops_the_run(half, name, change):
    with RunWriter.open(half.path) as writer:
        generations = events(writer)
        writer.record(next(generations))
        change(half.path / name)
        with pytest.raises(RunError, match=f"{name} was deleted or replaced"):
            writer.record(next(generations))
        assert reopen(half).generation == 5


@pytest.mark.parametrize(
    "terms",
    [("best", "reach"), ("seconds",), ("reach", "mean:reach")],
)
def test_terms_named_as_columns_are_an_error(puppet, puppets, monkeypatch, terms):
    monkeypatch.setattr(
        puppets.Reach, "terms", lambda self, motion: dict.fromkeys(terms, motion["reach"])
    )
    path = create_run(puppet())
    with pytest.raises(PluginError, match=r"fitness 'puppet-reach' of package gaitsim-puppets"):
        continue_run(path)
    assert RunSnapshot(path).generation == 0


def test_a_run_in_which_all_fail_is_written_and_resumed(puppet, puppets, monkeypatch):
    monkeypatch.setattr(
        puppets.Reach, "terms", lambda self, motion: {"reach": motion["reach"] * np.nan}
    )
    path = create_run(puppet("evolution.population=1002"))
    continue_run(path, 2)
    assert continue_run(path) == ""
    run = RunSnapshot(path)
    assert run.generation == 5
    assert (run.history["best"] == -np.inf).all()
    reasons = run.checkpoint.reasons
    assert len(reasons) == 1000  # of the rest it is as well known
    assert set(reasons.values()) == {"reach is nan"}
    for generation in (None, 2):
        with pytest.raises(RunError, match=r"has no champion: every individual of .* failed"):
            run.individual(generation)
    assert run.fingerprint()


def test_bits_are_written_and_read(puppet):
    path = create_run(puppet("organism.plugin=bit-puppet"))
    continue_run(path, 2)
    continue_run(path)
    best = RunSnapshot(path).individual()
    score, genome = best.score, best.genome
    assert genome.dtype == np.uint8
    assert evaluate(RunSnapshot(path).experiment, genome[None]).scores[0] == score


def test_a_fingerprint_covers_everything_but_time(whole, puppet):
    other = create_run(puppet(LONG, THRESHOLD), Path("other"))
    continue_run(other)
    assert (other / "history.csv").read_text() != (whole.path / "history.csv").read_text()
    assert RunSnapshot(other).fingerprint() == whole.fingerprint()
    text = (other / "history.csv").read_text()
    row = text.splitlines()[3].split(",")
    (other / "history.csv").write_text(text.replace(row[3], repr(math.nextafter(float(row[3]), 9))))
    assert RunSnapshot(other).fingerprint() != whole.fingerprint()
    another = create_run(puppet(LONG, "seed=2"))
    continue_run(another)
    assert RunSnapshot(another).fingerprint() != whole.fingerprint()

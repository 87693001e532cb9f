"""A run is written as it evolves, whatever happens in the meantime."""

import errno
import math
import os
import shutil
from contextlib import suppress
from itertools import islice
from pathlib import Path
from types import SimpleNamespace

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
from gaitsim.storage.compatibility import versions
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.checkpoint import read_champion, read_checkpoint
from gaitsim.storage.files.history import best_terms
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

pytestmark = pytest.mark.usefixtures("here")


def test_a_run_is_written_and_read(whole, puppet):
    assert names(whole.path) - {".lock", ".lock-owner"} == {
        "experiment.toml",
        "history.csv",
        "measures.json",
        "bests.bin",
        "scores.bin",
        "checksums.bin",
        "saves.bin",
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


def test_before_the_first_generation_there_is_no_individual(puppet):
    run = RunSnapshot(create_run(puppet()))
    assert run.checkpoint is None
    assert (run.generation, run.history, len(run.bests)) == (0, {}, 0)
    for ask in (run.individual, run.fingerprint, lambda: run.individual(1)):
        with pytest.raises(RunError, match="has no finished generation yet") as error:
            ask()
        assert "gaitsim resume runs/puppet" in error.value.remedy


def saved(path):
    """Return the generations after which a run in `path` was saved, as it grows."""
    return RunSnapshot(path).generation


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [
        (0.125, [1, 1, 1, 1, 5, 5, 5, 8]),
        (0.25, [1, 1, 3, 3, 5, 5, 7, 8]),
        (0.26, [1, 2, 3, 4, 5, 6, 7, 8]),  # two of them take more than half a second
        (1e-9, [1, 1, 1, 1, 1, 1, 1, 8]),
    ],
)
def test_generations_are_saved_at_least_every_half_second_and_at_the_end(
    puppet, whole, monkeypatch, seconds, expected
):
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr("gaitsim.storage.writer.time", SimpleNamespace(monotonic=lambda: clock.now))
    path, found = create_run(puppet(LONG)), []
    with RunWriter.open(path) as writer:
        for event in events(writer):
            clock.now += seconds
            writer.record(event)
            found.append(saved(path))
    assert found == expected
    assert RunSnapshot(path).history["best"].tolist() == whole.history["best"].tolist()


@pytest.mark.usefixtures("gathering")
@pytest.mark.parametrize("end", [KeyboardInterrupt, PluginError("it fails")])
def test_the_gathered_generations_are_saved_however_the_loop_ends(puppet, end):
    path = create_run(puppet(LONG))
    with suppress(KeyboardInterrupt, PluginError), RunWriter.open(path) as writer:
        for event in islice(events(writer), 3):
            writer.record(event)
        assert saved(path) == 1
        raise end
    assert saved(path) == 3


# The steps that save generations, in order.
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
@pytest.mark.parametrize(("gathered", "options"), [(1, [THRESHOLD]), (3, [])])
def test_a_run_killed_at_any_step_resumes_identically(
    puppet, monkeypatch, begun, gathered, options, owner, step, number
):
    path, whole = create_run(puppet(LONG, *options)), create_run(puppet(LONG, *options))
    continue_run(whole)
    if begun:
        continue_run(path, begun)
    unchanged = begun and RunSnapshot(path).fingerprint()
    with RunWriter.open(path) as writer, monkeypatch.context() as patch:
        *before, last = islice(events(writer), gathered)
        for event in before:
            writer.record(event)
            patch.setattr("gaitsim.storage.writer.PERIOD", math.inf)
        kill_at(patch, owner, step, number)
        with pytest.raises(Killed):  # noqa: PT012
            writer.record(last)
            writer.save()
    # Until the new checkpoint is written, the run is unchanged.
    run = RunSnapshot(path)
    if run.generation == begun:
        assert len(run.history.get("best", [])) == begun
        assert len(run.bests) == begun
        assert (begun and run.fingerprint()) == unchanged
    continue_run(path)
    assert_same(run, RunSnapshot(whole))
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


def replace(path):
    data = path.read_bytes()
    path.unlink()
    path.write_bytes(data)


@pytest.mark.parametrize("change", [Path.unlink, replace])
@pytest.mark.parametrize("name", ["history.csv", "bests.bin", "scores.bin", "checksums.bin"])
def test_a_file_that_is_deleted_or_replaced_stops_the_run(half, name, change):
    with RunWriter.open(half.path) as writer:
        generations = events(writer)
        writer.record(next(generations))
        change(half.path / name)
        writer.record(next(generations))
        with pytest.raises(RunError, match=f"{name} was deleted or replaced"):
            writer.save()
        assert reopen(half).generation == 5


@pytest.mark.parametrize("terms", [("best", "reach"), ("reach", "mean:reach")])
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

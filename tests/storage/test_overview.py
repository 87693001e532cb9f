"""The quick list of runs says the same as a full read of each run."""

import pytest

from gaitsim.storage.files import safe_pickle
from gaitsim.storage.growing import overview
from gaitsim.storage.lock import RunLock
from gaitsim.storage.overview import list_overviews

COMPARED = (
    *("path", "state", "plugins", "description", "seed", "generation", "generations", "best"),
    *("stage", "changed", "failure", "note", "tags", "evaluations", "options", "terms"),
)


read_in_full = overview


@pytest.fixture
def full_reads(monkeypatch):
    """The paths of the runs that are read in full."""
    read = []

    def spied(path):
        read.append(path)
        return overview(path)

    monkeypatch.setitem(globals(), "read_in_full", spied)
    return read


def check(path):
    """Check that the list agrees with a full read, and return the run's entry."""
    (listed,) = list_overviews(path.parent, read_in_full)
    expected = overview(path)
    for name in COMPARED:
        assert getattr(listed, name) == getattr(expected, name), name
    assert str(listed.problem) == str(expected.problem)
    assert listed.seconds == pytest.approx(expected.seconds)
    return listed


@pytest.mark.parametrize(
    ("overrides", "generations", "state"),
    [
        ([], 3, "stopped"),
        (["evolution.target_score=-1000"], 1, "finished"),
        (["evolution.target_score=1e6"], 2, "stopped"),
        (["evolution.max_evaluations=18", "evolution.population=6"], 2, "stopped"),
        (["evolution.stagnation=400"], 2, "stopped"),
        (["islands.number=2"], 2, "stopped"),
        (["search.plugin=cma-es"], 2, "stopped"),
    ],
)
def test_a_usual_run_is_read_quickly(walk, full_reads, overrides, generations, state):
    found = check(walk("walk", generations, *overrides))
    assert (found.state, found.generation) == (state, generations)
    assert not full_reads


def test_a_run_that_a_process_writes_is_running(walk, full_reads):
    path = walk()
    lock = RunLock(path)
    assert check(path).state == "running"
    lock.release()
    assert not full_reads


def test_times_are_left_out_if_they_are_not_needed(walk, full_reads):
    path = walk()
    (listed,) = list_overviews(path.parent, read_in_full, times=False)
    assert listed.seconds == 0
    assert listed.terms == overview(path).terms
    assert not full_reads


def edit(name, old, new):
    def change(path):
        text = (path / name).read_text()
        assert old in text
        (path / name).write_text(text.replace(old, new))

    return change


def cut(name, size):
    return lambda path: (path / name).write_bytes((path / name).read_bytes()[:size])


def flip(name, at):
    def change(path):
        data = bytearray((path / name).read_bytes())
        data[at] ^= 1
        (path / name).write_bytes(data)

    return change


def reseal(**changed):
    """Return a function that changes values of a checkpoint, with a right checksum."""

    def change(path):
        content = safe_pickle.load(path / "population.pickle")
        (path / "population.pickle").write_bytes(safe_pickle.dumps({**content, **changed}))

    return change


def remove_checkpoints(path):
    for file in path.glob("population*"):
        file.unlink()


UNUSUAL = {
    "more generations": edit("experiment.toml", "generations = 5", "generations = 9"),
    "a comment": edit("experiment.toml", "[evolution]", "# mine\n[evolution]"),
    "invalid TOML": edit("experiment.toml", "[evolution]", "[evolution"),
    "a damaged checkpoint": flip("population.pickle", -9),
    "a newer checkpoint": flip("population.pickle", 8),
    "only the previous checkpoint": lambda path: (path / "population.pickle").unlink(),
    "no checkpoint": remove_checkpoints,
    "a short history": cut("history.csv", 200),
    "a generation too high": reseal(generation=4),
    "a best score that is not a number": reseal(best_score=float("nan")),
    "scores without a shape": reseal(scores=[]),
    "another kind": reseal(kind="champion"),
}


@pytest.mark.parametrize("change", UNUSUAL.values(), ids=UNUSUAL)
def test_an_unusual_run_is_read_in_full(walk, full_reads, change):
    path = walk()
    change(path)
    check(path)
    assert full_reads == [path]


def test_a_run_before_its_first_generation(walk, full_reads):
    path = walk("walk", 0)
    found = check(path)
    assert (found.state, found.generation, found.best) == ("stopped", 0, None)
    assert full_reads == [path]

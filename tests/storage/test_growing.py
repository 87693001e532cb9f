"""A growing run is followed: only new rows are read, and all rows if the file was rewritten."""

import os
import shutil
from functools import partial

import pytest
from run_helpers import evolve_run

from gaitsim.errors import RunError
from gaitsim.storage.growing import RunFollower


@pytest.fixture
def walk(walk):
    """Return a function that creates runs of up to 30 generations."""
    return partial(walk, generations=30)


def numbers(follower):
    """The generations of the new rows; None if nothing has changed."""
    run = follower.poll()
    if run is None:
        return None
    rows = follower.read_rows(run)
    return rows["generation"].tolist() if rows else []


def test_only_new_rows_are_read(walk):
    path = walk()
    follower = RunFollower(path)
    assert numbers(follower) == [1, 2, 3]
    assert numbers(follower) is None
    evolve_run(path, 5)
    assert numbers(follower) == [4, 5]
    assert numbers(follower) is None
    assert follower.modified == pytest.approx((path / "history.csv").stat().st_mtime, abs=5)


def test_a_run_without_a_generation_has_no_rows(walk):
    follower = RunFollower(walk("run", 0))
    assert numbers(follower) == []
    assert numbers(RunFollower(walk("other", 0).parent / "nowhere")) is not None


def test_rows_after_the_checkpoint_and_half_written_ones_come_later(walk):
    path = walk("run", 3)
    before = {file: file.read_bytes() for file in path.glob("*.pickle")}
    evolve_run(path, 5)
    whole = (path / "history.csv").read_bytes()
    for file, content in before.items():  # as when a process is killed before its checkpoint
        file.write_bytes(content)
    (path / "history.csv").write_bytes(whole[:-3])
    follower = RunFollower(path)
    assert numbers(follower) == [1, 2, 3]
    evolve_run(path, 6)
    assert numbers(follower) == [4, 5, 6]


def test_a_history_with_new_columns_is_read_from_the_start(walk, climb):
    path = walk("run", 3)
    follower = RunFollower(path)
    assert numbers(follower) == [1, 2, 3]
    evolve_run(path, 5, "fitness.plugin=puppet-climb")
    assert numbers(follower) == [1, 2, 3, 4, 5]


def test_a_replaced_run_is_read_from_the_start(walk):
    path, other = walk("run", 3), walk("other", 6, "seed=2")
    follower = RunFollower(path)
    assert numbers(follower) == [1, 2, 3]
    shutil.copytree(other, path, dirs_exist_ok=True)
    os.utime(path / "history.csv", ns=(1, 1))
    assert numbers(follower) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("content", ["", "\0\n"])
def test_a_damaged_history_is_reported_until_it_is_restored(walk, content):
    path = walk()
    file = path / "history.csv"
    whole = file.read_bytes()
    file.write_text(content)
    follower = RunFollower(path)
    run = follower.poll()
    for _ in range(2):
        with pytest.raises(RunError, match=r"history\.csv"):
            follower.read_rows(run)
    file.write_bytes(whole)
    assert numbers(follower) == [1, 2, 3]

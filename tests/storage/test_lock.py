import errno
import os
import subprocess
import sys

import pytest
from filelock import FileLock

from gaitsim.errors import RunError
from gaitsim.storage.lock import RunLock, is_locked

HOLD = """
import sys
from pathlib import Path
from gaitsim.storage.lock import RunLock
lock = RunLock(Path(sys.argv[1]))
print("locked", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock of the test's folder."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, tmp_path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdout.readline().strip() == b"locked"
    yield process
    process.kill()
    process.communicate()


def test_the_other_process_is_named(tmp_path, holder):
    assert is_locked(tmp_path)
    with pytest.raises(RunError, match=f"is being written by process {holder.pid} on ") as error:
        RunLock(tmp_path)
    assert "stop it with Ctrl-C" in error.value.remedy


def test_a_killed_process_holds_no_lock(tmp_path, holder):
    holder.kill()
    holder.wait()
    assert (tmp_path / ".lock-owner").exists()
    assert not is_locked(tmp_path)
    RunLock(tmp_path).release()


def test_checking_the_lock_does_not_block_a_writer(tmp_path, monkeypatch):
    assert not is_locked(tmp_path)
    assert list(tmp_path.iterdir()) == []
    RunLock(tmp_path).release()
    asking = FileLock(tmp_path / ".lock")
    asking.acquire()
    monkeypatch.setattr("time.sleep", lambda seconds: asking.release())
    RunLock(tmp_path).release()


def test_a_folder_that_cannot_be_locked_is_named(tmp_path, monkeypatch):
    (tmp_path / ".lock").mkdir()
    with pytest.raises(RunError, match=r"cannot lock the run .*directory"):
        RunLock(tmp_path)
    assert not is_locked(tmp_path)
    (tmp_path / ".lock").rmdir()

    def read_only(*arguments, **options):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(FileLock, "acquire", read_only)
    with pytest.raises(RunError, match="Read-only file system") as error:
        RunLock(tmp_path)
    assert "is writable" in error.value.remedy
    assert not is_locked(tmp_path)


def test_a_lock_holds_even_if_its_owner_cannot_be_recorded(tmp_path):
    (tmp_path / ".lock-owner").mkdir()
    lock = RunLock(tmp_path)
    assert is_locked(tmp_path)
    lock.release()

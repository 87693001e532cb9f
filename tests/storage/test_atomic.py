import errno
import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gaitsim.errors import RunError
from gaitsim.storage.files.atomic import replacing, set_aside, sweep, write_bytes, write_rotating

OLDEST, OLD, NEW = b"oldest" * 100, b"old" * 100, b"new" * 100


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def fail_at(monkeypatch, owner, function, *, number=0, code=errno.ENOSPC, check=lambda: None):
    """Let the call `number` of a function fail; `check` runs before every call."""
    real = getattr(owner, function)
    calls = []

    def stub(*args, **options):
        check()
        calls.append(args)
        if len(calls) == number + 1:
            raise OSError(code, os.strerror(code))
        return real(*args, **options)

    monkeypatch.setattr(owner, function, stub)
    return calls


def put(path, data):
    with replacing(path) as partial:
        partial.write_bytes(data)


@pytest.mark.skipif(os.name == "nt", reason="needs pipes and links")
@pytest.mark.parametrize("write", [write_bytes, put])
def test_no_pipe_is_replaced_and_links_stay_links(tmp_path, write):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "to-pipe").symlink_to("pipe")
    for name in ("pipe", "to-pipe", "/dev/null"):
        with pytest.raises(RunError, match="is a device or a pipe, not a file"):
            write(tmp_path / name, NEW)
    assert (tmp_path / "pipe").is_fifo()
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("folder/file")
    for data in (OLD, NEW):
        write(tmp_path / "link", data)
        assert (tmp_path / "folder" / "file").read_bytes() == data
    assert (tmp_path / "link").is_symlink()
    assert names(tmp_path / "folder") == ["file"]


def test_files_have_the_permissions_of_any_new_file(tmp_path):
    plain = tmp_path / "plain"
    plain.touch()
    write_bytes(tmp_path / "a", NEW)
    assert (tmp_path / "a").stat().st_mode == plain.stat().st_mode


def test_data_is_on_the_disk_before_the_name_is(tmp_path, monkeypatch):
    path = tmp_path / "a"
    order = []
    real_sync, real_replace = os.fsync, Path.replace
    monkeypatch.setattr(os, "fsync", lambda fd: (order.append("sync"), real_sync(fd)))
    monkeypatch.setattr(
        Path, "replace", lambda self, to: (order.append("rename"), real_replace(self, to))
    )
    write_bytes(path, NEW)
    assert order == ["sync", "rename", "sync"] if os.name != "nt" else ["sync", "rename"]


@pytest.mark.parametrize(
    ("code", "remedy"),
    [
        (errno.ENOSPC, "free some space"),
        (errno.EACCES, "choose another folder"),
        (errno.EIO, "check the disk"),
    ],
)
@pytest.mark.parametrize("step", [(os, "fsync"), (Path, "open"), (Path, "replace")])
def test_a_failed_write_leaves_everything_as_it_was(tmp_path, monkeypatch, step, code, remedy):
    path, fresh = tmp_path / "a", tmp_path / "b"
    path.write_bytes(OLD)
    for target in (path, fresh):
        with monkeypatch.context() as patch:
            fail_at(patch, *step, code=code)
            with pytest.raises(RunError) as error:
                write_bytes(target, NEW)
        assert error.value.where == str(target)
        assert remedy in error.value.remedy
        assert os.strerror(code) in error.value.what
    assert path.read_bytes() == OLD
    assert names(tmp_path) == ["a"]


def test_a_missing_folder_and_a_file_for_a_folder_are_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(RunError) as error:
        write_bytes(tmp_path / "missing" / "a", NEW)
    assert "create the folder" in error.value.remedy
    with pytest.raises(RunError):
        write_bytes(tmp_path / "file" / "a", NEW)
    with pytest.raises(RunError):
        write_bytes(tmp_path, NEW)


def test_folders_that_cannot_be_synced_are_no_error(tmp_path, monkeypatch):
    fail_at(monkeypatch, os, "fsync", number=1, code=errno.EINVAL)
    write_bytes(tmp_path / "a", NEW)
    assert (tmp_path / "a").read_bytes() == NEW


def test_a_disk_that_fails_when_the_folder_is_synced_is_an_error(tmp_path, monkeypatch):
    fail_at(monkeypatch, os, "fsync", number=1, code=errno.EIO)
    with pytest.raises(RunError):
        write_bytes(tmp_path / "a", NEW)


def test_rotation_keeps_the_previous_file(tmp_path):
    path, previous = tmp_path / "a", tmp_path / "a.previous"
    write_rotating(path, previous, OLDEST)
    assert names(tmp_path) == ["a"]
    write_rotating(path, previous, OLD)
    write_rotating(path, previous, NEW)
    assert (path.read_bytes(), previous.read_bytes()) == (NEW, OLD)
    assert names(tmp_path) == ["a", "a.previous"]


@pytest.mark.parametrize("links", [True, False], ids=["hard links", "no hard links"])
def test_both_files_are_whole_whenever_a_rotation_stops(tmp_path, monkeypatch, links):
    path, previous = tmp_path / "a", tmp_path / "a.previous"
    stopped = 0

    def check():
        for file, whole in ((path, (OLD, NEW)), (previous, (OLDEST, OLD))):
            with io.FileIO(file) as opened:  # without the functions that are made to fail
                assert opened.read() in whole

    for owner, function in [(os, "fsync"), (os, "open"), (Path, "open"), (Path, "replace")]:
        for number in range(5):
            path.write_bytes(OLD)
            previous.unlink(missing_ok=True)  # it may be the same file by another name
            previous.write_bytes(OLDEST)
            with monkeypatch.context() as patch:
                if not links:
                    fail_at(patch, os, "link", code=errno.EPERM)
                calls = fail_at(patch, owner, function, number=number, code=errno.EIO)
                # Checked before every step, not only before the one that fails.
                for step in ("unlink", "exists"):
                    fail_at(patch, Path, step, number=99, check=check)
                try:
                    write_rotating(path, previous, NEW)
                except RunError:
                    stopped += 1
                    assert len(calls) > number
            check()
            assert names(tmp_path) == ["a", "a.previous"]
    assert stopped >= 6


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_killed_program_leaves_whole_files_and_partials_that_can_be_removed(tmp_path):
    path, previous = tmp_path / "a", tmp_path / "a.previous"
    path.write_bytes(OLD)
    program = """
import os, sys
from pathlib import Path
from gaitsim.storage.files import atomic
path = Path(sys.argv[1])
Path.replace = lambda *names: os._exit(9)
atomic.write_rotating(path, path.with_name("a.previous"), b"new")
"""
    ran = subprocess.run([sys.executable, "-c", program, path], check=False)
    assert ran.returncode == 9
    assert len(names(tmp_path)) == 3
    sweep(tmp_path)
    assert names(tmp_path) == ["a"]
    assert path.read_bytes() == OLD
    assert not previous.exists()


def test_setting_aside_never_overwrites(tmp_path):
    for content in (OLDEST, OLD):
        path = tmp_path / "a.pickle"
        path.write_bytes(content)
        set_aside(path, "damaged")
    assert names(tmp_path) == ["a.damaged-1.pickle", "a.damaged-2.pickle"]
    assert (tmp_path / "a.damaged-1.pickle").read_bytes() == OLDEST
    assert (tmp_path / "a.damaged-2.pickle").read_bytes() == OLD


def test_a_block_replaces_a_file_only_if_it_succeeds(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(OLD)

    def stop(partial: Path) -> None:
        partial.write_bytes(NEW[:10])
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), replacing(path) as partial:
        stop(partial)
    assert path.read_bytes() == OLD
    with replacing(path) as partial:
        partial.write_bytes(NEW)
        assert path.read_bytes() == OLD
    assert path.read_bytes() == NEW
    assert names(tmp_path) == ["a"]

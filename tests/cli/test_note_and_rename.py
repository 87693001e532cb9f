"""`gaitsim note`, `gaitsim rename`, and the same in Python."""

import json

import pytest

from gaitsim.errors import RunError
from gaitsim.storage.creation import create_run
from gaitsim.storage.growing import overview
from gaitsim.storage.lock import RunLock
from gaitsim.storage.manage import LARGEST, read_note, rename_run, write_note


@pytest.fixture
def run(puppet, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return create_run(puppet(), tmp_path / "runs" / "walk")


class TestNote:
    def test_a_note_is_written_shown_replaced_and_removed(self, gaitsim, run):
        assert "has no note" in gaitsim("note", "walk").stderr
        gaitsim("note", "walk", "drags\r\na leg \x1b[2J\n\n")
        assert gaitsim("note", "walk").stdout == "drags\na leg \\x1b[2J\n"
        assert "a leg \\x1b[2J" in gaitsim("show", "walk").stdout
        assert overview(run).note == read_note(run) == "drags\na leg \x1b[2J"
        gaitsim("note", "walk", "straight")
        assert json.loads(gaitsim("show", "walk", "--json").stdout)["note"] == "straight"
        gaitsim("note", "walk", " ")
        assert not (run / "note.txt").exists()
        assert [path.name for path in run.iterdir() if "partial" in path.name] == []

    def test_a_long_note_and_a_missing_run_are_rejected(self, run):
        write_note(run, "kept")
        for text in ("x" * LARGEST, "\ud800"):
            with pytest.raises(RunError, match="note"):
                write_note(run, text)
        assert read_note(run) == "kept"
        with pytest.raises(RunError, match="no run"):
            write_note(run.with_name("other"), "lost")

    def test_links_are_not_followed(self, gaitsim, run, tmp_path):
        secret = tmp_path / "secret"
        secret.write_text("mine")
        (run / "note.txt").symlink_to(secret)
        with pytest.raises(RunError, match="symbolic link"):
            read_note(run)
        assert "symbolic link" in overview(run).note
        done = gaitsim("show", "walk")
        assert "mine" not in done.stdout
        assert "symbolic link" in done.stderr
        write_note(run, "new")
        assert (secret.read_text(), read_note(run)) == ("mine", "new")


class TestRename:
    def test_the_folder_keeps_its_content(self, gaitsim, run):
        write_note(run, "kept")
        before = {path.name for path in run.iterdir()}
        assert gaitsim("rename", "walk", "strut").stdout == "runs/walk is now runs/strut\n"
        assert not run.exists()
        there = run.with_name("strut")
        assert {path.name for path in there.iterdir()} - before <= {".lock", ".lock-owner"}
        assert read_note(there) == "kept"
        RunLock(there).release()  # the lock is free

    @pytest.mark.parametrize("name", ["", ".", "a/b", "a\nb", "x" * 300])
    def test_an_invalid_name_is_rejected(self, run, name):
        with pytest.raises(RunError):
            rename_run(run, name)
        assert [path.name for path in run.parent.iterdir()] == ["walk"]

    def test_an_existing_name_is_rejected(self, gaitsim, run):
        run.with_name("strut").mkdir()  # an empty folder, which a rename would replace
        done = gaitsim("rename", "walk", "strut", code=2)
        assert "already exists" in done.stderr
        assert run.exists()

    def test_a_run_that_is_evolving_and_a_link_are_not_renamed(self, run):
        lock = RunLock(run)
        with pytest.raises(RunError, match="being written"):
            rename_run(run, "strut")
        lock.release()
        link = run.with_name("link")
        link.symlink_to(run)
        with pytest.raises(RunError, match="symbolic link"):
            rename_run(link, "strut")

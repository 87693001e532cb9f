"""Drafts of killed programs are removed; those of others are left alone."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gaitsim.storage.files.atomic import draft_file, draft_folder, draft_name, locked, sweep

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs fork and locks")


def in_child(work):
    child = os.fork()
    if not child:
        try:
            work()
        finally:
            os._exit(0)
    os.waitpid(child, 0)


@pytest.mark.parametrize("draft", [draft_file, draft_folder])
def test_a_draft_is_swept_once_its_process_has_ended(tmp_path, draft):
    def leave():
        with draft(tmp_path):
            os._exit(0)

    in_child(leave)
    (left,) = tmp_path.iterdir()
    with draft(tmp_path) as mine:
        in_child(lambda: sweep(tmp_path))
        assert [*tmp_path.iterdir()] == [mine]
        assert mine != left
    assert not [*tmp_path.iterdir()]


def test_a_draft_under_its_second_name_stays(tmp_path):
    (tmp_path / "whole").touch()
    second = draft_name(tmp_path)
    with locked(tmp_path / "whole"):
        second.hardlink_to(tmp_path / "whole")
        in_child(lambda: sweep(tmp_path))
        assert second.exists()


def test_a_draft_swept_before_it_is_locked_is_created_again(tmp_path, monkeypatch):
    real = Path.mkdir
    made = []

    def swept(path):
        real(path)
        made.append(path)
        if len(made) == 1:
            sweep(tmp_path)

    monkeypatch.setattr(Path, "mkdir", swept)
    with draft_folder(tmp_path) as path:
        assert [*tmp_path.iterdir()] == [path] == made[1:]


def test_sweeping_follows_no_link_and_waits_for_no_pipe(tmp_path):
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "file").touch()
    draft_name(tmp_path).symlink_to("kept")
    os.mkfifo(draft_name(tmp_path))
    draft_name(tmp_path).mkdir()
    sweep(tmp_path)
    sweep(tmp_path / "missing")
    assert [path.name for path in tmp_path.rglob("*")] == ["kept", "file"]


@pytest.mark.slow
def test_repeating_a_command_after_a_fault_leaves_no_drafts(puppet_file):
    script = Path(__file__).parent / "faults.py"
    puppets = Path(__file__).parent.parent / "puppets"
    ran = subprocess.run(
        [sys.executable, script, "13"],
        cwd=puppet_file.parent,
        env=os.environ | {"PYTHONPATH": str(puppets)},
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(ran.stdout)
    assert found["cases"] > 29
    assert not found["wrong"]

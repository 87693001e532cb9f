"""Buffered output at the end of a command."""

import os
import sys
from pathlib import Path

import pytest

from gaitsim.console import streams


def test_a_closed_pipe_is_not_an_error(monkeypatch):
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as stdout:
        monkeypatch.setattr(sys, "stdout", stdout)
        print("too late")
        assert streams.finish() == ""
        stdout.flush()  # as Python does at exit


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_reported(monkeypatch):
    with Path("/dev/full").open("w") as stdout:
        monkeypatch.setattr(sys, "stdout", stdout)
        print("too much")
        assert "No space left" in streams.finish()
        stdout.flush()


def test_output_to_a_closed_stream_is_discarded(monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    streams.prepare()
    print("nobody reads this")
    assert streams.finish() == ""
    sys.stdout.close()
    sys.stderr.close()

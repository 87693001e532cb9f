"""Opening files from untrusted sources."""

import os
import socket
from pathlib import Path

import pytest

from gaitsim.opening import open_descriptor, open_regular, read_regular

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs pipes and links")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    return path


def create_special_file(kind, path, file):
    """Put something at `path` that is not a regular file."""
    match kind:
        case "a pipe":
            os.mkfifo(path)
        case "a folder":
            path.mkdir()
        case "a socket":
            with socket.socket(socket.AF_UNIX) as server:
                server.bind(os.path.relpath(path))
        case "a link":
            path.symlink_to(file)
        case "a link to nothing":
            path.symlink_to("nothing")
        case "a link to a device":
            path.symlink_to("/dev/zero")


KINDS = "a pipe", "a folder", "a socket", "a link", "a link to nothing", "a link to a device"


@pytest.mark.parametrize("flags", [os.O_RDONLY, os.O_RDWR | os.O_CREAT])
@pytest.mark.parametrize("kind", KINDS)
def test_only_a_regular_file_is_opened(tmp_path, file, monkeypatch, kind, flags):
    monkeypatch.chdir(tmp_path)  # paths of sockets are limited to about 100 characters
    create_special_file(kind, path := tmp_path / "a", file)
    with pytest.raises(OSError, match=r"not a regular file|symbolic link|Is a directory") as error:
        open_descriptor(path, flags)
    assert error.value.strerror
    assert not (tmp_path / "nothing").exists()
    assert file.read_bytes() == b"12345"


def test_a_link_named_by_a_user_is_followed_to_a_regular_file(tmp_path, file):
    (tmp_path / "link").symlink_to(file)
    assert read_regular(tmp_path / "link", 9, follow=True) == b"12345"
    with pytest.raises(OSError, match="not a regular file"):
        read_regular(Path("/dev/zero"), 9, follow=True)


def test_a_file_is_read_up_to_its_limit(file, monkeypatch):
    assert read_regular(file, 5) == b"12345"
    for read in (read_regular, open_regular):
        with pytest.raises(OSError, match="too large: 5 bytes, at most 4"):
            read(file, 4)
    # Simulates a file that grows, or whose reported size is 0.
    monkeypatch.setattr("gaitsim.opening._size", lambda file: 0)
    assert read_regular(file, 5) == b"12345"
    with pytest.raises(OSError, match="too large"):
        read_regular(file, 4)


def test_a_hard_link_is_read_but_not_written(file):
    os.link(file, file.with_name("other"))
    assert read_regular(file, 5) == b"12345"
    with pytest.raises(OSError, match="hard link"):
        open_descriptor(file, os.O_RDWR)


def test_a_rejected_file_is_closed(tmp_path, file):
    def free():
        descriptor = open_descriptor(file, os.O_RDONLY)
        os.close(descriptor)
        return descriptor

    before = free()
    for path in (file, tmp_path):
        with pytest.raises(OSError, match=r"too large|directory"):
            open_regular(path, 1)
    assert free() == before

"""Every reader of untrusted bytes reads or refuses a file, whatever that contains.

The quick tests try a few changes of each file, the slow tests more. With `GAITSIM_FUZZ=600`, the
slow tests try different changes for 600 seconds per reader, and keep the content that breaks it.
"""

import os
import random
import re
import signal
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

import pytest
from readers import FORKED, READERS

from gaitsim_robot import child

SECONDS = os.environ.get("GAITSIM_FUZZ")
PATIENCE = 60  # seconds until a reader counts as hung
MEMORY = 200e6  # bytes that a reader may take for a small file
MOST = 200  # contents from which further ones are made


class Watch:
    """An audit hook that finds code that is executed, and changes outside a folder."""

    # Events with paths: their number, and the position of the first descriptor of a folder.
    PATHS: ClassVar = {
        "os.remove": (1, 1), "os.rmdir": (1, 1), "os.mkdir": (1, 2), "os.chmod": (1, 2),
        "os.truncate": (1, 9), "os.rename": (2, 2), "os.link": (2, 2), "os.symlink": (1, 9),
    }  # fmt: skip
    FORBIDDEN = ("os.system", "os.exec", "os.posix_spawn", "pickle.find_class", "socket.connect")
    WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC

    def __init__(self):
        self.folder, self.found = None, []
        sys.addaudithook(self.audit)

    def audit(self, event, given):
        if self.folder is None:
            return
        if event == "open":
            wrong = given[2] & self.WRITING and not self.is_inside(given[0])
        elif event in self.PATHS:
            count, at = self.PATHS[event]
            folders = (*given[at:], *[-1] * count)
            wrong = not all(map(self.is_inside, given[:count], folders))
        elif event == "subprocess.Popen":
            wrong = Path(os.fsdecode(given[0])).name != "ssh-keygen"
        else:
            wrong = event in self.FORBIDDEN
        if wrong:
            self.found.append(f"{event} {given!r:.300}")

    def is_inside(self, path, folder=-1):
        """Return whether a path is in the folder, or of compiled modules, which Python writes."""
        if isinstance(path, int):
            return True
        base = "." if folder == -1 else f"/proc/self/fd/{folder}"
        path = os.path.realpath(Path(base, os.fsdecode(path)))
        inside = path == self.folder or path.startswith(f"{self.folder}/")
        return inside or path == os.devnull or "__pycache__" in path


WATCH = Watch()


@contextmanager
def watched(folder):
    """Report a reader that takes too long, changes files outside a folder, or takes much memory."""

    def hang(*_):
        raise TimeoutError(f"reading took more than {PATIENCE} s")

    before = signal.signal(signal.SIGALRM, hang)
    signal.alarm(PATIENCE)
    start = memory("VmRSS")
    WATCH.folder, WATCH.found = os.path.realpath(folder), []
    try:
        yield
    finally:
        WATCH.folder = None
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    assert not WATCH.found
    assert memory("VmHWM") - start < MEMORY


def memory(kind):
    """Return the memory of this process, or the most that it has taken since the last call."""
    status = Path("/proc/self/status")
    if not status.exists():
        return 0
    found = int(re.search(rf"{kind}:\s*(\d+) kB", status.read_text())[1]) * 1024
    Path("/proc/self/clear_refs").write_text("5")
    return found


def attempt(reader, path, data, folder):
    """Read data; return what kind of a result that was."""
    path.write_bytes(data)
    with watched(folder):
        try:
            reader.read(path)
        except reader.refusals as error:
            assert str(error)  # noqa: PT017
            return re.sub(r"'[^']*'|\"[^\"]*\"|[\d.,]+", "", getattr(error, "what", str(error)))
    return "read"


def fuzz(reader, folder, count, seconds, seed):
    """Try changes of a file; those with a new kind of result are changed further."""
    path = reader.make(folder)
    valid = path.read_bytes()
    reader.read(path)  # imports modules and compiles kernels
    assert attempt(reader, path, valid, folder) == "read"
    for data in reader.found:
        assert attempt(reader, path, data, folder) != "read"
    chance, end, results = random.Random(seed), time.monotonic() + seconds, {"read"}
    corpora = [(layer, [layer.unwrap(valid)]) for layer in reader.layers]
    while count > 0 and time.monotonic() < end:
        layer, corpus = chance.choice(corpora)
        part = layer.change(chance.choice(corpus), chance)
        try:
            data = layer.wrap(part)
        except Exception:
            continue  # the format has no place for this value
        count -= 1
        try:
            result = attempt(reader, path, data, folder)
        except BaseException as error:
            kept = Path(tempfile.gettempdir(), f"broken-{abs(hash(data))}")
            kept.write_bytes(data)
            raise AssertionError(f"{data[:2000]!r} broke the reader; see {kept}") from error
        if result not in results and len(corpus) < MOST:
            results.add(result)
            corpus.append(part)
    return results


@pytest.fixture
def folder(tmp_path, puppets, monkeypatch):
    """Return an empty folder; robots are read in forks, and temporary files are in the folder."""
    monkeypatch.setattr(child, "subprocess", FORKED)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "reader"
    folder.mkdir()
    monkeypatch.setenv("GAITSIM_RUNTIME_DIR", str(folder / "processes"))
    (folder / "tmp").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder / "tmp"))
    return folder


pytestmark = pytest.mark.skipif(not hasattr(signal, "alarm"), reason="needs alarms and forks")


@pytest.mark.parametrize("name", READERS)
def test_changed_files_are_read_or_refused(name, folder):
    fuzz(READERS[name], folder, 15, 0.3, 0)


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_many_changed_files_are_read_or_refused(name, folder):
    seed = random.randrange(2**32) if SECONDS else 1
    results = fuzz(READERS[name], folder, 10**9, float(SECONDS or 1), seed)
    if SECONDS:
        print(f"{name}: seed {seed}, {len(results)} kinds of results")

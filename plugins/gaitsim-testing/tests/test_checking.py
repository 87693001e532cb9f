"""Plugins are checked in other processes, whose hangs, crashes and output become findings."""

import os
import signal
from pathlib import Path

import pytest
from waiting import until

from gaitsim.errors import GaitsimError
from gaitsim_testing import checking
from gaitsim_testing.checking import check_plugins
from gaitsim_testing.packages import select_plugins


def check(name, seconds=60.0):
    with select_plugins(name) as found:
        return list(check_plugins(found, seconds=seconds))


ODD = '''
import os
class Loops(Still):
    """Never ready."""
    def mutate(self, *_):
        while True: pass
class Ends(Still):
    """The end of the process."""
    def mutate(self, *_):
        os._exit(3)
class Killed(Still):
    """The end of the process, from outside."""
    def mutate(self, *_):
        os.kill(os.getpid(), 9)
class Loud(Still):
    """Still, but loud."""
    def mutate(self, genomes, space, rng):
        print("mutating")
        os.system("echo a child of it")
        return genomes.copy()
class Hashes(Still):
    """Depends on the order of a set."""
    def mutate(self, genomes, space, rng):
        first = next(iter({*"abcdefghijklmnop"}))
        return space.repair(genomes + genomes.dtype.type(first == "a"))
class Worker(Still):
    """Depends on the process."""
    def mutate(self, genomes, space, rng):
        return space.repair(genomes ^ np.uint8(os.getpid() % 2) if genomes.dtype == np.uint8
            else genomes + 1e-9 * os.getpid())
'''
SAYS = {
    "Loops": "breeding: the time limit is exceeded",
    "Ends": "the process ended early, exit code 3 in test_breeding",
    "Killed": "the process ended early, killed by signal 9 in test_breeding",
    "Worker": "processes: different bits in another process",
}


@pytest.mark.slow
def test_after_a_crash_or_a_timeout_the_other_plugins_are_checked(install, working):
    names = ("Ends", "Killed", "Loops", "Loud", "Still", "Worker")
    install("fake", working + ODD, {"mutation": {name: name for name in names}})
    found = {one.entry.name: one for one in check("fake", seconds=5)}
    assert tuple(found) == names
    for name, says in SAYS.items():
        (broken,) = found[name].broken
        assert says.partition(": ")[2] in broken, broken
    (advice,) = found["Loud"].advice
    assert "mutating\\na child of it" in advice
    assert (found["Still"].broken, found["Still"].advice) == ([], [])


def test_an_import_error_says_where(install):
    install("fake", "x = 1\nimport no_such_thing\n", {"organism": {"x": "X"}})
    (found,) = check("fake")
    (broken,) = found.broken
    assert "No module named 'no_such_thing'" in broken
    assert "fake.py, line 2" in broken


def test_a_missing_library_is_named(install, working, monkeypatch):
    install("fake", working, {"mutation": {"a": "Still"}})
    monkeypatch.setattr(checking, "find_spec", lambda name: None)
    with pytest.raises(GaitsimError, match="needs pytest and pytest-timeout") as raised:
        check("fake")
    assert raised.value.remedy == "pip install 'gaitsim-testing'"


def test_a_package_by_its_name(install, working):
    install("fake_legs", working, {"mutation": {"a": "Still"}, "organism": {"b": "Body"}})
    with select_plugins("Fake-Legs") as found:
        assert [entry.name for entry in found.entries] == ["b", "a"]


LASTING = """
import os
from pathlib import Path
class X(Still):
    def mutate(self, *_):
        Path(os.environ["MARKER"]).write_text(str(os.getpid()))
        while True: pass
"""


def is_alive(number):
    try:
        os.kill(number, 0)
        # A process that has ended is a zombie until its parent waits for it.
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except ProcessLookupError:
        return False
    except FileNotFoundError:  # no /proc, or gone meanwhile
        return not Path("/proc").exists()


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_ends_the_process_of_the_check(install, working, start, tmp_path, monkeypatch):
    folder = install("fake", working + LASTING, {"mutation": {"x": "X"}})
    marker = tmp_path / "marker"
    monkeypatch.setenv("MARKER", str(marker))
    monkeypatch.setenv("PYTHONPATH", str(folder))
    process = start("plugins", "check", "x")
    until(lambda: marker.is_file() and marker.read_text())
    child = int(marker.read_text())
    assert is_alive(child)
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert stderr == ""
    until(lambda: not is_alive(child))

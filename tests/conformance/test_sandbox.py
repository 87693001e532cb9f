"""Plugins are examined in separate processes, whose crashes and hangs become findings."""

import os
import signal
from pathlib import Path

import pytest
from gaitsim.testing.rules.packages import select_plugins
from waiting import until

from gaitsim.errors import PluginError
from gaitsim.testing import check, check_package

LOOPS = "class X(Body):\n    def move(self, genomes):\n        while True: pass\n"


@pytest.mark.slow
def test_after_a_timeout_the_next_plugins_are_examined(install, working):
    points = {"organism": {"loops": "X", "a-sound": "Body"}, "fitness": {"far": "Distance"}}
    install("fake", working + LOOPS, points)
    reports = check_package("fake", seconds=5)
    assert [report.entry.name for report in reports] == ["a-sound", "loops", "far"]
    (finding,) = reports[1].findings
    assert (finding.level, finding.rule) == ("error", "time limit")
    assert finding.actual == "the plugin was still moving populations after 5 s"
    assert reports[0].ok, reports[0]
    assert reports[2].ok, reports[2]


ENDS = {
    "on import": ("import ctypes\nctypes.CDLL(None)._exit(3)\n", "exit code 3"),
    "killed": ("import os, signal\nos.kill(os.getpid(), signal.SIGKILL)\n", "killed by signal 9"),
    "with last words": (
        "import os, sys\nprint('still out of legs', file=sys.stderr, flush=True)\nos.abort()\n",
        "killed by signal 6; still out of legs",
    ),
}


@pytest.mark.sampled
@pytest.mark.parametrize(("source", "says"), ENDS.values(), ids=ENDS.keys())
def test_the_end_of_the_process_is_reported(install, source, says):
    install("fake", source, {"organism": {"x": "X"}})
    (finding,) = check("organism", "x").findings
    assert finding.rule == "process"
    assert says in finding.actual
    assert "importing the plugin" in finding.actual


PRINTS = '''
import os
class X(Still):
    """Still, but loud."""
    def mutate(self, genomes, space, rng):
        print("mutating")
        os.system("echo a child of it")
        return genomes.copy()
'''


@pytest.mark.slow
def test_output_of_a_plugin_is_reported(install, working):
    points = {"mutation": {"loud": "X", "quiet": "Still"}}
    install("fake", working + PRINTS, points)
    loud, quiet = check_package("fake")
    assert loud.ok
    (finding,) = loud.findings
    assert (finding.level, finding.rule) == ("advice", "standard output")
    assert "mutating" in finding.actual
    assert "a child of it" in finding.actual
    assert quiet.findings == ()


HASHES = '''
class X(Body):
    """It goes by the order of a set, which differs from process to process."""
    def move(self, genomes):
        first = next(iter({*"abcdefghijklmnop"}))
        return Motion(1.0, {"distance": genomes.sum(axis=1) * ord(first)})
'''
WORKERS = '''
import os
class X(Body):
    """It looks at the process."""
    def move(self, genomes):
        return Motion(1.0, {"distance": genomes.sum(axis=1) + os.getpid()})
'''


@pytest.mark.sampled
@pytest.mark.parametrize("source", [HASHES, WORKERS])
def test_other_bits_in_another_process_are_found(install, working, source):
    install("fake", working + source, {"organism": {"x": "X"}})
    report = check("organism", "x")
    assert [finding.rule for finding in report.errors] == ["processes"]


def test_an_unknown_name():
    with pytest.raises(PluginError) as raised, select_plugins("spidr"):
        pass
    assert raised.value.remedy == "did you mean 'spider'?"


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


@pytest.mark.sampled
@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_check_that_is_stopped_takes_its_processes_with_it(
    install, working, start, tmp_path, monkeypatch, number
):
    folder = install("fake", working + LASTING, {"mutation": {"x": "X"}})
    marker = tmp_path / "marker"
    monkeypatch.setenv("MARKER", str(marker))
    monkeypatch.setenv("PYTHONPATH", str(folder))
    process = start("plugins", "check", "x")
    until(lambda: marker.is_file() and marker.read_text())
    child = int(marker.read_text())
    assert is_alive(child)
    process.send_signal(number)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode in (130, -signal.SIGKILL)
    assert stderr == ""
    until(lambda: not is_alive(child))

"""The plugin that an interrupt names, and protection of the process from plugins."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from gaitsim.errors import PluginError
from gaitsim.registry import Entry, plugin_errors
from gaitsim.registry.entry_points import guard_process, interrupted_plugin, plugin_context

BODY = Entry("organism", "hopper", "fake:Hopper", "fake", "1.0")
FITNESS = Entry("fitness", "far", "fake:Far", "fake", "1.0")
MOVING = "organism 'hopper' of package fake 1.0 was moving"


@pytest.fixture(autouse=True)
def _no_interrupt_of_another_test():
    interrupted_plugin()


def test_the_innermost_interrupted_plugin_is_named_once():
    with (
        pytest.raises(KeyboardInterrupt),
        plugin_context(FITNESS, "evaluating"),
        plugin_context(BODY, "moving"),
    ):
        raise KeyboardInterrupt
    assert interrupted_plugin() == MOVING
    assert interrupted_plugin() == ""


def test_a_plugin_at_work_in_another_thread_is_named():
    inside, leave = threading.Event(), threading.Event()

    def work():
        with plugin_context(BODY, "moving"):
            inside.set()
            leave.wait(60)

    thread = threading.Thread(target=work)
    thread.start()
    assert inside.wait(60)
    assert interrupted_plugin() == MOVING
    leave.set()
    thread.join()
    assert interrupted_plugin() == ""


def test_threads_enter_and_leave_at_once():
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)

    def work(entry):
        for _ in range(10_000):
            with plugin_context(entry, "moving"):
                pass

    try:
        with ThreadPoolExecutor(8) as threads:
            [*threads.map(work, [BODY, FITNESS] * 4)]
    finally:
        sys.setswitchinterval(before)
    assert interrupted_plugin() == ""


def test_an_exception_is_not_an_interrupt():
    with pytest.raises(ValueError, match="heavy"), plugin_context(BODY, "moving"):
        raise ValueError("heavy")
    assert interrupted_plugin() == ""


@pytest.fixture
def guarded(monkeypatch):
    monkeypatch.setattr(os, "_exit", os._exit)
    guard_process()


def test_a_plugin_does_not_end_the_process(guarded):
    failed = r"'hopper' .* failed while moving: .*os\._exit\(0\)"
    with pytest.raises(PluginError, match=failed), plugin_errors(BODY, "moving"):
        os._exit(0)


@pytest.mark.parametrize("descriptor", [1, 2])
def test_a_plugin_that_closes_an_output_is_refused_and_the_output_opened(guarded, descriptor):
    kept = os.dup(descriptor)
    try:
        closed = f"'hopper' .* closed file descriptor {descriptor} while moving"
        with pytest.raises(PluginError, match=closed), plugin_errors(BODY, "moving"):
            os.close(descriptor)
        os.fstat(descriptor)
    finally:
        os.dup2(kept, descriptor)
        os.close(kept)


FORKS = """
import os
from gaitsim.registry import Entry, plugin_errors
from gaitsim.registry.entry_points import guard_process
guard_process()
with plugin_errors(Entry("organism", "hopper", "fake:Hopper", "fake", "1.0"), "moving"):
    proper = os.fork()
    if not proper:
        os._exit(7)
    copy = os.fork()
print([os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) for child in (copy, proper)])
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_copy_of_the_process_does_not_return_from_a_plugin():
    ran = subprocess.run([sys.executable, "-c", FORKS], capture_output=True, text=True, check=True)
    assert ran.stdout == "[2, 7]\n"
    assert "organism 'hopper' of package fake 1.0 called os.fork" in ran.stderr

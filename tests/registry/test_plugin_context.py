"""Which plugin was at work when the user stopped the program."""

import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from gaitsim.registry import Entry
from gaitsim.registry.plugin_context import interrupted_plugin, plugin_context

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

"""What plugins print is kept apart, by thread; who was stopped is told."""

import sys
import threading

import pytest

from gaitsim.registry.plugin_context import plugin_context, stopped


@pytest.fixture(autouse=True)
def nobody():
    """Who was stopped by another test is forgotten."""
    stopped()


def test_what_is_printed_within_goes_to_standard_error(capsys):
    before = sys.stdout
    print("before")
    with plugin_context("a body", "moving"):
        print("within")
        with plugin_context("its fitness", "evaluating"):
            sys.stdout.writelines(["a ", "b\n"])
        print("still within")
    print("after")
    assert sys.stdout is before
    written = capsys.readouterr()
    assert written.out == "before\nafter\n"
    assert written.err == "within\na b\nstill within\n"


def test_other_threads_print_where_they_always_do(capsys):
    inside, printed = threading.Event(), threading.Event()

    def plugin():
        with plugin_context("a body", "moving"):
            inside.set()
            printed.wait(60)
            print("from the body")

    thread = threading.Thread(target=plugin)
    thread.start()
    assert inside.wait(60)
    print("from the display")
    assert stopped() == "a body was moving"
    printed.set()
    thread.join()
    assert stopped() == ""
    written = capsys.readouterr()
    assert written.out == "from the display\n"
    assert written.err == "from the body\n"


def test_a_stream_that_a_plugin_kept_goes_on_working(capsys):
    with plugin_context("a body", "moving"):
        kept = sys.stdout
    kept.write("later\n")
    kept.flush()
    assert kept.encoding == sys.stdout.encoding
    assert capsys.readouterr().out == "later\n"


def test_an_exception_leaves_all_as_it_was():
    before = sys.stdout
    with pytest.raises(ValueError, match="no"), plugin_context("a body", "moving"):
        raise ValueError("no")
    assert sys.stdout is before
    assert stopped() == ""


def test_who_is_interrupted_is_told_once():
    with (
        pytest.raises(KeyboardInterrupt),
        plugin_context("a run", "going"),
        plugin_context("a body", "moving"),
    ):
        raise KeyboardInterrupt
    assert stopped() == "a body was moving"
    assert stopped() == ""


def test_streams_that_are_closed_are_borne(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    with plugin_context("a body", "moving"):
        print("to nobody", flush=True)

"""Examine plugins in child processes, which may time out or crash."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, replace
from queue import Empty, SimpleQueue
from typing import Any, Self

from gaitsim.errors import GaitsimError
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, Report, error

SECONDS = 120.0  # timeout of a plugin; compiling kernels takes 20 s, more on a busy machine
_END = 10.0  # timeout for a child to end after it closed its output, s
_START = 120.0  # timeout for a child to start, s
_DAY = 86_400


class _NoAnswer(Exception):
    """Raised if the child did not answer in time, or has ended."""

    def __init__(self, rule: str, actual: str, fix: str) -> None:
        self.finding = error(rule, "an examination that ends", actual, fix)


class _Child:
    """A process that examines plugins; it starts with the first question.

    Args:
        path: folders to import from, before those of this process.
        hash_seed: seed of hashes, and so of the order of sets, which must not affect results.
    """

    def __init__(self, path: Sequence[str], hash_seed: int) -> None:
        self._path = [*path, *filter(None, sys.path)]
        self._hash_seed = str(hash_seed)
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: SimpleQueue[dict[str, Any] | None] = SimpleQueue()
        self._doing = ""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def ask(self, entry: Entry, options: Mapping[str, Any], seconds: float, *, again: bool) -> Any:
        """Return the answer to a question.

        Raises:
            _NoAnswer: the child timed out or ended.
        """
        try:
            process = self._process or self._start()
            self._doing = "computing everything in another process" if again else "being examined"
            question = {"entry": asdict(entry), "options": dict(options), "again": again}
            return self._exchange(process, question, seconds)
        except _NoAnswer:
            self._end()
            raise

    def _start(self) -> "subprocess.Popen[bytes]":
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed by _end
        self._process = process = subprocess.Popen(
            # -P: do not import modules from the current folder.
            [sys.executable, "-P", "-m", "gaitsim.testing.sandbox_child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=os.environ | {"PYTHONHASHSEED": self._hash_seed},
            start_new_session=True,  # Ctrl-C must not reach the child
        )
        self._answers = SimpleQueue()
        threading.Thread(target=_listen, args=(process.stdout, self._answers), daemon=True).start()
        self._doing = "starting"
        self._exchange(process, {"path": self._path}, _START)
        return process

    def _exchange(
        self, process: "subprocess.Popen[bytes]", question: Mapping[str, Any], seconds: float
    ) -> dict[str, Any]:
        if process.stdin is not None:
            with suppress(OSError):  # the child has ended; the missing answer reports it
                process.stdin.write(json.dumps(question).encode() + b"\n")
                process.stdin.flush()
        end = time.monotonic() + seconds
        while True:
            try:
                answer = self._answers.get(timeout=max(end - time.monotonic(), 0))
            except Empty:
                raise _NoAnswer(
                    "time limit",
                    f"the plugin was still {self._doing} after {seconds:g} s",
                    "look for an endless loop in this step, or increase --seconds",
                ) from None
            if answer is None:
                fix = "remove all code that ends the process from the plugin"
                raise _NoAnswer("process", self._last_words(process), fix)
            if "doing" not in answer:
                return answer
            self._doing = answer["doing"]

    def _last_words(self, process: "subprocess.Popen[bytes]") -> str:
        """Return how the process ended, and the last part of its standard error."""
        try:
            code = process.wait(_END)
        except subprocess.TimeoutExpired:
            return f"the process closed its output while {self._doing}, and did not end"
        self._errors.seek(0)
        words = self._errors.read()[-300:].decode(errors="replace").strip()
        how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        return f"the process ended while {self._doing}: {how}" + (f"; {words}" if words else "")

    def _end(self) -> None:
        if self._process is None:
            return
        with suppress(ProcessLookupError):
            # The process leads a process group, so its own children are killed, too.
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            with suppress(OSError):  # an unread question
                if stream is not None:
                    stream.close()
        self._process = None


def _listen(stream: Any, answers: "SimpleQueue[dict[str, Any] | None]") -> None:
    with suppress(ValueError):  # the stream was closed when the process was killed
        for line in stream:
            answers.put(json.loads(line))
    answers.put(None)


def watch(
    entries: Sequence[Entry],
    options: Mapping[str, Any] | None = None,
    *,
    seconds: float = SECONDS,
    path: Sequence[str] = (),
) -> Iterator[Report]:
    """Examine plugins one after another, in a process that is killed after a timeout.

    A plugin that passes repeats its computations in a second process, with a different order of
    sets, and with options that were serialised to text, as they are for workers.

    Args:
        entries: entries of the plugins.
        options: options that differ from the defaults.
        seconds: timeout per plugin.
        path: folders to import from first.

    Raises:
        GaitsimError: `seconds` is not a valid timeout.
    """
    if not 0 < seconds <= _DAY:
        raise GaitsimError(
            f"{seconds:g} s is not a valid timeout", allowed=f"above 0 s and at most {_DAY:,} s"
        )
    given = options or {}
    with ExitStack() as stack:
        first, second = (stack.enter_context(_Child(path, seed)) for seed in (1, 2))
        for entry in entries:
            try:
                answer = first.ask(entry, given, seconds, again=False)
            except _NoAnswer as problem:
                yield Report(entry, (problem.finding,))
                continue
            data = answer["report"]
            findings = tuple(Finding(**finding) for finding in data["findings"])
            report = Report(entry, findings, data["figures"], answer["digest"])
            different = report.digest and _compare(second, report, given, seconds)
            yield replace(report, findings=(*findings, different)) if different else report


def _compare(
    child: _Child, report: Report, options: Mapping[str, Any], seconds: float
) -> Finding | None:
    """Return a finding if another process computes different results; None otherwise."""
    try:
        answer = child.ask(report.entry, options, seconds, again=True)
    except _NoAnswer as problem:
        return problem.finding
    if answer.get("digest") == report.digest:
        return None
    return error(
        "processes",
        "the same bits in another process, such as a worker",
        answer.get("failure", "different bits"),
        "depend only on options and genomes: not on the order of a set, on id() or hash(), "
        "the environment, or earlier results",
    )

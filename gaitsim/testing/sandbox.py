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
_EXIT = 10.0  # timeout for a child to exit after it closed its output, s
_START = 120.0  # timeout for a child to start, s
_DAY = 86_400


class _NoResponse(Exception):
    """Raised if the child did not respond in time, or has exited."""

    def __init__(self, rule: str, actual: str, fix: str) -> None:
        self.finding = error(rule, "a check that finishes within the time limit", actual, fix)


class _Child:
    """A process that examines plugins; it is started by the first request.

    Args:
        path: folders to import from, before those of this process.
        hash_seed: value of PYTHONHASHSEED. It determines the order of sets, which must not affect
            results.
    """

    def __init__(self, path: Sequence[str], hash_seed: int) -> None:
        self._path = [*path, *filter(None, sys.path)]
        self._hash_seed = str(hash_seed)
        self._process: subprocess.Popen[bytes] | None = None
        self._responses: SimpleQueue[dict[str, Any] | None] = SimpleQueue()
        self._step = ""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._kill()

    def request(
        self, entry: Entry, options: Mapping[str, Any], seconds: float, *, again: bool
    ) -> Any:
        """Return the response to a request to examine a plugin, or to repeat its computations."""
        try:
            process = self._process or self._start()
            self._step = "computing everything in another process" if again else "being examined"
            request = {"entry": asdict(entry), "options": dict(options), "again": again}
            return self._exchange(process, request, seconds)
        except _NoResponse:
            self._kill()
            raise

    def _start(self) -> "subprocess.Popen[bytes]":
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed by _kill
        self._process = process = subprocess.Popen(
            # -P: do not import modules from the current folder.
            [sys.executable, "-P", "-m", "gaitsim.testing.sandbox_child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=os.environ | {"PYTHONHASHSEED": self._hash_seed},
            start_new_session=True,  # Ctrl-C must not reach the child
        )
        self._responses = SimpleQueue()
        threading.Thread(
            target=_read_responses, args=(process.stdout, self._responses), daemon=True
        ).start()
        self._step = "starting"
        self._exchange(process, {"path": self._path}, _START)
        return process

    def _exchange(
        self, process: "subprocess.Popen[bytes]", request: Mapping[str, Any], seconds: float
    ) -> dict[str, Any]:
        if process.stdin is not None:
            with suppress(OSError):  # the child has exited; the missing response reports it
                process.stdin.write(json.dumps(request).encode() + b"\n")
                process.stdin.flush()
        end = time.monotonic() + seconds
        while True:
            try:
                response = self._responses.get(timeout=max(end - time.monotonic(), 0))
            except Empty:
                raise _NoResponse(
                    "time limit",
                    f"the plugin was still {self._step} after {seconds:g} s",
                    "look for an endless loop in this step, or increase --seconds",
                ) from None
            if response is None:
                fix = "remove all code that ends the process from the plugin"
                raise _NoResponse("process", self._describe_end(process), fix)
            if "doing" not in response:
                return response
            self._step = response["doing"]

    def _describe_end(self, process: "subprocess.Popen[bytes]") -> str:
        """Describe how the process ended, with the end of its standard error."""
        try:
            code = process.wait(_EXIT)
        except subprocess.TimeoutExpired:
            return f"the process closed its output while {self._step}, and did not exit"
        self._errors.seek(0)
        stderr = self._errors.read()[-300:].decode(errors="replace").strip()
        how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        return f"the process ended while {self._step}: {how}" + (f"; {stderr}" if stderr else "")

    def _kill(self) -> None:
        if self._process is None:
            return
        with suppress(ProcessLookupError):
            # The process leads a process group, so its own children are killed, too.
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            with suppress(OSError):  # an unread request
                if stream is not None:
                    stream.close()
        self._process = None


def _read_responses(stream: Any, responses: "SimpleQueue[dict[str, Any] | None]") -> None:
    with suppress(ValueError):  # the stream was closed when the process was killed
        for line in stream:
            responses.put(json.loads(line))
    responses.put(None)


def examine_in_processes(
    entries: Sequence[Entry],
    options: Mapping[str, Any] | None = None,
    *,
    seconds: float = SECONDS,
    path: Sequence[str] = (),
) -> Iterator[Report]:
    """Examine plugins one after another in a process, which is killed after a timeout.

    If a plugin passes, its computations are repeated in a second process, with a different order of
    sets and with serialised options, as in a worker.

    Args:
        entries: entries of the plugins.
        options: options that differ from the defaults.
        seconds: timeout per plugin, s.
        path: folders to import from, before those of this process.
    """
    if not 0 < seconds <= _DAY:
        raise GaitsimError(
            f"invalid timeout: {seconds:g} s", allowed=f"above 0 s and at most {_DAY:,} s"
        )
    options = options or {}
    with ExitStack() as stack:
        first, second = (stack.enter_context(_Child(path, seed)) for seed in (1, 2))
        for entry in entries:
            try:
                response = first.request(entry, options, seconds, again=False)
            except _NoResponse as problem:
                yield Report(entry, (problem.finding,))
                continue
            data = response["report"]
            findings = tuple(Finding(**finding) for finding in data["findings"])
            report = Report(entry, findings, data["figures"], response["digest"])
            different = report.digest and _check_second_process(second, report, options, seconds)
            yield replace(report, findings=(*findings, different)) if different else report


def _check_second_process(
    child: _Child, report: Report, options: Mapping[str, Any], seconds: float
) -> Finding | None:
    """Return a finding if another process computes different results; None otherwise."""
    try:
        response = child.request(report.entry, options, seconds, again=True)
    except _NoResponse as problem:
        return problem.finding
    if response.get("digest") == report.digest:
        return None
    return error(
        "processes",
        "the same bits in a different process, such as a worker",
        response.get("failure", "different bits"),
        "depend only on options and genomes: not on the order of a set, on id() or hash(), "
        "the environment, or earlier results",
    )

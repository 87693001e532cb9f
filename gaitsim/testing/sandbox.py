"""Examinations in child processes, which have a time limit and can be lost."""

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
from types import TracebackType
from typing import Any, Self

from gaitsim.errors import GaitsimError
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, Report, error

SECONDS = 120.0  # for one plugin: compiling its kernels takes up to 20 s, more where others work
_END = 10.0  # s for a child that said its last word to end
_START = 120.0
_DAY = 86_400


class _Lost(Exception):
    """The child did not answer in time, or is gone."""


class _Child:
    """A process that examines; begun when it is first asked.

    Args:
        path: folders to import from, before those of this process.
        hash_seed: of its sets and dicts, whose order must not matter.
    """

    def __init__(self, path: Sequence[str], hash_seed: int) -> None:
        self._path = [*path, *filter(None, sys.path)]
        self._hash_seed = str(hash_seed)
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: SimpleQueue[dict[str, Any] | None] = SimpleQueue()
        self._doing = ""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        problem: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end()

    def ask(self, entry: Entry, options: Mapping[str, Any], seconds: float, *, again: bool) -> Any:
        """The answer to a question.

        Raises:
            _Lost: there is none; says why.
        """
        try:
            if self._process is None:
                self._begin()
            self._doing = "computing it all in another process" if again else "being examined"
            self._send({"entry": asdict(entry), "options": dict(options), "again": again})
            return self._receive(seconds)
        except _Lost:
            self._end()
            raise

    def _begin(self) -> None:
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed by _end
        self._process = subprocess.Popen(
            # -P: what lies in the folder where one happens to be is not imported.
            [sys.executable, "-P", "-m", "gaitsim.testing.sandbox_child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env=os.environ | {"PYTHONHASHSEED": self._hash_seed},
            start_new_session=True,  # Ctrl-C is this process's affair
        )
        self._answers = SimpleQueue()
        threading.Thread(
            target=_listen, args=(self._process.stdout, self._answers), daemon=True
        ).start()
        self._doing = "starting"
        self._send({"path": self._path})
        self._receive(_START)

    def _send(self, question: Mapping[str, Any]) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(question).encode() + b"\n")
            self._process.stdin.flush()
        except OSError:
            raise _Lost(self._last_words()) from None

    def _receive(self, seconds: float) -> dict[str, Any]:
        end = time.monotonic() + seconds
        while True:
            try:
                answer = self._answers.get(timeout=max(end - time.monotonic(), 0))
            except Empty:
                raise _Lost(f"it was still {self._doing} after {seconds:g} s") from None
            if answer is None:
                raise _Lost(self._last_words())
            if "doing" not in answer:
                return answer
            self._doing = answer["doing"]

    def _last_words(self) -> str:
        """How the process ended, and the end of what it wrote to standard error."""
        assert self._process is not None
        try:
            code = self._process.wait(_END)
        except subprocess.TimeoutExpired:
            return f"it closed its output while {self._doing}, and did not end"
        self._errors.seek(0)
        words = self._errors.read()[-300:].decode(errors="replace").strip()
        how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        return f"the process ended while {self._doing}: {how}" + (f"; {words}" if words else "")

    def _end(self) -> None:
        if self._process is None:
            return
        with suppress(ProcessLookupError):
            # With whatever it began itself; it leads a group of its own.
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            if stream is not None:
                stream.close()
        self._process = None


def _listen(stream: Any, answers: "SimpleQueue[dict[str, Any] | None]") -> None:
    try:
        for line in stream:
            answers.put(json.loads(line))
    except ValueError:  # closed, as the process was ended
        pass
    answers.put(None)


def watch(
    entries: Sequence[Entry],
    options: Mapping[str, Any] | None = None,
    *,
    seconds: float = SECONDS,
    path: Sequence[str] = (),
) -> Iterator[Report]:
    """Examine one after the other, each in a process that ends after `seconds`.

    What passes is computed once more in a second process, in which sets have another
    order, from options that went through text, as they do to a worker.

    Args:
        entries: which ones.
        options: their options where they are not the defaults.
        seconds: for each.
        path: folders to import from first.

    Raises:
        GaitsimError: `seconds` is no time limit.
    """
    if not 0 < seconds <= _DAY:
        raise GaitsimError(
            f"{seconds:g} s is no time limit for a plugin", allowed=f"above 0, at most {_DAY:,}"
        )
    given = options or {}
    with ExitStack() as stack:
        first, second = (stack.enter_context(_Child(path, seed)) for seed in (1, 2))
        for entry in entries:
            try:
                answer = first.ask(entry, given, seconds, again=False)
            except _Lost as lost:
                yield Report(entry, (_lost(str(lost)),))
                continue
            report = _read(entry, answer)
            yield report if not report.digest else _compared(second, report, given, seconds)


def _compared(child: _Child, report: Report, given: Mapping[str, Any], seconds: float) -> Report:
    """The report, with a finding where another process computes something else."""
    try:
        answer = child.ask(report.entry, given, seconds, again=True)
    except _Lost as lost:
        return _with(report, _lost(str(lost)))
    if answer.get("digest") == report.digest:
        return report
    return _with(
        report,
        error(
            "processes",
            "the same bits in another process, as workers are",
            answer.get("failure", "others"),
            "depend on options and genomes alone: not on the order of a set, on id() or hash(), "
            "the environment, or what was computed before",
        ),
    )


def _with(report: Report, finding: Finding) -> Report:
    return replace(report, findings=(*report.findings, finding))


def _lost(how: str) -> Finding:
    return error(
        "time limit" if "still" in how else "process",
        "an examination that comes to its end",
        how,
        "look for a loop that does not end where it was at work, or give it more --seconds"
        if "still" in how
        else "let nothing in the plugin end the process",
    )


def _read(entry: Entry, answer: Mapping[str, Any]) -> Report:
    report = answer["report"]
    findings = tuple(Finding(**finding) for finding in report["findings"])
    return Report(entry, findings, report["figures"], answer["digest"])

"""Examine plugins on request; requests and answers are lines of JSON.

`watch` runs this module, `python -m gaitsim.testing.sandbox_child`, as a separate process, because
a plugin may loop endlessly, exit or print. Output of plugins does not mix with the answers, and is
reported as a finding.
"""

import io
import json
import os
import sys
import tempfile
import threading
from dataclasses import replace
from queue import SimpleQueue
from typing import Any, BinaryIO

Questions = SimpleQueue[dict[str, Any]]


def main() -> None:
    """Answer requests until standard input is closed, which also ends the current examination."""
    answers, asked = os.dup(1), os.fdopen(os.dup(0), "rb")
    questions: Questions = SimpleQueue()
    with tempfile.TemporaryFile() as printed, open(os.devnull, "rb") as nothing:  # noqa: PTH123
        os.dup2(nothing.fileno(), 0)
        os.dup2(printed.fileno(), 1)
        threading.Thread(target=_listen, args=(asked, questions), daemon=True).start()
        _answer(questions, answers)


def _listen(asked: BinaryIO, questions: Questions) -> None:
    for line in asked:
        questions.put(json.loads(line))
    os._exit(0)  # the parent has ended


def _answer(questions: Questions, answers: int) -> None:
    sys.path[:0] = [folder for folder in questions.get()["path"] if folder not in sys.path]
    from gaitsim.errors import GaitsimError
    from gaitsim.registry import Entry
    from gaitsim.testing.examine import examine, outcome
    from gaitsim.testing.report import advice

    def send(**answer: Any) -> None:
        os.write(answers, json.dumps(answer).encode() + b"\n")

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # keeps the order with child processes' output
    send(ready=True)
    while True:
        question = questions.get()
        entry, options = Entry(**question["entry"]), question["options"]
        if question["again"]:
            try:
                send(digest=outcome(entry, options))
            except GaitsimError as error:
                send(failure=str(error))
            continue
        report = examine(entry, options, lambda text: send(doing=text))
        text = _printed()
        if text:
            printing = advice(
                "standard output",
                "no output there, because it is reserved for results, such as those of --json",
                f"{text!r}",
                "use the module logging, or print(…, file=sys.stderr)",
            )
            report = replace(report, findings=(*report.findings, printing))
        send(report=report.to_json(), digest=report.digest)


def _printed() -> str:
    """Return the beginning of the output since the last call."""
    if sys.stdout is not None:
        sys.stdout.flush()
    os.lseek(1, 0, os.SEEK_SET)
    text = os.read(1, 200).decode(errors="replace")
    os.ftruncate(1, 0)
    os.lseek(1, 0, os.SEEK_SET)
    return text


if __name__ == "__main__":
    main()

"""Examine plugins on request; requests and responses are lines of JSON.

`examine_in_processes` runs this module, `python -m gaitsim.testing.sandbox_child`, as a separate
process, because a plugin may loop endlessly, exit or print. The output of plugins is kept apart
from the responses, and is reported as a finding.
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

Requests = SimpleQueue[dict[str, Any]]


def main() -> None:
    """Respond to requests until standard input is closed, which also stops an examination."""
    responses, incoming = os.dup(1), os.fdopen(os.dup(0), "rb")
    requests: Requests = SimpleQueue()
    with tempfile.TemporaryFile() as printed, open(os.devnull, "rb") as nothing:  # noqa: PTH123
        os.dup2(nothing.fileno(), 0)
        os.dup2(printed.fileno(), 1)
        threading.Thread(target=_read_requests, args=(incoming, requests), daemon=True).start()
        _respond(requests, responses)


def _read_requests(incoming: BinaryIO, requests: Requests) -> None:
    for line in incoming:
        requests.put(json.loads(line))
    os._exit(0)  # the parent process has exited


def _respond(requests: Requests, responses: int) -> None:
    sys.path[:0] = [folder for folder in requests.get()["path"] if folder not in sys.path]
    from gaitsim.errors import GaitsimError
    from gaitsim.registry import Entry
    from gaitsim.testing.examine import digest_results, examine
    from gaitsim.testing.report import advice

    def send(**response: Any) -> None:
        os.write(responses, json.dumps(response).encode() + b"\n")

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # keeps the order with child processes' output
    send(ready=True)
    while True:
        request = requests.get()
        entry, options = Entry(**request["entry"]), request["options"]
        if request["again"]:
            try:
                send(digest=digest_results(entry, options))
            except GaitsimError as error:
                send(failure=str(error))
            continue
        report = examine(entry, options, lambda text: send(doing=text))
        text = _take_output()
        if text:
            output = advice(
                "standard output",
                "no output there, because it is reserved for results, such as JSON",
                f"{text!r}",
                "use the module logging, or print(…, file=sys.stderr)",
            )
            report = replace(report, findings=(*report.findings, output))
        send(report=report.to_json(), digest=report.digest)


def _take_output() -> str:
    """Return the beginning of the output since the last call, and discard the rest."""
    if sys.stdout is not None:
        sys.stdout.flush()
    os.lseek(1, 0, os.SEEK_SET)
    text = os.read(1, 200).decode(errors="replace")
    os.ftruncate(1, 0)
    os.lseek(1, 0, os.SEEK_SET)
    return text


if __name__ == "__main__":
    main()

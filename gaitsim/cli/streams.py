"""Standard output and error: results apart from whatever plugins print."""

import io
import os
import sys
from contextlib import suppress
from typing import TextIO

from gaitsim.errors import GaitsimError

PROGRESS = "GAITSIM_PROGRESS"

_isolated: list[TextIO] = []


def machine_readable() -> bool:
    """Return whether standard error is JSON lines for programs, see `console`."""
    return os.environ.get(PROGRESS) == "json"


def check_environment() -> None:
    """Refuse a value of `GAITSIM_PROGRESS` that means nothing.

    Raises:
        GaitsimError: it has one.
    """
    value = os.environ.get(PROGRESS, "")
    if value not in ("", "json"):
        raise GaitsimError(f"unknown value {value!r}", where=PROGRESS, allowed="json, or unset")


def prepare() -> None:
    """See that everything can be printed, whatever the terminal's encoding.

    In one that lacks '≥' or '−', such a sign becomes '?' rather than an error. A stream that
    the caller closed swallows what it is given.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
        elif isinstance(stream, io.TextIOWrapper):
            whole = stream.encoding.lower().replace("-", "") == "utf8"
            stream.reconfigure(errors="backslashreplace" if whole else "replace")


def isolate_results() -> None:
    """Write results to a duplicate of descriptor 1 from here on; make 1 standard error.

    It catches everything that plugins print: through any Python stream, from compiled code
    and from child processes. It holds until the process ends. Where `sys.stdout` is not
    descriptor 1, as in a test, nothing changes.
    """
    stdout, stderr = sys.stdout, sys.stderr
    with suppress(OSError):  # neither has a descriptor
        if not _isolated and stdout.fileno() == 1 and isinstance(stdout, io.TextIOWrapper):
            stdout.flush()
            copy = os.dup(1)
            os.dup2(stderr.fileno(), 1)
            _isolated.append(os.fdopen(copy, "w", encoding=stdout.encoding, errors=stdout.errors))
            stdout.reconfigure(line_buffering=True)  # in order with standard error


def results() -> TextIO:
    """Return the stream for results."""
    return _isolated[0] if _isolated else sys.stdout


def finish() -> str:
    """Flush the results; return why they cannot be written, or ''.

    A reader who has gone, as `head` does, is no error.
    """
    if _isolated:
        with suppress(OSError, ValueError):  # closed by a plugin
            sys.stdout.flush()
    try:
        results().flush()
    except OSError as error:
        # Python flushes once more at its end; that goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), results().fileno())
        return "" if isinstance(error, BrokenPipeError) else str(error.strerror)
    return ""

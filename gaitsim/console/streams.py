"""Standard output and error, with results kept apart from the output of plugins."""

import io
import os
import sys
from contextlib import suppress
from typing import TextIO

from gaitsim.errors import GaitsimError

PROGRESS = "GAITSIM_PROGRESS"

_isolated: list[TextIO] = []


def machine_readable() -> bool:
    """Return whether standard error is JSON lines for programs; see `console`."""
    return os.environ.get(PROGRESS) == "json"


def check_environment() -> None:
    """Check the value of `GAITSIM_PROGRESS`; draw without windows, whatever `MPLBACKEND` is."""
    os.environ["MPLBACKEND"] = "agg"
    value = os.environ.get(PROGRESS, "")
    if value not in ("", "json"):
        raise GaitsimError(
            f"invalid {PROGRESS}: {value!r}", where=PROGRESS, allowed="json, or unset"
        )


def prepare() -> None:
    """Make every text printable in any encoding of the terminal.

    Characters that the encoding lacks, such as '≥' or '−', become '?' rather than an error.
    Output to a stream that the caller closed is discarded.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
        elif isinstance(stream, io.TextIOWrapper):
            whole = stream.encoding.lower().replace("-", "") == "utf8"
            stream.reconfigure(errors="backslashreplace" if whole else "replace")


def isolate_results() -> None:
    """Move results to a duplicate of descriptor 1, and redirect descriptor 1 to standard error.

    This diverts everything that plugins print, through any Python stream, from compiled code
    and from child processes, until the process ends. Nothing changes if `sys.stdout` is not
    descriptor 1, as in a test.
    """
    stdout, stderr = sys.stdout, sys.stderr
    with suppress(OSError):  # a stream without a descriptor
        if not _isolated and stdout.fileno() == 1 and isinstance(stdout, io.TextIOWrapper):
            stdout.flush()
            copy = os.dup(1)
            os.dup2(stderr.fileno(), 1)
            _isolated.append(os.fdopen(copy, "w", encoding=stdout.encoding, errors=stdout.errors))
            stdout.reconfigure(line_buffering=True)  # keeps the order with standard error


def results() -> TextIO:
    """Return the stream for results."""
    return _isolated[0] if _isolated else sys.stdout


def finish() -> str:
    """Flush the results; return why they cannot be written, or ''.

    A closed pipe, as left by `head`, is not an error.
    """
    if _isolated:
        with suppress(OSError, ValueError):  # a plugin may have closed it
            sys.stdout.flush()
    try:
        results().flush()
    except OSError as error:
        # Python flushes once more at exit; discard that.
        os.dup2(os.open(os.devnull, os.O_WRONLY), results().fileno())
        return "" if isinstance(error, BrokenPipeError) else str(error.strerror)
    return ""

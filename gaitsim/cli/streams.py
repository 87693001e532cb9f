"""Standard output and error, made fit for what gaitsim prints."""

import io
import os
import sys

from gaitsim.errors import GaitsimError

PROGRESS = "GAITSIM_PROGRESS"


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


def finish() -> str:
    """Write out what waits; why it cannot be written, or ''.

    A reader who has gone, as `head` does, is no error.
    """
    try:
        sys.stdout.flush()
    except OSError as error:
        # Python flushes once more at its end; that goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return "" if isinstance(error, BrokenPipeError) else str(error.strerror)
    return ""

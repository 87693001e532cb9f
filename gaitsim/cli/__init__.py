"""The command line: one file a command, imported when that command is used."""

import errno
import gc
import sys
from contextlib import suppress

from gaitsim.errors import GaitsimError

MISTAKE, INTERRUPTED = 2, 130


def main() -> None:
    """Run the command line; a user's mistake ends with one message and exit code 2."""
    from gaitsim.cli import streams

    # Imports leave no cycles to collect; looking for them takes a sixth of the start-up.
    gc.disable()
    streams.prepare()
    try:
        _run()
    except SystemExit:
        reason = streams.finish()
        if reason:
            _fail(GaitsimError(f"cannot write the output: {reason}"))
        raise
    finally:
        # Python looks for cycles among all that was imported once more before it ends: 30 of
        # the 205 ms that --help takes.
        gc.freeze()
        gc.enable()


def _run() -> None:
    from gaitsim.cli import streams

    try:
        streams.check_environment()
        # Within, as half of the start-up is spent on it, and Ctrl-C may come then.
        from gaitsim.cli.app import app

        app()
    except GaitsimError as error:
        _fail(error)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        streams.finish()  # which could not be written either, and would be reported again
        _fail(GaitsimError(f"cannot write: {error.strerror}"))


def _fail(error: GaitsimError) -> None:
    from gaitsim.cli.console import errors, record
    from gaitsim.cli.streams import machine_readable

    with suppress(OSError):  # standard error is closed, by a plugin perhaps
        if machine_readable():
            record("error", **error.to_dict())
        else:
            errors().print(f"Error: {error}", style="red")
    sys.exit(MISTAKE)

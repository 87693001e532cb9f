"""The command line: commands are generated from their actions when they are used."""

import errno
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gaitsim.console import INTERRUPTED, MISTAKE
from gaitsim.errors import GaitsimError


def main() -> None:
    """Run the command line; a user's error prints one message and exits with code 2."""
    from gaitsim.console import streams

    # Imports leave no cycles to collect; searching for them takes a sixth of the start-up time.
    gc.disable()
    # Looking for plugins of pydantic among all installed packages takes 20 ms.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    streams.prepare()
    try:
        with _reported():
            streams.check_environment()
            # This import takes half of the start-up time, so Ctrl-C during it is handled here, too.
            from gaitsim.cli.app import app

            app()
    except SystemExit:
        reason = streams.finish()
        if reason:
            _fail(GaitsimError(f"cannot write the output: {reason}"))
        raise
    finally:
        # Exclude all imported objects from the final collection, which takes 30 of the 205 ms of
        # --help.
        gc.freeze()
        gc.enable()


@contextmanager
def _reported() -> Iterator[None]:
    """Exit with a message for a user's error in the block, and silently after Ctrl-C."""
    try:
        yield
    except GaitsimError as error:
        _fail(error)
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        from gaitsim.console import streams

        streams.finish()  # or the same error would be reported again at exit
        _fail(GaitsimError(f"cannot write: {error.strerror}"))


def _fail(error: GaitsimError) -> None:
    from gaitsim.console.printing import errors, print_record
    from gaitsim.console.streams import machine_readable

    with suppress(OSError):  # a plugin may have closed standard error
        if machine_readable():
            print_record("error", **error.to_dict())
        else:
            errors().print(f"Error: {error}", style="red")
    sys.exit(MISTAKE)

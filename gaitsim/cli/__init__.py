"""The command line. One file a command; heavy imports wait until a command needs them."""

import sys

from gaitsim.errors import GaitsimError


def main() -> None:
    """Run the command line; a user's mistake ends with one message and exit code 2."""
    from gaitsim.cli.app import app

    try:
        app()
    except GaitsimError as error:
        from gaitsim.cli.console import errors

        errors().print(f"Error: {error}", style="red", markup=False, highlight=False)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)

"""The time of `gaitsim --help`, compared with Python and the libraries that it must import."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from timing import medians, milliseconds, print_figure, print_machine, times

REPEATS = 2  # in each of five rounds


def program(*command: str) -> Callable[[], object]:
    """Return a function that runs a program, which must exit with code 0."""
    return lambda: subprocess.run(command, check=True, capture_output=True)


def main() -> None:
    """Print the figures."""
    print_machine()
    python = sys.executable
    ours, help_, libraries, bare = medians(
        program(str(Path(python).with_name("gaitsim")), "--help"),
        program(python, "-c", "import typer.rich_utils"),
        program(python, "-c", "import typer, rich"),
        program(python, "-c", "pass"),
        repeats=REPEATS,
    )
    print_figure("gaitsim --help", milliseconds(ours))
    for what, seconds in (
        ("import typer.rich_utils", help_),  # the module with which typer prints help
        ("import typer, rich", libraries),
        ("pass", bare),
    ):
        print_figure(
            f"python -c '{what}'",
            milliseconds(seconds),
            f"gaitsim: {times(ours / seconds)} as long",
        )


if __name__ == "__main__":
    main()

"""Checks of a command: its name is free, and it prints its help."""

import os
import subprocess
import sys

from gaitsim.plugin import Entry
from gaitsim_testing.finding import require

KINDS = ("command",)


def test_command(entry: Entry) -> None:
    """Gaitsim has no command of this name, and the command prints its help."""
    path = os.pathsep.join(filter(None, sys.path))
    # A command with the name of one of gaitsim's own is listed with its package.
    refused = _run([f"{entry.name} ({entry.package})"], path)
    require(
        "gaitsim itself has" not in refused,
        "gaitsim itself has a command of this name, which takes precedence",
        "a name of its own",
        "choose another name in the entry points",
    )
    wrong = _run(entry.name.split("."), path)
    require(not wrong, wrong, "a function for Typer, or a subclass of Action", "correct it")


def _run(command: list[str], path: str) -> str:
    """Return what `--help` of a command prints to standard error; '' if it succeeds."""
    done = subprocess.run(
        [sys.executable, "-P", "-m", "gaitsim", *command, "--help"],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stderr.strip() or f"exit code {done.returncode}" if done.returncode else ""

"""Commands printed in the documentation: in blocks, tables and sentences, and in `--help`."""

import re
import shlex
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import typer

from gaitsim.cli.app import app
from gaitsim.cli.help import LazyGroup

PRINTED = re.compile(
    r"^```(?P<language>\w*)(?: title=\"(?P<file>[^\"]+)\")?\n(?P<block>.*?)^```$"
    r"|(?<!`)`(?P<inline>gaitsim [^`]+)`(?!`)",
    re.DOTALL | re.MULTILINE,
)
PLACEHOLDER = re.compile(r"…|\b[A-Z]+\b")
"""Placeholder that the reader replaces, as in `gaitsim play RUN`."""


GAITSIM = typer.main.get_command(app)
load = cache(LazyGroup.load)


class Step(NamedTuple):
    """Instruction on a page: a line for a shell, or a file to write."""

    text: str
    file: str = ""


def steps(text: str) -> Iterator[Step]:
    """Yield the instructions of a page, in order, from blocks, tables and sentences."""
    for found in PRINTED.finditer(text):
        if found["file"]:
            yield Step(found["block"], found["file"])
        elif found["inline"]:
            command = " ".join(found["inline"].split())
            if not PLACEHOLDER.search(command) and has_arguments(command):
                yield Step(command)
        elif found["language"] in ("sh", "console"):
            lines = re.sub(r" *\\\n *", " ", found["block"]).splitlines()
            if found["language"] == "console":
                lines = [line[2:] for line in lines if line.startswith("$ ")]
            lines = [line for line in lines if not re.search("…|⇥|^ *$", line)]
            yield from (Step(part.strip()) for line in lines for part in line.split(" && "))


def examples(text: str) -> Iterator[Step]:
    """Yield the examples in the help of a command."""
    for line in re.findall(r"^ *((?:\w.* )?gaitsim .*)", text.partition("[bold]Example")[2], re.M):
        if "…" not in line:
            yield Step(line)


def helps(group: LazyGroup = GAITSIM, words: str = "gaitsim") -> Iterator[tuple[str, str]]:
    """Yield the words and the help of each command, with those of packages."""
    for name in group.list_commands(None):
        command = load(group, name)
        if isinstance(command, LazyGroup):
            yield from helps(command, f"{words} {name}")
        else:
            yield f"{words} {name}", command.callback.__doc__ or ""


def has_arguments(command: str) -> bool:
    """Return whether a command in a sentence has arguments, or is just its name."""
    try:
        return parse(command)
    except Exception as error:  # typer has a click of its own, and other mistakes are for tests
        return type(error).__name__ not in ("MissingParameter", "BadOptionUsage")


def parse(line: str) -> bool:
    """Parse the gaitsim commands in a shell line; return whether one has arguments."""
    given = False
    for part in re.split(r"\s(?:[|>]|2>|&&)(?:\s|$)", line.partition(" # ")[0]):
        arguments = part.partition("gaitsim ")[2]
        command, rest = GAITSIM, shlex.split(arguments)
        if not rest or rest[0].startswith("-"):
            continue  # another program, or options of gaitsim itself
        while isinstance(command, LazyGroup) and rest:
            command, rest = load(command, rest[0]), rest[1:]
        given |= bool(rest)
        command.make_context("gaitsim", rest)
    return given

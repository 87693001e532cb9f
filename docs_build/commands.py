"""The command reference, generated from the commands' signatures and help texts."""

import html
import inspect
import re
import types
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from typer.main import get_command
from typer.models import ArgumentInfo, OptionInfo

from gaitsim.cli.app import app
from gaitsim.cli.help import LazyGroup

HEAD = """# Commands

This page is generated from the commands; `gaitsim COMMAND --help` prints the same text. An
invalid command prints one message with the error, its place, the allowed values and a remedy, and
exits with code 2. After Ctrl-C, the exit code is 130.
"""
TYPES = {int: "N", float: "NUMBER", Path: "PATH", str: "TEXT"}


def page() -> str:
    """Return the page in Markdown: all commands with arguments, options, defaults and examples."""
    parts = [HEAD]
    group = get_command(app)
    assert isinstance(group, LazyGroup)
    for name, function in commands(group, "gaitsim"):
        parts += _command(name, function)
    return "\n".join(parts) + "\n"


def commands(group: LazyGroup, name: str) -> Iterator[tuple[str, Callable[..., Any]]]:
    """Yield the full name and the function of each command in a group and its subgroups."""
    for word in group.places:
        command = group.load(word)
        if isinstance(command, LazyGroup):
            yield from commands(command, f"{name} {word}")
        else:
            yield f"{name} {word}", inspect.unwrap(command.callback)


def _command(name: str, function: Callable[..., Any]) -> Iterator[str]:
    about, _, examples = inspect.cleandoc(function.__doc__ or "").partition("[bold]Example")
    rows = [_Row(one) for one in inspect.signature(function, eval_str=True).parameters.values()]
    arguments = [row for row in rows if isinstance(row.info, ArgumentInfo)]
    options = [row for row in rows if isinstance(row.info, OptionInfo) and not row.info.hidden]
    usage = [name, *(["[OPTIONS]"] if options else []), *(row.metavar for row in arguments)]
    yield f"## {name}\n\n{_plain(about)}\n\n```text\n{' '.join(usage)}\n```\n"
    if arguments:
        yield "| argument | meaning |\n| --- | --- |"
        yield from (f"| {_code(row.metavar)} | {row.meaning} |" for row in arguments)
        yield ""
    if options:
        defaults = any(row.default for row in options)
        yield "| option | meaning |" + (" default |" if defaults else "")
        yield "| --- | --- |" + (" --- |" if defaults else "")
        for row in options:
            yield f"| {row.names} | {row.meaning} |" + (f" {row.default} |" if defaults else "")
        yield ""
    lines = [line.strip() for line in examples.splitlines()[1:] if line.strip()]
    if lines:
        yield "```sh\n" + "\n".join(lines) + "\n```\n"


class _Row:
    """A parameter of a command's function, as a row of a table."""

    def __init__(self, parameter: inspect.Parameter) -> None:
        self._parameter = parameter
        annotated = typing.get_args(parameter.annotation)
        self._type = _bare(annotated[0])
        self.info: Any = annotated[1]

    @property
    def metavar(self) -> str:
        if self.info.metavar:
            word = str(self.info.metavar)
        elif isinstance(self.info, ArgumentInfo):
            word = self._parameter.name.upper()
        elif typing.get_origin(self._type) is typing.Literal:
            word = "|".join(typing.get_args(self._type))
        else:
            word = TYPES.get(self._type, "")
        optional = isinstance(self.info, ArgumentInfo) and self._parameter.default is None
        return f"[{word}]" if optional else word

    @property
    def names(self) -> str:
        # Typer stores the first declared name as the default.
        declared = [self.info.default, *(self.info.param_decls or ())]
        names = [name for name in declared if isinstance(name, str)]
        flag = self._type is bool
        if not names:
            word = self._parameter.name.replace("_", "-")
            names = [f"--{word}", f"--no-{word}"] if flag else [f"--{word}"]
        code = ", ".join(map(_code, names))
        return code if flag or not self.metavar else f"{code} {_escaped(self.metavar)}"

    @property
    def meaning(self) -> str:
        # A blank line would end the table.
        return _escaped(_plain(self.info.help or "")).replace("\n\n", "<br>")

    @property
    def default(self) -> str:
        default = self._parameter.default
        if default is inspect.Parameter.empty:
            return "required"
        if default is None or default is False:
            return ""
        return _code("on" if default is True else str(default))


def _bare(annotation: Any) -> Any:
    """Return the type of a single value, such as str for `list[str] | None`."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        annotation = next(one for one in typing.get_args(annotation) if one is not type(None))
    return typing.get_args(annotation)[0] if typing.get_origin(annotation) is list else annotation


def _plain(text: str) -> str:
    """Return a help text without Rich's markup."""
    return re.sub(r"\[/?(bold|italic|dim)\]", "", text).strip()


def _escaped(text: str) -> str:
    return html.escape(text, quote=False).replace("|", "&#124;")


def _code(text: str) -> str:
    return f"<code>{_escaped(text)}</code>"

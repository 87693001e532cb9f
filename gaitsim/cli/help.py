"""StyledCommand groups that import lazily, and the style of `--help` and of usage errors."""

import gc
import inspect
import re
import sys
from collections.abc import Collection, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, ClassVar, get_args

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from gaitsim.console import streams
from gaitsim.errors import GaitsimError, nearest

SCREENS = ("tui", "serve")
"""Commands whose standard output is a screen or the log of a server."""

PLACEHOLDERS = {
    "int": "N",
    "int range": "N",
    "float": "NUMBER",
    "float range": "NUMBER",
    "path": "FILE",
    "str": "TEXT",
}
"""Placeholders of values in the help, by Typer's name of the type."""

_EXAMPLES = "[bold]Example"
_UNUSED = ("rich.markdown", "rich.traceback")


class StyledCommand(TyperCommand):
    """A command with gaitsim's style of help and errors."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.help = arrange_help(self.help or "")

    def get_params(self, ctx: Any) -> Any:
        """Return the parameters, with one style of placeholders."""
        return set_placeholders(super().get_params(ctx), ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line, without Typer's braces around arguments."""
        pieces = super().collect_usage_pieces(ctx)
        return [re.sub(r"^\{(.*)\}", r"\1", piece) for piece in pieces]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        import_rich_utils()
        super().format_help(ctx, formatter)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line."""
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter as error:
            explanation = explain_error(error, self.callback)
            if explanation is None:
                raise
            raise explanation from None

    def invoke(self, ctx: Any) -> Any:
        """Run the command, keeping its results apart from the output of plugins."""
        if self.name not in SCREENS:
            streams.isolate_results()
        if not gc.isenabled():  # `main` disabled it for the imports
            # Excludes what is imported so far from collections: 70 of 850 ms of `gaitsim show`.
            gc.freeze()
            gc.enable()
        return super().invoke(ctx)


class LazyGroup(TyperGroup):
    """A group that imports the module of a command only when that command is used.

    Until then, a stub with one line of help represents it, which suffices for the group's help,
    completion and suggestions.

    Attributes:
        package: package of the commands. Its module `name` holds the function `name` (or
            `name_`, if Python uses the name), or the Typer app `app` of a nested group.
        lines: one line of help by command name, equal to the start of the command's docstring.
        actions: commands that are generated from `ACTION` in the module of their name in
            `gaitsim.actions`.
    """

    package: ClassVar[str]
    lines: ClassVar[Mapping[str, str]]
    actions: ClassVar[Collection[str]]

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.commands = {name: TyperCommand(name, help=line) for name, line in self.lines.items()}

    def get_params(self, ctx: Any) -> Any:
        """Return the parameters, with one style of placeholders."""
        return set_placeholders(super().get_params(ctx), ctx)

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        import_rich_utils()
        super().format_help(ctx, formatter)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name, the command and its arguments; import the command."""
        name, stub, rest = super().resolve_command(ctx, args)
        return name, stub and self.load(str(name)), rest

    def load(self, name: str) -> Any:
        """Import a command, or generate it from the model of an action."""
        if name in self.actions:
            from gaitsim.cli.generate import command

            found: dict[str, Any] = {name: command(import_module(f"gaitsim.actions.{name}").ACTION)}
        else:
            found = vars(import_module(f"{self.package}.{name}"))
        app = found.get("app")
        if app is None:
            app = typer.Typer(rich_markup_mode="rich", add_completion=False)
            app.command(name, cls=StyledCommand)(found.get(name) or found[f"{name}_"])
        return get_command(app)


def group(
    package: str, lines: Mapping[str, str], actions: Collection[str] = (), **settings: Any
) -> typer.Typer:
    """Return the Typer app for the commands of a package; see `LazyGroup`."""
    values = {"package": package, "lines": lines, "actions": actions}
    kind = type("Group", (LazyGroup,), values)
    return typer.Typer(cls=kind, no_args_is_help=True, **settings)


def import_rich_utils() -> None:
    """Import `typer.rich_utils` without its parsers of Markdown and source code.

    Typer needs them for Markdown help and coloured tracebacks, which gaitsim does not use.
    Skipping them saves 40 of the 110 ms of CPU time of `gaitsim --help`.
    """
    placeholders = {name: _Placeholder(name) for name in _UNUSED if name not in sys.modules}
    sys.modules.update(placeholders)
    try:
        import typer.rich_utils  # noqa: F401
    finally:
        for name in placeholders:
            del sys.modules[name]


class _Placeholder(ModuleType):
    """A module in which every name is an empty class."""

    def __getattr__(self, name: str) -> type:
        return type(name, (), {})


def arrange_help(text: str) -> str:
    """Join the lines of each paragraph, and put the examples on consecutive lines.

    Typer keeps the line breaks of docstrings, which are wider than a terminal.
    """
    before, mark, after = text.partition(_EXAMPLES)
    paragraphs = [" ".join(part.split()) for part in before.split("\n\n")]
    lines = [line.strip() for line in after.splitlines() if line.strip()]
    return "\n\n".join(paragraphs) + mark + "\n".join(lines)


def set_placeholders(parameters: list[Any], ctx: Any) -> list[Any]:
    """Replace Typer's value types in the help by placeholders, in place; return all parameters.

    Flags show none, and arguments only their name.
    """
    for parameter in parameters:
        if parameter.param_type_name == "argument":
            parameter.display_type_rich = _no_type
        elif parameter.metavar is None and getattr(parameter, "is_flag", False):
            parameter.metavar = ""
        elif parameter.metavar is None and hasattr(parameter, "display_type"):
            shown = parameter.display_type(ctx).strip("<>")
            parameter.metavar = PLACEHOLDERS.get(shown, shown)
    return parameters


def _no_type(ctx: Any) -> None:
    """Return no type, for the help of an argument."""


def explain_error(error: typer.BadParameter, command: Any) -> GaitsimError | None:
    """Return a GaitsimError that replaces pydantic's error about a value; None for other errors."""
    from pydantic import Field, ValidationError

    from gaitsim.registry.options import allowed, string_choices

    cause, parameter = error.__cause__, error.param
    if not isinstance(cause, ValidationError) or parameter is None:
        return None
    declared = inspect.signature(command, eval_str=True).parameters[str(parameter.name)].annotation
    annotation, info = get_args(declared)
    field = Field(ge=info.min, le=info.max)
    field.annotation = annotation
    (wrong, *_) = cause.errors()
    value, known = wrong["input"], string_choices(field)
    names = " or ".join(parameter.opts)
    return GaitsimError(
        f"invalid {names}: {value!r}",
        where=names,
        allowed=", ".join(known) or allowed(field),
        remedy=nearest(str(value), known),
    )

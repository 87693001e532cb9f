"""Groups that import a command when it is used; the style of `--help` and of usage errors."""

import gc
import inspect
import sys
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, ClassVar, get_args

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from gaitsim.cli import streams
from gaitsim.errors import GaitsimError, nearest

SCREENS = ("tui", "serve")
"""The commands whose standard output is a screen, or a server's log."""

_EXAMPLES = "[bold]Example"
_UNUSED = ("rich.markdown", "rich.traceback")


class Command(TyperCommand):
    """A command whose help and errors are in the house style."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.help = arranged(self.help or "")

    def get_params(self, ctx: Any) -> Any:
        """Return the parameters, flags without '<bool>'."""
        return without_flag_types(super().get_params(ctx))

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        import_rich_utils()
        super().format_help(ctx, formatter)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line.

        Raises:
            GaitsimError: a value is not allowed.
        """
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter as error:
            explanation = explained(error, self.callback)
            if explanation is None:
                raise
            raise explanation from None

    def invoke(self, ctx: Any) -> Any:
        """Run the command, its results apart from whatever plugins print."""
        if self.name not in SCREENS:
            streams.isolate_results()
        gc.enable()  # after the imports, see `main`
        return super().invoke(ctx)


class LazyGroup(TyperGroup):
    """A group that imports the module of a command only when that command is used.

    Until then a stub with one line of help stands for it, which is all that the group's own
    help, completion and suggestions need.

    Attributes:
        package: the package of the commands. The module `name` in it holds the function
            `name`, or `name_` where Python has such a name already; or, for a group, the
            Typer app `app`.
        lines: one line of help by the name of each command, as its docstring begins.
    """

    package: ClassVar[str]
    lines: ClassVar[Mapping[str, str]]

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.commands = {name: TyperCommand(name, help=line) for name, line in self.lines.items()}

    def get_params(self, ctx: Any) -> Any:
        """Return the parameters, flags without '<bool>'."""
        return without_flag_types(super().get_params(ctx))

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        import_rich_utils()
        super().format_help(ctx, formatter)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name, the command and its arguments; import the command."""
        name, stub, rest = super().resolve_command(ctx, args)
        return name, stub and self.load(str(name)), rest

    def load(self, name: str) -> Any:
        """Import a command."""
        found = vars(import_module(f"{self.package}.{name}"))
        app = found.get("app")
        if app is None:
            app = typer.Typer(rich_markup_mode="rich", add_completion=False)
            app.command(name, cls=Command)(found.get(name) or found[f"{name}_"])
        return get_command(app)


def group(package: str, lines: Mapping[str, str], **settings: Any) -> typer.Typer:
    """Return the Typer app of a group of the commands in a package, see `LazyGroup`."""
    kind = type("Group", (LazyGroup,), {"package": package, "lines": lines})
    return typer.Typer(cls=kind, no_args_is_help=True, **settings)


def import_rich_utils() -> None:
    """Import what typer prints help with, but not the parsers of Markdown and of source code.

    It imports them for help in Markdown and for tracebacks in colour, which gaitsim has neither
    of: 40 of the 110 ms of CPU time that `gaitsim --help` takes.
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


def arranged(text: str) -> str:
    """Put the examples of a docstring on consecutive lines."""
    before, mark, after = text.partition(_EXAMPLES)
    lines = [line.strip() for line in after.splitlines() if line.strip()]
    return before + mark + "\n".join(lines)


def without_flag_types(parameters: list[Any]) -> list[Any]:
    """Clear the value's name of parameters that take none, and return all of them."""
    for parameter in parameters:
        if getattr(parameter, "is_flag", False) and parameter.metavar is None:
            parameter.metavar = ""
    return parameters


def explained(error: typer.BadParameter, command: Any) -> GaitsimError | None:
    """Return an error in place of pydantic's about a value; None for other errors."""
    from pydantic import Field, ValidationError

    from gaitsim.registry.options import allowed, words

    cause, parameter = error.__cause__, error.param
    if not isinstance(cause, ValidationError) or parameter is None:
        return None
    declared = inspect.signature(command).parameters[str(parameter.name)].annotation
    annotation, info = get_args(declared)
    field = Field(ge=info.min, le=info.max)
    field.annotation = annotation
    (wrong, *_) = cause.errors()
    value, known = wrong["input"], words(field)
    kind = {"int_parsing": "not a whole number", "float_parsing": "not a number"}.get(wrong["type"])
    return GaitsimError(
        f"{value!r} is {kind or 'not allowed'}",
        where=" or ".join(parameter.opts),
        allowed=", ".join(known) or allowed(field),
        remedy=nearest(str(value), known),
    )

"""Groups of commands that are imported when used, and the style of `--help` and usage errors."""

import gc
import inspect
import re
import sys
from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, get_args

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from gaitsim.console import streams
from gaitsim.errors import GaitsimError, PluginError, nearest

if TYPE_CHECKING:
    from gaitsim.registry import Entry

PLACEHOLDERS = {
    "int": "N",
    "int range": "N",
    "float": "NUMBER",
    "float range": "NUMBER",
    "path": "FILE",
    "str": "TEXT",
}
"""Placeholders of values in the help, by Typer's name of the type."""

Places = Mapping[str, "str | tuple[str, Places]"]
"""Places of commands by name: the action as 'module:class', relative to `gaitsim.actions`; or, of a
nested group, its line of help and the places of its commands."""

_EXAMPLES = "[bold]Example"
_UNUSED = ("rich.markdown", "rich.traceback")


class _StyledHelp:
    """The style of the help of commands and groups."""

    def get_params(self, ctx: Any) -> Any:
        """Return the parameters, with one style of placeholders."""
        return set_placeholders(super().get_params(ctx), ctx)  # type: ignore[misc]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Print the help."""
        import_rich_utils()
        super().format_help(ctx, formatter)  # type: ignore[misc]


class StyledCommand(_StyledHelp, TyperCommand):
    """A command with gaitsim's style of help and errors."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.help = arrange_help(self.help or "")

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line, without Typer's braces around arguments."""
        pieces = super().collect_usage_pieces(ctx)
        return [re.sub(r"^\{(.*)\}", r"\1", piece) for piece in pieces]

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
        # A function sets `keeps_stdout` if its standard output is a screen or the log of a server.
        if not getattr(self.callback, "keeps_stdout", False):
            streams.isolate_results()
        if not gc.isenabled():  # `main` disabled it for the imports
            # Excludes what is imported so far from collections: 70 of 850 ms of `gaitsim show`.
            gc.freeze()
            gc.enable()
        return super().invoke(ctx)


class LazyGroup(_StyledHelp, TyperGroup):
    """A group that imports the module of a command only when that command is used.

    Until then, a stub with one line of help represents it, which suffices for the group's help,
    completion and suggestions. The line is read from the source of the command.

    Attributes:
        places: places of the commands; those without a place are entry points of packages.
        extensible: whether packages can add commands.
        prefix: start of the names of entry points of a nested group, such as 'robots.'.
    """

    places: ClassVar[Places]
    extensible: ClassVar[bool]
    prefix: ClassVar[str]

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.commands = {name: TyperCommand(name) for name in self.places}

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the name, the command and its arguments; import the command.

        Raises:
            PluginError: a package of gaitsim that is not installed provides the command.
        """
        from gaitsim.registry import COMMANDS
        from gaitsim.registry.entry_points import install_hint

        known = not args or self.get_command(ctx, args[0]) is not None
        if not known and (hint := install_hint(COMMANDS, self.prefix + args[0])):
            words = f"{self.prefix.replace('.', ' ')}{args[0]}"
            raise PluginError(f"the command '{words}' is not installed", remedy=hint)
        name, stub, rest = super().resolve_command(ctx, args)
        return name, stub and self.load(str(name)), rest

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of all commands, those that packages add last; read their lines."""
        from gaitsim.registry import COMMANDS, Entry
        from gaitsim.registry.loading import summary

        for name, place in self.places.items():
            self.commands[name].help = (
                summary(Entry(COMMANDS, name, _target(place), "gaitsim", ""))
                if isinstance(place, str)
                else place[0]
            )
        self._add_commands_of_packages()
        return super().list_commands(ctx)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the stub of a command; None for an unknown one."""
        if cmd_name not in self.commands:
            self._add_commands_of_packages()
        return super().get_command(ctx, cmd_name)

    def load(self, name: str) -> Any:
        """Generate a command from the model of its action; build a nested group."""
        place = self.places.get(name)
        if place is None:
            self._add_commands_of_packages()
            function = self._import_from_package(self.prefix + name)
            place = function or (self.commands[name].help or "", {})
        if isinstance(place, tuple):
            line, places = place
            settings: dict[str, Any] = {"help": line, "callback": _no_options}
            prefix = f"{self.prefix}{name}."
            nested = group(places, extensible=True, prefix=prefix, add_completion=False, **settings)
            return get_command(nested)
        if isinstance(place, str):
            module, _, attribute = _target(place).partition(":")
            function = getattr(import_module(module), attribute)
        if isinstance(function, type):
            from gaitsim.cli.generate import command

            function = command(function)
        app = typer.Typer(rich_markup_mode="rich", add_completion=False)
        app.command(name, cls=StyledCommand)(function)
        return get_command(app)

    def _refused(self) -> "dict[str, Entry]":
        """Return packages' commands with names of gaitsim's own, by their name in the help."""
        from gaitsim.registry import COMMANDS, entries

        claims = [claim for name, found in entries(COMMANDS).items() for claim in found]
        own = {self.prefix + name for name in self.places}
        return {f"{one.name} ({one.package})": one for one in claims if one.name in own}

    def _add_commands_of_packages(self) -> None:
        """Add a stub for each command that packages add; its line is its error if it has one."""
        from rich.markup import escape

        from gaitsim.registry import COMMANDS, entries

        if not self.extensible:
            return
        found = [name for name in entries(COMMANDS) if name.startswith(self.prefix)]
        names = [name.removeprefix(self.prefix).partition(".")[0] for name in found]
        for name in (*dict.fromkeys(names), *self._refused()):
            if name not in self.commands:
                line = escape(self._line(self.prefix + name))
                self.commands[name] = TyperCommand(name, help=line)

    def _line(self, name: str) -> str:
        """Return the line of help of a command or group that a package adds, or its error."""
        from gaitsim.registry import COMMANDS, find
        from gaitsim.registry.loading import summary

        try:
            if name not in self._refused() and (line := summary(find(COMMANDS, name))):
                return line
            doc = inspect.getdoc(self._import_from_package(name)) or ""
        except GaitsimError as error:
            return error.what
        return " ".join(doc.partition("\n\n")[0].split())

    def _import_from_package(self, name: str) -> Any:
        """Return the function or action of a command that is an entry point; None for a group."""
        from gaitsim.registry import COMMANDS, entries, find
        from gaitsim.registry.loading import load_object

        if refused := self._refused().get(name):
            raise PluginError(
                f"{refused} cannot be used: gaitsim itself has a command of this name",
                where=refused.target,
                remedy=f"ask the author of {refused.package} to choose another name",
            )
        if any(one.startswith(f"{name}.") for one in entries(COMMANDS)):
            return None
        entry = find(COMMANDS, name)
        found = load_object(entry)
        if not (inspect.isfunction(found) or _is_action(found)):
            raise PluginError(
                f"{entry} is neither a function nor an action, but a {type(found).__name__}",
                where=entry.target,
                allowed="a function for Typer, or a subclass of gaitsim.plugin.Action",
                remedy=f"correct the entry point in the pyproject.toml of {entry.package}",
            )
        return found


def _is_action(found: object) -> bool:
    """Return whether an object is the model of an action; only classes need the import."""
    if not isinstance(found, type):
        return False
    from gaitsim.actions.action import Action

    return issubclass(found, Action)


def _target(place: str) -> str:
    """Return the place of an action as an absolute 'module:class'."""
    return place if place.startswith("gaitsim") else f"gaitsim.actions.{place}"


def group(
    places: Places, *, extensible: bool = False, prefix: str = "", **settings: Any
) -> typer.Typer:
    """Return the Typer app for a group of commands; see `LazyGroup`."""
    values = {"places": places, "extensible": extensible, "prefix": prefix}
    kind = type("Group", (LazyGroup,), values)
    return typer.Typer(cls=kind, no_args_is_help=True, **settings)


def _no_options() -> None:
    """Take the options of a nested group, which has none."""


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

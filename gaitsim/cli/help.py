"""Commands in the house style: how `--help` looks, and what is said of a wrong value."""

from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from gaitsim.errors import GaitsimError, nearest

_EXAMPLES = "[bold]Example"


class Command(TyperCommand):
    """A command whose help, and what it says of wrong values, is in the house style."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.help = arranged(self.help or "")

    def get_params(self, ctx: Any) -> Any:
        """The parameters, flags without '<bool>'."""
        return without_flag_types(super().get_params(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the command line.

        Raises:
            GaitsimError: a value is not allowed.
        """
        try:
            return super().parse_args(ctx, args)
        except typer.BadParameter as error:
            told = in_our_words(error)
            if told is None:
                raise
            raise told from None


class Group(TyperGroup):
    """A group of commands whose help is in the house style."""

    def get_params(self, ctx: Any) -> Any:
        """The parameters, flags without '<bool>'."""
        return without_flag_types(super().get_params(ctx))


def arranged(text: str) -> str:
    """A docstring's examples, which stand apart there, one a line."""
    before, mark, after = text.partition(_EXAMPLES)
    lines = [line.strip() for line in after.splitlines() if line.strip()]
    return before + mark + "\n".join(lines)


def without_flag_types(parameters: list[Any]) -> list[Any]:
    """The parameters; an empty name for the value of those that take none."""
    for parameter in parameters:
        if getattr(parameter, "is_flag", False) and parameter.metavar is None:
            parameter.metavar = ""
    return parameters


def in_our_words(error: typer.BadParameter) -> GaitsimError | None:
    """What is wrong with a value, where Typer passes on the words of pydantic; else None."""
    from pydantic import Field, ValidationError

    from gaitsim.registry.options import allowed, words

    cause, parameter = error.__cause__, error.param
    takes = getattr(parameter, "type_descriptor", None)
    if not isinstance(cause, ValidationError) or parameter is None or takes is None:
        return None
    field = Field(ge=takes.parameter_info.min, le=takes.parameter_info.max)
    field.annotation = takes.annotation
    (wrong, *_) = cause.errors()
    value, known = wrong["input"], words(field)
    kind = {"int_parsing": "no whole number", "float_parsing": "no number"}.get(wrong["type"])
    return GaitsimError(
        f"{value!r} is {kind or 'not allowed'}",
        where=" or ".join(parameter.opts),
        allowed=", ".join(known) or allowed(field),
        remedy=nearest(str(value), known),
    )

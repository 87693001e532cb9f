"""How `--help` looks: examples one a line, no type beside a flag that takes no value."""

from typing import Any

from typer.core import TyperCommand, TyperGroup

_EXAMPLES = "[bold]Example"


class Command(TyperCommand):
    """A command whose help is in the house style."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self.help = arranged(self.help or "")

    def get_params(self, ctx: Any) -> Any:
        """The parameters, flags without '<bool>'."""
        return without_flag_types(super().get_params(ctx))


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

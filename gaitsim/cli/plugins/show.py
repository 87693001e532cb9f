"""`gaitsim plugins list` and `gaitsim plugins show`."""

from typing import Annotated

import typer


def list_() -> None:
    """List all plugins by kind, with the package of each. Imports none of them.

    [bold]Example[/bold]

    gaitsim plugins list
    """
    from gaitsim.cli.console import notice, output, table
    from gaitsim.registry import KINDS, entries, unreadable

    made = table("kind", "name", "package")
    for kind in KINDS:
        for name, claims in entries(kind).items():
            packages = " and ".join(claim.source for claim in claims)
            conflict = "  (conflict: cannot be used)" if len(claims) > 1 else ""
            made.add_row(kind, name, packages + conflict)
    output().print(made, markup=False)
    for folder in unreadable():
        notice(f"Warning: the entry points of {folder} cannot be read; reinstall its package.")


def show(
    name: Annotated[str, typer.Argument(help="Name of a plugin, such as spider-walk.")],
) -> None:
    """Show a plugin's options: default, what is allowed, unit, meaning.

    [bold]Example[/bold]

    gaitsim plugins show spider-walk
    """
    from gaitsim.errors import PluginError, nearest
    from gaitsim.registry import KINDS, entries

    names = {kind: entries(kind) for kind in KINDS}
    kinds = [kind for kind in KINDS if name in names[kind]]
    if not kinds:
        known = sorted({known for kind in KINDS for known in names[kind]})
        raise PluginError(
            f"unknown plugin {name!r}", allowed=", ".join(known), remedy=nearest(name, known)
        )
    for kind in kinds:
        _show(kind, name)


def _show(kind: str, name: str) -> None:
    import inspect

    from rich.text import Text

    from gaitsim.cli.console import output, table
    from gaitsim.registry import find, load_class, options
    from gaitsim.render.terminal.text import visible_lines

    plugin = load_class(kind, name)
    console = output()
    console.print(Text.assemble((name, "bold"), f"  {kind} of {find(kind, name).source}"))
    console.print(visible_lines(inspect.getdoc(plugin) or ""), markup=False)
    if not plugin.model_fields:
        console.print("\nIt has no options.")
        return
    made = table("option", "default", "allowed", "meaning")
    for option, field in plugin.model_fields.items():
        made.add_row(option, options.default(field), options.allowed(field), options.meaning(field))
    console.print()
    console.print(made, markup=False)

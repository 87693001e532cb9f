"""`gaitsim plugins show`."""

import inspect
from typing import Annotated

import typer
from rich.text import Text

from gaitsim.cli.completion import plugin_names
from gaitsim.cli.facts import print_facts
from gaitsim.console.printing import output, print_table
from gaitsim.errors import PluginError, nearest
from gaitsim.registry import KINDS, PRODUCTS, entries, find, load_class


def show(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="Name of a plugin, such as 'spider-walk'.",
            autocompletion=plugin_names,
        ),
    ],
) -> None:
    """Show a plugin's options and, for a body, its channels and conditions.

    A channel is a named array of the body's motion, such as joint_angles. A condition is a property
    of its world, such as friction; --world and --worlds change conditions.

    [bold]Examples[/bold]

    gaitsim plugins show spider-walk

    gaitsim plugins show walker
    """
    names = {kind: entries(kind) for kind in (*KINDS, *PRODUCTS)}
    kinds = [kind for kind in (*KINDS, *PRODUCTS) if name in names[kind]]
    if not kinds:
        known = sorted({known for kind in (*KINDS, *PRODUCTS) for known in names[kind]})
        raise PluginError(
            f"unknown plugin {name!r}", allowed=", ".join(known), remedy=nearest(name, known)
        )
    for kind in kinds:
        _show(kind, name)


def _show(kind: str, name: str) -> None:
    from gaitsim.contracts import Organism
    from gaitsim.evaluation.worlds import default_conditions
    from gaitsim.registry import options

    plugin = load_class(kind, name)
    console = output()
    console.print(Text.assemble((name, "bold"), f"  {kind} of {find(kind, name).source}"))
    console.print(inspect.getdoc(plugin) or "")
    if not plugin.model_fields:
        console.print("\nIt has no options.")
    else:
        rows = [
            (option, options.default(field), options.allowed(field), options.meaning(field))
            for option, field in plugin.model_fields.items()
        ]
        console.print()
        print_table(["option", "default", "allowed", "meaning"], rows)
    if issubclass(plugin, Organism):
        rows = [(name, one.shape, one.units, one.help) for name, one in plugin.channels.items()]
        console.print()
        print_table(["channel", "axes", "unit", "meaning"], rows)
        if conditions := default_conditions(plugin):
            console.print()
            print_table(
                ["condition", "nominal", "usual range", "unit", "meaning"],
                [(name, *one.table_cells()) for name, one in conditions.items()],
            )
        if facts := plugin.library():
            console.print()
            print_facts(facts)

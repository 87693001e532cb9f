"""`gaitsim plugins`: `list` and `show`."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING

from pydantic import ValidationError
from rich.text import Text

from gaitsim.actions.action import Action, argument
from gaitsim.console.printing import notice, output, print_facts, print_table
from gaitsim.errors import GaitsimError, PluginError, nearest
from gaitsim.registry import PLUGINS, entries, find, load_class, unreadable

if TYPE_CHECKING:
    from gaitsim.contracts import Organism


BROKEN = 1  # exit code if a plugin has errors


class ListPlugins(Action):
    """List all plugins by kind, with their packages, without importing them.

    [bold]Example[/bold]

    gaitsim plugins list
    """

    def do(self) -> None:
        """Print the list."""
        rows = []
        for kind in PLUGINS:
            for name, claims in entries(kind).items():
                packages = " and ".join(claim.source for claim in claims)
                conflict = "  (conflict: cannot be used)" if len(claims) > 1 else ""
                rows.append([kind, name, packages + conflict])
        print_table(["kind", "name", "package"], rows)
        for folder in unreadable():
            notice(f"Warning: the entry points of {folder} cannot be read; reinstall its package.")


class ShowPlugin(Action):
    """Show a plugin's options and, for a body, its channels and conditions.

    A channel is a named array of the body's motion, such as joint_angles. A condition is a property
    of its world, such as friction; --world and --worlds change conditions. Start points are genomes
    around which searches begin.

    [bold]Examples[/bold]

    gaitsim plugins show spider-walk

    gaitsim plugins show walker
    """

    name: str = argument(
        "name of a plugin, such as 'spider-walk'", "NAME", completion="plugin_names"
    )

    def do(self) -> None:
        """Describe the plugins of this name."""
        name = self.name
        names = {kind: entries(kind) for kind in PLUGINS}
        kinds = [kind for kind in PLUGINS if name in names[kind]]
        if not kinds:
            known = sorted({known for kind in PLUGINS for known in names[kind]})
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
        if starts := _default_starts(plugin):
            console.print(f"\nstart points, for the option search.start: {', '.join(starts)}")
        if facts := plugin.library():
            console.print()
            print_facts(facts)


def _default_starts(model: type[Organism]) -> tuple[str, ...]:
    """Return the start points of a body with its default options; () if it needs other options."""
    try:
        return tuple(model().starts())
    except (ValidationError, GaitsimError):
        return ()

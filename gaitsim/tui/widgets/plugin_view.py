"""A plugin in full: its documentation, its options, and what works with it."""

from collections.abc import Mapping

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from gaitsim.contracts import Crossover, Fitness, Mutation, Organism, Plugin
from gaitsim.errors import GaitsimError
from gaitsim.registry import options
from gaitsim.registry.presets import read_preset
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.catalogue import Catalogue
from gaitsim.tui.widgets.toml_view import coloured


def plugin_view(
    kind: str, name: str, catalogue: Catalogue, colours: Mapping[str, str]
) -> RenderableType:
    """Return a plugin in full, or the reason why it cannot be used."""
    plugin = catalogue.classes[kind].get(name)
    if plugin is None:
        return Text(visible_lines(str(catalogue.failure(kind, name))), style=colours["error"])
    parts: list[RenderableType] = [Text(visible_lines(catalogue.about(kind, name)) + "\n")]
    parts.append(_options(plugin, colours))
    facts = Table.grid(padding=(0, 2))
    for title, text in _facts(kind, name, plugin, catalogue):
        facts.add_row(Text(title, style="bold"), Text(visible(text)))
    if facts.row_count:
        parts += ["", facts]
    return Group(*parts)


def _facts(
    kind: str, name: str, plugin: type[Plugin], catalogue: Catalogue
) -> list[tuple[str, str]]:
    found = []
    if issubclass(plugin, Organism):
        found += [(name, str(channel)) for name, channel in plugin.channels.items()]
        offered = catalogue.offered(name, None)
        found.append(("fitness", ", ".join(offered["fitness"]) or "none that is installed"))
    if issubclass(plugin, Fitness):
        found.append(("reads", ", ".join(plugin.needs)))
    if issubclass(plugin, Fitness | Crossover | Mutation):
        bodies = [
            b for b in catalogue.classes["organism"] if name in catalogue.offered(b, None)[kind]
        ]
        found.append(("works with", ", ".join(bodies) or "no body that is installed"))
    return found


def _options(plugin: type[Plugin], colours: Mapping[str, str]) -> RenderableType:
    if not plugin.model_fields:
        return Text("It has no options.", style="dim")
    table = Table(box=None, padding=(0, 2, 0, 0), header_style=f"bold {colours['primary']}")
    for title in ("option", "default", "allowed", "meaning"):
        table.add_column(title, overflow="fold")
    for name, field in plugin.model_fields.items():
        cells = (name, options.default(field), options.allowed(field), options.meaning(field))
        table.add_row(*(Text(visible(cell)) for cell in cells))
    return table


def preset_view(name: str, catalogue: Catalogue, colours: Mapping[str, str]) -> RenderableType:
    """Return the description and file of a preset."""
    preset = next((preset for preset in catalogue.presets if preset.name == name), None)
    about = Text((visible(preset.description) if preset else "") + "\n")
    try:
        text = coloured(read_preset(name), colours["primary"], colours["secondary"])
    except GaitsimError as error:
        text = Text(visible_lines(str(error)), style=colours["error"])
    return Group(about, text)

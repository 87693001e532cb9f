"""All information about a plugin: its documentation, its options, and compatible plugins."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from gaitsim.contracts import Crossover, Fitness, Mutation, Organism, Plugin
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import default_conditions
from gaitsim.registry import options
from gaitsim.registry.loading import read_preset
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.catalogue import Catalogue
from gaitsim.tui.widgets.toml_view import highlight

TABLE = 76  # minimum cells for options in a table


def plugin_view(
    kind: str, name: str, catalogue: Catalogue, colours: Mapping[str, str]
) -> RenderableType:
    """Return all information about a plugin, or the reason why it cannot be used."""
    plugin = catalogue.classes[kind].get(name)
    if plugin is None:
        return Text(visible_lines(str(catalogue.failure(kind, name))), style=colours["error"])
    # Join the lines of each paragraph, which is wrapped at the available width.
    about = re.sub(r"(?<!\n)\n(?=[^\s*-])", " ", catalogue.about(kind, name))
    parts: list[RenderableType] = [Text(visible_lines(about) + "\n")]
    parts.append(OptionTable(plugin, colours))
    facts = Table.grid(padding=(0, 2))
    facts.add_column(no_wrap=True)
    for title, text in _facts(kind, name, plugin, catalogue):
        facts.add_row(Text(title, style="bold"), Text(visible(text)))
    if facts.row_count:
        parts += ["", facts]
    return Group(*parts)


def searchable_text(kind: str, name: str, catalogue: Catalogue) -> str:
    """Return the searchable text of a plugin or a preset, including its options."""
    plugin = catalogue.classes.get(kind, {}).get(name)
    if plugin is not None:
        texts = [f"{one} {options.meaning(field)}" for one, field in plugin.model_fields.items()]
        return " ".join([catalogue.about(kind, name), *texts])
    return next((one.description for one in catalogue.presets if one.name == name), "")


def _facts(
    kind: str, name: str, plugin: type[Plugin], catalogue: Catalogue
) -> list[tuple[str, str]]:
    found = []
    if issubclass(plugin, Organism):
        found += [(name, str(channel)) for name, channel in plugin.channels.items()]
        found += [(name, str(one)) for name, one in default_conditions(plugin).items()]
        offered = catalogue.offered(name, None)
        found.append(("fitness", ", ".join(offered["fitness"]) or "none installed"))
    if issubclass(plugin, Fitness):
        found.append(("reads", ", ".join(plugin.needs)))
    if issubclass(plugin, Fitness | Crossover | Mutation):
        bodies = [
            b for b in catalogue.classes["organism"] if name in catalogue.offered(b, None)[kind]
        ]
        found.append(("works with", ", ".join(bodies) or "no installed body"))
    return found


@dataclass(frozen=True)
class OptionTable:
    """The options of a plugin as a table, or as a list if words would break in the table."""

    plugin: type[Plugin]
    colours: Mapping[str, str]

    def __rich_console__(self, console: Console, settings: ConsoleOptions) -> RenderResult:
        rows = [
            (name, options.default(field), options.allowed(field), options.meaning(field))
            for name, field in self.plugin.model_fields.items()
        ]
        head = f"bold {self.colours['primary']}"
        if not rows:
            yield Text("The plugin has no options.", style="dim")
        elif settings.max_width < TABLE:
            for name, default, allowed, meaning in rows:
                line = Text.assemble((visible(name), head), " = ", visible(default))
                yield line.append(visible(f"  {allowed}"), "dim")
                yield Padding(Text(visible(meaning)), (0, 0, 0, 2))
        else:
            table = Table(box=None, padding=(0, 2, 0, 0), header_style=head)
            for title in ("option", "default"):
                table.add_column(title, no_wrap=True)
            for title in ("allowed", "meaning"):
                table.add_column(title, ratio=1)
            for row in rows:
                table.add_row(*(Text(visible(cell)) for cell in row))
            yield table


def preset_view(name: str, catalogue: Catalogue, colours: Mapping[str, str]) -> RenderableType:
    """Return the description and the file of a preset."""
    preset = next((preset for preset in catalogue.presets if preset.name == name), None)
    about = Text((visible(preset.description) if preset else "") + "\n")
    try:
        text = highlight(read_preset(name), colours["primary"], colours["secondary"])
    except GaitsimError as error:
        text = Text(visible_lines(str(error)), style=colours["error"])
    return Group(about, text)

"""The installed bodies, fitness functions, operators and presets, and their packages."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.padding import Padding
from rich.table import Table
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.highlight import highlight
from textual.widgets import Input, OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.contracts import Crossover, Fitness, Mutation, Organism, Plugin, Reflex
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import default_conditions
from gaitsim.registry import EXPERIMENTS, PLUGINS, Entry, entries, options, unreadable
from gaitsim.registry.loading import read_preset
from gaitsim.render.terminal.text import visible, visible_lines
from gaitsim.tui.catalogue import Catalogue, read_catalogue
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.widgets.lists import ChoiceList

TITLES = {kind: kind for kind in PLUGINS} | {
    "organism": "bodies",
    EXPERIMENTS: "presets",
}
NOUNS = {"organism": "body", EXPERIMENTS: "preset"}
TABLE = 76  # minimum cells for options in a table


class Plugins(GaitScreen):
    """A list of plugins and presets and the highlighted one in full.

    Attributes:
        catalogue: installed plugins; None until they are loaded.
    """

    SUB_TITLE = "installed plugins and presets"
    CSS_PATH = "plugins.tcss"
    AUTO_FOCUS = "#installed"  # not the filter, which would take letters
    HELP_TEXT = """
Bodies, fitness functions, operators, reflexes and presets come from installed packages, bundled or
not. The left side lists them, with a ✗ before those that cannot be used. The right side shows the
source, description and options of the highlighted one, with defaults and bounds. / filters by words
in the name, kind, package, description or options.

Enter, or a click on the highlighted one, creates a **new run** with a body or a preset.
"""
    BINDINGS = bindings("plugins")

    def __init__(self) -> None:
        super().__init__()
        self.catalogue: Catalogue | None = None
        self._found: dict[str, Sequence[Entry]] = {}

    def content(self) -> ComposeResult:
        yield Input(placeholder="words to look for", id="filter", compact=True)
        with Horizontal():
            yield ChoiceList(id="installed")
            with VerticalScroll(id="plugin"):
                yield Static("Loading the plugins …", id="about-plugin")

    def on_mount(self) -> None:
        """List the names without imports, then load all plugins in a thread."""
        self.query_one("#filter").display = False
        self._list()
        self._load()

    @work
    async def _load(self) -> None:
        self.catalogue = await self.in_thread(read_catalogue)
        self._list()
        for package in await self.in_thread(unreadable):
            self.notify(
                f"The entry points of {package} cannot be read; reinstall its package.",
                severity="warning",
                markup=False,
            )

    def _list(self) -> None:
        menu = self.query_one("#installed", OptionList)
        chosen = menu.highlighted_option
        words = self.query_one("#filter", Input).value.casefold().split()
        self._found = {}
        rows: list[Option] = []
        for kind in (*PLUGINS, EXPERIMENTS):
            heading = Text(TITLES[kind], style="bold $secondary")
            rows.append(Option(heading, disabled=True))
            for name, claims in entries(kind).items():
                if all(word in self._words(kind, name, claims) for word in words):
                    key = f"{kind} {name}"
                    self._found[key] = claims
                    rows.append(Option(Text(f" {self._mark(kind, name)}{visible(name)}"), id=key))
            if rows[-1].disabled:
                rows.pop()
        menu.clear_options()
        menu.add_options(rows or [Option("No plugin matches all these words.", disabled=True)])
        kept = chosen is not None and chosen.id in self._found
        menu.highlighted = menu.get_option_index(str(chosen.id)) if kept and chosen else 1
        if not self._found:
            self.query_one("#about-plugin", Static).update("")
        self.refresh_bindings()

    def _words(self, kind: str, name: str, claims: Sequence[Entry]) -> str:
        """Return the text that the filter searches."""
        description = searchable_text(kind, name, self.catalogue) if self.catalogue else ""
        packages = " ".join(claim.source for claim in claims)
        return f"{name} {TITLES[kind]} {NOUNS.get(kind, kind)} {packages} {description}".casefold()

    def action_filter(self) -> None:
        box = self.query_one("#filter", Input)
        box.display = True
        box.focus()

    @on(Input.Changed, "#filter")
    def _filtered(self) -> None:
        self._list()

    @on(Input.Submitted, "#filter")
    def _to_list(self) -> None:
        self.query_one("#installed").focus()

    def action_back(self) -> None:
        """Close the filter if it is open, else go back."""
        box = self.query_one("#filter", Input)
        if box.display:
            box.value, box.display = "", False
            self.query_one("#installed").focus()
        else:
            super().action_back()

    def _mark(self, kind: str, name: str) -> str:
        bad = self.catalogue is not None and (kind, name) in self.catalogue.failures
        return "✗ " if bad else ""

    def _chosen(self) -> tuple[str, str] | None:
        """Return the kind and name of the highlighted entry."""
        option = self.query_one("#installed", OptionList).highlighted_option
        if option is None or option.id is None:
            return None
        kind, _, name = option.id.partition(" ")
        return kind, name

    @on(OptionList.OptionHighlighted, "#installed")
    def _show(self) -> None:
        chosen = self._chosen()
        if chosen is not None:
            self.query_one("#about-plugin", Static).update(self._view(*chosen))
            self.query_one("#plugin").scroll_home(animate=False)
        self.refresh_bindings()

    def _view(self, kind: str, name: str) -> RenderableType:
        claims = self._found[f"{kind} {name}"]
        head = Text.assemble((visible(name), "bold $primary"), f"  {NOUNS.get(kind, kind)}\n")
        for claim in claims:
            head.append(visible(f"{claim.source}  {claim.target}") + "\n", style="dim")
        if self.catalogue is None:
            return head
        if kind == EXPERIMENTS:
            return Content.from_rich_text(head) + Content("\n") + preset_view(name, self.catalogue)
        return Group(head, plugin_view(kind, name, self.catalogue))

    @property
    def plugin(self) -> tuple[str, ...]:
        chosen = self._chosen() if self.is_mounted else None
        return () if chosen is None else (chosen[1],)

    @on(OptionList.OptionSelected, "#installed")
    def action_new(self) -> None:
        experiment = self._experiment()
        if experiment is not None:
            self.show_screen("new.New", experiment)

    def _experiment(self) -> str | None:
        """Return the preset to start from for the highlighted entry."""
        chosen = self._chosen()
        if chosen is None or self.catalogue is None:
            return None
        kind, name = chosen
        if kind == EXPERIMENTS:
            return name
        preset = self.catalogue.preset_of(name) if kind == "organism" else None
        return preset.name if preset else None

    def command_line(self) -> str:
        chosen = self._chosen() if self.is_mounted else None
        if chosen is None:
            return "gaitsim plugins list"
        kind, name = chosen
        import shlex

        group = "experiments" if kind == EXPERIMENTS else "plugins"
        return shlex.join(["gaitsim", group, "show", name])

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "new":
            return self.is_mounted and self._experiment() is not None
        return super().check_action(action, parameters)


def plugin_view(kind: str, name: str, catalogue: Catalogue) -> RenderableType:
    """Return all information about a plugin, or the reason why it cannot be used."""
    plugin = catalogue.classes[kind].get(name)
    if plugin is None:
        return Text(visible_lines(str(catalogue.failure(kind, name))), style="$error")
    # Join the lines of each paragraph, which is wrapped at the available width.
    about = re.sub(r"(?<!\n)\n(?=[^\s*-])", " ", catalogue.about(kind, name))
    parts: list[RenderableType] = [Text(visible_lines(about) + "\n")]
    parts.append(OptionTable(plugin))
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
    if issubclass(plugin, Fitness | Reflex):
        found.append(("reads", ", ".join(plugin.needs) or "nothing"))
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

    def __rich_console__(self, console: Console, settings: ConsoleOptions) -> RenderResult:
        rows = [
            (name, options.default(field), options.allowed(field), options.meaning(field))
            for name, field in self.plugin.model_fields.items()
        ]
        head = "bold $primary"
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


def preset_view(name: str, catalogue: Catalogue) -> Content:
    """Return the description and the file of a preset."""
    preset = next((preset for preset in catalogue.presets if preset.name == name), None)
    about = Content(f"{visible(preset.description) if preset else ''}\n\n")
    try:
        return about + highlight(read_preset(name), language="toml")
    except GaitsimError as error:
        return about + Content.styled(visible_lines(str(error)), "$error")

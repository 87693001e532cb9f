"""The installed bodies, fitness functions, operators and presets, and their packages."""

from collections.abc import Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, VerticalScroll
from textual.widgets import Input, OptionList, Static
from textual.widgets.option_list import Option

from gaitsim.registry import EXPERIMENTS, KINDS, Entry, entries, unreadable
from gaitsim.render.terminal.text import visible
from gaitsim.tui.actions import bindings
from gaitsim.tui.catalogue import Catalogue, read_catalogue
from gaitsim.tui.screens.base import GaitScreen
from gaitsim.tui.widgets.choice_list import ChoiceList
from gaitsim.tui.widgets.conformance import check_plugin, verdict_view
from gaitsim.tui.widgets.footer import Footer
from gaitsim.tui.widgets.header import Header
from gaitsim.tui.widgets.plugin_view import plugin_view, preset_view, searchable_text

TITLES = {kind: kind for kind in KINDS} | {"organism": "bodies", EXPERIMENTS: "presets"}
NOUNS = {"organism": "body", EXPERIMENTS: "preset"}


class Plugins(GaitScreen):
    """A list of plugins and presets and the highlighted one in full.

    Attributes:
        catalogue: installed plugins; None until they are loaded.
    """

    SUB_TITLE = "installed plugins and presets"
    CSS_PATH = "plugins.tcss"
    AUTO_FOCUS = "#installed"  # not the filter, which would take letters
    HELP_TEXT = """
Bodies, fitness functions, operators and presets come from installed packages, bundled or not. The
left side lists them, with a ✗ before those that cannot be used. The right side shows the source,
description and options of the highlighted one, with defaults and bounds. / filters by words in the
name, kind, package, description or options.

Enter, or a click on the highlighted one, creates a **new run** with a body or a preset. c
**checks** whether the highlighted plugin fulfils its contract and lists the errors to fix.
"""
    BINDINGS = bindings("plugins")

    def __init__(self) -> None:
        super().__init__()
        self.catalogue: Catalogue | None = None
        self._found: dict[str, Sequence[Entry]] = {}
        self._reports: dict[tuple[str, str], dict[str, Any] | None] = {}  # None while a check runs

    def compose(self) -> ComposeResult:
        yield Header()
        yield Input(placeholder="words to look for", id="filter", compact=True)
        with Horizontal():
            yield ChoiceList(id="installed")
            with VerticalScroll(id="plugin"):
                yield Static("Loading the plugins …", id="about-plugin")
        yield Footer()

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
        menu, colours = self.query_one("#installed", OptionList), self.app.theme_variables
        chosen = menu.highlighted_option
        words = self.query_one("#filter", Input).value.casefold().split()
        self._found = {}
        rows: list[Option] = []
        for kind in (*KINDS, EXPERIMENTS):
            heading = Text(TITLES[kind], style=f"bold {colours['secondary']}")
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
        claims, colours = self._found[f"{kind} {name}"], self.app.theme_variables
        head = Text.assemble(
            (visible(name), f"bold {colours['primary']}"), f"  {NOUNS.get(kind, kind)}\n"
        )
        for claim in claims:
            head.append(visible(f"{claim.source}  {claim.target}") + "\n", style="dim")
        if (kind, name) in self._reports:
            head = Text.assemble(head, verdict_view(self._reports[kind, name], colours), "\n")
        if self.catalogue is None:
            return head
        if kind == EXPERIMENTS:
            return Group(head, preset_view(name, self.catalogue, colours))
        return Group(head, plugin_view(kind, name, self.catalogue, colours))

    @work
    async def action_check(self) -> None:
        chosen = self._chosen()
        if chosen is None or self._reports.get(chosen, {}) is None:
            return
        self._reports[chosen] = None
        self._show()
        self._reports[chosen] = await check_plugin(*chosen)
        if self._chosen() == chosen:
            self._show()

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

"""The sections of an experiment: a tab and a form for each, and the experiment file."""

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.events import DescendantFocus
from textual.widgets import ContentSwitcher, Tab, Tabs

from gaitsim.registry import KINDS
from gaitsim.tui.builder import SECTIONS, Validation
from gaitsim.tui.widgets.form import Field
from gaitsim.tui.widgets.part import Part
from gaitsim.tui.widgets.toml_view import TomlView

FILE = "file"
TITLES = {
    "evolution": "Run",
    "islands": "Islands",
    "worlds": "Worlds",
    "transferability": "Reality",
    "organism": "Body",
}
TITLES |= {kind: kind.capitalize() for kind in KINDS[1:]} | {FILE: "File"}


class Sections(Vertical):
    """Tabs across the full width; below them, the form of one section and the experiment file."""

    def __init__(self, id: str) -> None:
        super().__init__(id=id)
        self._validation: Validation | None = None

    def compose(self) -> ComposeResult:
        """Compose the tabs, a form for each section, and the file."""
        yield Tabs(*(Tab(title, id=name) for name, title in TITLES.items()), id="sections")
        with Horizontal():
            with ContentSwitcher(id="parts", initial=f"part-{SECTIONS[0]}"):
                for section in SECTIONS:
                    yield Part(section, id=f"part-{section}")
                yield TomlView(id=f"part-{FILE}")
            yield TomlView(id="beside")

    @property
    def active(self) -> str:
        """The name of the visible section."""
        return self.query_one(Tabs).active

    @active.setter
    def active(self, name: str) -> None:
        self.query_one(Tabs).active = name

    def switch(self, by: int) -> None:
        """Show the section that is `by` tabs further."""
        used = self._validation.used_sections if self._validation else SECTIONS
        names = [name for name in TITLES if name in (*used, FILE)]
        self.active = names[(names.index(self.active) + by) % len(names)]

    def part(self, section: str) -> Part:
        """Return the form of a section."""
        return self.query_one(f"#part-{section}", Part)

    def show(self, found: Validation) -> None:
        """Show a validation: the active form, the tabs with problems, and the file."""
        self._validation = found
        self._show_part()
        tabs = self.query_one(Tabs)
        for section in SECTIONS:
            (tabs.show if section in found.used_sections else tabs.hide)(section)
            wrong = any(key.partition(".")[0] == section for key in found.problems)
            self.query_one(f"#{section}", Tab).label = "✗ " * wrong + TITLES[section]
        for view in self.query(TomlView):
            view.show(found.toml)

    @on(Tabs.TabActivated)
    def _on_tab(self, event: Tabs.TabActivated) -> None:
        event.stop()
        self.query_one(ContentSwitcher).current = f"part-{self.active}"
        self._show_part()
        self.mark_line(self.active)

    def _show_part(self) -> None:
        """Update only the visible form, as updates are slow."""
        if self._validation is not None and self.active in self._validation.used_sections:
            self.part(self.active).show(self._validation)

    def on_descendant_focus(self, event: DescendantFocus) -> None:
        """Mark the line of the file that the focused field changes."""
        for widget in event.widget.ancestors_with_self:
            if isinstance(widget, Field):
                self.mark_line(widget.option.key)
            elif widget.has_class("plugin"):
                self.mark_line(f"{self.active}.plugin")

    def mark_line(self, key: str) -> None:
        """Mark the line of an option in the file, and scroll to it."""
        for view in self.query(TomlView):
            view.mark_line(key)

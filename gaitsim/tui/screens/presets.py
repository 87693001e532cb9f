"""Choose a preset by the picture of its body, or a file."""

import asyncio
import json
from collections.abc import Iterator, Sequence
from itertools import groupby

from rich.text import Text
from textual import on, work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.events import Click
from textual.widgets import Input, Static

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.individual import standing_skeleton
from gaitsim.render.scene.clip import Clip
from gaitsim.render.terminal import body
from gaitsim.render.terminal.body import Viewpoint
from gaitsim.render.terminal.text import visible
from gaitsim.tui.catalogue import Preset, read_outlines
from gaitsim.tui.keys import bindings
from gaitsim.tui.screens.base import Dialog

DEFAULT = "spider"  # preset under the cursor without a draft
NAMES = {"organism": "body", "search": "search", "fitness": "fitness"}
SIDE = 34, 10  # columns and rows of the picture beside the list
_PICTURES: dict[str, str] = {}  # by body


def draw_body(experiment: Experiment, size: tuple[int, int] = SIDE, *, named: bool = False) -> str:
    """Return a picture of the standing body of an experiment; drawn once for each body.

    With `named`, it has the names of the feet, an arrow to the front, and circles at joints without
    motors.
    """
    chosen = experiment.entries["organism"].name, experiment.organism.model_dump(mode="json")
    key = json.dumps((chosen, size, named), sort_keys=True)
    if key not in _PICTURES:
        columns, rows = size
        pins = experiment.organism.passive_places() if named else None
        clip = Clip(standing_skeleton(experiment), named=named, pins=pins)
        view = Viewpoint(zoom=0.65 if named else 1.0)
        codes, _ = body.picture(clip, 0.0, view, columns, rows + 1, ground=False)
        # The last row has the scale.
        _PICTURES[key] = "\n".join("".join(map(chr, row)).rstrip() for row in codes[:-1])
    return _PICTURES[key]


class Card(Static):
    """A preset, as a line of a list."""

    def __init__(self, preset: Preset, draft: bool) -> None:
        name = Text(visible(preset.name), "bold", no_wrap=True, overflow="ellipsis")
        search = visible(preset.plugins.get("search", ""))
        super().__init__(name.append(f"  {search}" + "  draft" * draft, "not bold"))
        self.preset, self.picture = preset, ""


class Presets(Dialog[str | None]):
    """Ask for the preset of a new run; return its name or the path of a file, or None.

    Args:
        drafts: presets with unsaved changes, the latest last.
        chosen: preset under the cursor; '' for the latest draft, or else the usual one.
    """

    AUTO_FOCUS = "#preset-filter"
    BINDINGS = bindings("presets")
    DEFAULT_CSS = """
    Presets {
        & #preset-filter { background: $panel; margin-bottom: 1; padding: 0 1; }
        & #preset-cards { width: 1fr; }
        & .heading { color: $secondary; text-style: bold; }
        & .presets { height: auto; }
        & Card { height: 1; padding: 0 1; text-wrap: nowrap; text-overflow: ellipsis; }
        & Card.-chosen { background: $primary 30%; }
        & #preset-side {
            width: 37; height: 1fr; padding-left: 1; border-left: solid $border-blurred;
        }
        & #preset-about { height: auto; }
    }
    """

    def __init__(self, drafts: Sequence[str] = (), chosen: str = "") -> None:
        super().__init__()
        self._drafts = drafts
        self._wanted = chosen or next(reversed(drafts), DEFAULT)
        self._card: Card | None = None

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog") as box:
            box.border_title = "New run: choose a preset"
            box.border_subtitle = "enter: open · ↑↓: choose · ctrl+l: a file · esc: cancel"
            yield Input(placeholder="words to look for", compact=True, id="preset-filter")
            with Horizontal():
                with VerticalScroll(id="preset-cards", can_focus=False):
                    for name, presets in _by_body(self._offered()):
                        yield Static(Text(visible(name)), classes="heading")
                        with Vertical(classes="presets"):
                            for preset in presets:
                                yield Card(preset, preset.name in self._drafts)
                with Vertical(id="preset-side"):
                    yield Static(id="preset-picture")
                    yield Static(id="preset-about")

    def _offered(self) -> list[Preset]:
        """Return all presets, and drafts that began with a file."""
        known = read_outlines()
        names = {preset.name for preset in known}
        return [
            *known,
            *(Preset(path, "unsaved changes") for path in self._drafts if path not in names),
        ]

    def on_mount(self) -> None:
        names = [card.preset.name for card in self._cards]
        if names:
            self._choose(self._cards[names.index(self._wanted) if self._wanted in names else 0])
        self._draw()

    @work(group="pictures")
    async def _draw(self) -> None:
        """Draw the bodies in a thread, beginning with that of the chosen preset."""
        first = self._card.preset if self._card else None
        own = first.plugins.get("organism") if first else None
        cards = sorted(
            self.query(Card),
            key=lambda card: (card.preset is not first, card.preset.plugins.get("organism") != own),
        )
        for card in cards:
            card.picture = await asyncio.to_thread(_picture, card.preset.name)
            if not self.is_attached:
                return
            if card is self._card:
                self._show_side()

    # Choosing

    @property
    def _cards(self) -> list[Card]:
        """The cards that the filter shows."""
        return [card for card in self.query(Card) if card.display]

    def _choose(self, card: Card | None) -> None:
        if self._card is not None:
            self._card.remove_class("-chosen")
        self._card = card
        if card is not None:
            card.add_class("-chosen")
            card.scroll_visible(animate=False)
        self._show_side()

    def _show_side(self) -> None:
        picture, about = Text(), Text("No preset matches all these words.")
        if self._card is not None:
            preset = self._card.preset
            plugins = preset.plugins
            picture = Text(self._card.picture, "$primary")
            facts = [f"{NAMES[kind]} {plugins[kind]}" for kind in NAMES if kind in plugins]
            lines = [preset.name, preset.description, "", *facts]
            about = Text("\n".join(map(visible, lines)))
            about.stylize("bold", 0, len(lines[0]))
        self.query_one("#preset-picture", Static).update(picture)
        self.query_one("#preset-about", Static).update(about)

    def action_move(self, step: int) -> None:
        """Choose the preset below, or above for −1."""
        cards = self._cards
        if self._card in cards:
            self._choose(cards[min(max(cards.index(self._card) + step, 0), len(cards) - 1)])

    @on(Input.Changed)
    def _filter(self, event: Input.Changed) -> None:
        words = event.value.casefold().split()
        for card in self.query(Card):
            preset = card.preset
            text = f"{preset.name} {preset.description} {' '.join(preset.plugins.values())}"
            card.display = all(word in text.casefold() for word in words)
        for heading in self.query(".heading"):
            grid = heading.parent.children[heading.parent.children.index(heading) + 1]  # type: ignore[union-attr]
            grid.display = heading.display = any(card.display for card in grid.children)
        cards = self._cards
        now = self._card if self._card in cards else next(iter(cards), None)
        exact = (card for card in cards if [card.preset.name.casefold()] == words)
        self._choose(next(exact, now))

    @on(Input.Submitted)
    def _open(self) -> None:
        if self._card is not None:
            self.dismiss(self._card.preset.name)

    def on_click(self, event: Click) -> None:
        """Choose a card; open the chosen one."""
        if isinstance(event.widget, Card):
            if event.widget is self._card:
                self._open()
            else:
                self._choose(event.widget)

    @work(group="ask", exclusive=True)
    async def action_file(self) -> None:
        """Choose a file instead."""
        from gaitsim.tui.screens.files import ChooseFile

        path = await self.app.push_screen_wait(ChooseFile())
        if path is not None:
            self.dismiss(path)


def _by_body(presets: Sequence[Preset]) -> Iterator[tuple[str, list[Preset]]]:
    """Yield each body with its presets."""

    def name(preset: Preset) -> str:
        return preset.plugins.get("organism", "files")

    for body_name, found in groupby(sorted(presets, key=name), name):
        yield body_name, [*found]


def _picture(name: str) -> str:
    """Return the picture of a preset's body, or nothing if it fails."""
    try:
        return draw_body(load_experiment(name))
    except GaitsimError:
        return ""

"""The index of a gallery: HTML without scripts, which asks the network for nothing."""

import html
from collections.abc import Iterable, Sequence
from importlib.resources import files
from itertools import groupby

from gaitsim.render.gallery.cards import SIZE, Card
from gaitsim.render.terminal.text import number, visible, visible_lines

_POLICY = (
    "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:; "
    "style-src 'unsafe-inline'"
)
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="referrer" content="no-referrer">
<meta name="generator" content="{made}">
<title>{title}</title>
<style>
{style}</style>
</head>
<body>
<header>
<h1>{title}</h1>
<p>{about}</p>
</header>
<main>
{main}
</main>
<footer>
<p>Scores are comparable between runs with the same options of body, fitness and worlds.
A challenge code holds experiment, genome and score: <kbd>gaitsim verify CODE</kbd> plays it and
says whether the score is true, <kbd>gaitsim run --from CODE</kbd> starts a run from it.</p>
<p>{made}</p>
</footer>
</body>
</html>
"""


def index(
    title: str, cards: Iterable[Card], problems: Sequence[tuple[str, str]], made: str
) -> bytes:
    """Return the index, in UTF-8: the best first within each body and fitness.

    Args:
        title: of the gallery.
        cards: of its runs.
        problems: runs that cannot be shown, by name, each with the reason.
        made: the program that makes it.
    """
    ordered = ranked(cards)
    sections = [
        _section(body, fitness, list(group))
        for (body, fitness), group in groupby(ordered, key=lambda one: (one.body, one.fitness))
    ]
    if problems:
        rows = "\n".join(f"<li><b>{_text(name)}</b> {_text(why)}</li>" for name, why in problems)
        heading = '<h2 id="missing">Not shown</h2>'
        sections.append(
            f'<section aria-labelledby="missing">\n{heading}\n<ul>\n{rows}\n</ul>\n</section>'
        )
    count = len(ordered)
    return _PAGE.format(
        policy=_POLICY,
        made=_text(made),
        title=_text(title),
        about=f"{count} run{'s' * (count != 1)}",
        style=files("gaitsim.render.gallery").joinpath("gallery.css").read_text(encoding="utf-8"),
        main="\n".join(sections) or "<p>There are no runs here yet.</p>",
    ).encode()


def ranked(cards: Iterable[Card]) -> list[Card]:
    """Return cards by body and fitness, the best first within each."""
    return sorted(cards, key=lambda one: (one.body, one.fitness, -one.score, one.name))


def _section(body: str, fitness: str, cards: Sequence[Card]) -> str:
    shown = "\n".join(_card(card, rank) for rank, card in enumerate(cards, 1))
    heading = f"<h2>{_text(body)} <small>{_text(fitness)}</small></h2>"
    return f'<section>\n{heading}\n<ol class="cards">\n{shown}\n</ol>\n</section>'


def _card(card: Card, rank: int) -> str:
    name = _text(card.name)
    unit = f" {_text(card.unit)}" if card.unit else ""
    parts = [_link(_image(card), card.page) if card.pictures else '<p class="none">no picture</p>']
    parts.append(f"<h3>{_link(name, card.page)}</h3>")
    parts.append(
        f'<p class="score"><span class="rank">{rank}</span> <b>{number(card.score)}{unit}</b>'
        f"{_text(card.worlds)}</p>"
    )
    parts.append(f"<p>best of {_text(card.which)}, {card.generations} evolved</p>")
    if card.description:
        parts.append(f"<p>{_text(card.description)}</p>")
    if card.note:
        parts.append(f'<p class="note">{html.escape(visible_lines(card.note))}</p>')
    parts += [f'<p class="problem">{_text(one)}</p>' for one in card.problems]
    parts.append(_code(card))
    return "<li>\n" + "\n".join(filter(None, parts)) + "\n</li>"


def _image(card: Card) -> str:
    width, height = SIZE
    return (
        '<picture><source media="(prefers-color-scheme: dark)" '
        f'srcset="{card.pictures["dark"]}"><img src="{card.pictures["light"]}" '
        f'width="{width}" height="{height}" alt="the champion of {_text(card.name)}"></picture>'
    )


def _code(card: Card) -> str:
    size = f"{len(card.code):,} characters"
    if not card.code:
        return ""
    if card.code_file:
        return f'<p><a href="{html.escape(card.code_file)}" download>Challenge code</a>, {size}</p>'
    return (
        f"<details><summary>Challenge code, {size}</summary>"
        f"<p>A click selects it.</p><code>{html.escape(card.code)}</code></details>"
    )


def _link(content: str, page: str) -> str:
    return f'<a href="{html.escape(page)}">{content}</a>' if page else content


def _text(text: str) -> str:
    """Return a text for HTML; control characters and marks of direction are shown escaped."""
    return html.escape(visible(text))

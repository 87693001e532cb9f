"""The index of a gallery: HTML without scripts that makes no network requests."""

import html
from collections.abc import Iterable, Sequence
from importlib.resources import files
from itertools import groupby

from gaitsim.render.gallery.cards import SIZE, Card
from gaitsim.render.html import escaped, head, program_version
from gaitsim.render.terminal.text import number, visible_lines

_PAGE = """{head}<body>
<header>
<h1>{title}</h1>
<p>{about}</p>
</header>
<main>
{main}
</main>
<footer>
<p>Scores are comparable between runs with the same options of body, fitness and worlds.
A challenge code holds an experiment, a genome and its score. <kbd>gaitsim verify CODE</kbd>
checks the score, and <kbd>gaitsim run --from CODE</kbd> starts a run from the genome.</p>
<p>{made}</p>
</footer>
</body>
</html>
"""


def index(title: str, cards: Iterable[Card], problems: Sequence[tuple[str, str]]) -> bytes:
    """Return the index, in UTF-8, sorted by body and fitness, then from the best score down.

    Args:
        title: title of the gallery.
        cards: cards of the runs.
        problems: names of runs that cannot be shown, each with the reason.
    """
    ordered = ranked(cards)
    sections = [
        _section(body, fitness, list(group))
        for (body, fitness), group in groupby(ordered, key=lambda one: (one.body, one.fitness))
    ]
    if problems:
        rows = "\n".join(
            f"<li><b>{escaped(name)}</b> {escaped(why)}</li>" for name, why in problems
        )
        heading = '<h2 id="missing">Not shown</h2>'
        sections.append(
            f'<section aria-labelledby="missing">\n{heading}\n<ul>\n{rows}\n</ul>\n</section>'
        )
    count = len(ordered)
    style = files("gaitsim.render.gallery").joinpath("gallery.css").read_text(encoding="utf-8")
    return _PAGE.format(
        head=head(title, "img-src data:", style),
        made=escaped(program_version()),
        title=escaped(title),
        about=f"{count} run{'s' * (count != 1)}",
        main="\n".join(sections) or "<p>There are no runs here yet.</p>",
    ).encode()


def ranked(cards: Iterable[Card]) -> list[Card]:
    """Return cards sorted by body and fitness, then from the best score down."""
    return sorted(cards, key=lambda one: (one.body, one.fitness, -one.score, one.name))


def _section(body: str, fitness: str, cards: Sequence[Card]) -> str:
    shown = "\n".join(_card(card, rank) for rank, card in enumerate(cards, 1))
    heading = f"<h2>{escaped(body)} <small>{escaped(fitness)}</small></h2>"
    return f'<section>\n{heading}\n<ol class="cards">\n{shown}\n</ol>\n</section>'


def _card(card: Card, rank: int) -> str:
    name = escaped(card.name)
    unit = f" {escaped(card.unit)}" if card.unit else ""
    parts = [_link(_image(card), card.page) if card.pictures else '<p class="none">no picture</p>']
    parts.append(f"<h3>{_link(name, card.page)}</h3>")
    parts.append(
        f'<p class="score"><span class="rank">{rank}</span> <b>{number(card.score)}{unit}</b>'
        f"{escaped(card.worlds)}</p>"
    )
    parts.append(f"<p>best of {escaped(card.which)} of {card.generations}</p>")
    if card.description:
        parts.append(f"<p>{escaped(card.description)}</p>")
    if card.note:
        parts.append(f'<p class="note">{html.escape(visible_lines(card.note))}</p>')
    parts += [f'<p class="problem">{escaped(one)}</p>' for one in card.problems]
    parts.append(_code(card))
    return "<li>\n" + "\n".join(filter(None, parts)) + "\n</li>"


def _image(card: Card) -> str:
    width, height = SIZE
    return (
        '<picture><source media="(prefers-color-scheme: dark)" '
        f'srcset="{card.pictures["dark"]}"><img src="{card.pictures["light"]}" '
        f'width="{width}" height="{height}" alt="the champion of {escaped(card.name)}"></picture>'
    )


def _code(card: Card) -> str:
    size = f"{len(card.code):,} characters"
    if not card.code:
        return ""
    if card.code_file:
        return f'<p><a href="{html.escape(card.code_file)}" download>Challenge code</a>, {size}</p>'
    return (
        f"<details><summary>Challenge code, {size}</summary>"
        f"<p>Click the code to select it.</p><code>{html.escape(card.code)}</code></details>"
    )


def _link(content: str, page: str) -> str:
    return f'<a href="{html.escape(page)}">{content}</a>' if page else content

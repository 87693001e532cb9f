"""Galleries: a site with an index of a folder of runs and a page that plays each run."""

import base64
import html
import json
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from io import BytesIO
from itertools import groupby
from pathlib import Path

from gaitsim.plugin import ExperimentError, GaitsimError, PluginError, Skeleton, read_regular
from gaitsim.plugin.pictures import Clip, Scene, number, visible_lines
from gaitsim.plugin.runs import (
    Individual,
    RunSnapshot,
    check_links,
    code_of,
    create_out_folder,
    list_runs,
    read_note,
    read_tags,
    write_bytes,
)
from gaitsim_page.document import asset, escaped, head, program_version
from gaitsim_page.player import write_page

SIZE = 480, 300  # size of a picture, pixels
MOMENT = 0.4  # moment in the picture, as a share of the motion
QUALITY = 80  # quality of a WebP file


@dataclass(frozen=True)
class RunCard:
    """The content of a run's card in the index.

    Attributes:
        name: name of the run's folder.
        description: description of the experiment.
        body, fitness: names of the plugins.
        score: score of the champion.
        unit: unit of the score, or ''.
        which: label of the champion, such as 'generation 120'.
        worlds: number of worlds, as ' over 4 worlds', or ''.
        generations: number of finished generations.
        note: note of the user, or ''.
        tags: tags of the user.
        code: challenge code of the champion, or ''.
        pictures: pictures of the champion as WebP data URLs, by theme; {} if it cannot be drawn.
        problems: reasons why parts are missing.
        page: path, relative to the index, of the page that plays the champion, or ''.
    """

    name: str
    description: str
    body: str
    fitness: str
    score: float
    unit: str
    which: str
    worlds: str
    generations: int
    note: str
    tags: tuple[str, ...]
    code: str
    pictures: dict[str, str]
    problems: tuple[str, ...]
    page: str = ""


def read_champion(path: Path) -> tuple[RunSnapshot, Individual]:
    """Return a run and its champion."""
    run = RunSnapshot(path)
    return run, run.individual()


def card_of(run: RunSnapshot, champion: Individual) -> RunCard:
    """Return the card of a run, without its page; parts that fail are listed as problems."""
    experiment = champion.experiment
    problems = []
    note, code = "", ""
    tags: tuple[str, ...] = ()
    pictures: dict[str, str] = {}
    try:
        note, tags = read_note(run.path), read_tags(run.path)
    except GaitsimError as error:
        problems.append(error.what)
    try:
        code = code_of(champion)
    except GaitsimError as error:
        problems.append(f"no challenge code: {error.what}")
    try:
        skeleton = champion.skeleton
        pictures = {theme: _picture(skeleton, theme) for theme in ("light", "dark")}
    except GaitsimError as error:
        problems.append(f"no picture: {error.what}")
    return RunCard(
        name=champion.name,
        description=experiment.description,
        body=experiment.entries["organism"].name,
        fitness=experiment.entries["fitness"].name,
        score=champion.score,
        unit=experiment.fitness.unit,
        which=champion.label,
        worlds=champion.over_worlds,
        generations=run.generation,
        note=note,
        tags=tags,
        code=code,
        pictures=pictures,
        problems=tuple(problems),
    )


def _picture(skeleton: Skeleton, theme: str) -> str:
    """Return a picture of a body in motion, as a data URL."""
    from PIL import Image

    scene = Scene([Clip(skeleton)], SIZE, "iso", theme)
    data = BytesIO()
    picture = Image.fromarray(scene.draw(MOMENT * scene.seconds)[..., :3])
    picture.save(data, format="WEBP", quality=QUALITY, method=6)
    return f"data:image/webp;base64,{base64.b64encode(data.getvalue()).decode()}"


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


def index(title: str, cards: Iterable[RunCard], problems: Sequence[tuple[str, str]]) -> bytes:
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
    style = asset("gallery.css")
    return _PAGE.format(
        head=head(title, "img-src data:", style),
        made=escaped(program_version()),
        title=escaped(title),
        about=f"{count} run{'s' * (count != 1)}",
        main="\n".join(sections) or "<p>There are no runs here yet.</p>",
    ).encode()


def ranked(cards: Iterable[RunCard]) -> list[RunCard]:
    """Return cards sorted by body and fitness, then from the best score down."""
    return sorted(cards, key=lambda one: (one.body, one.fitness, -one.score, one.name))


def _section(body: str, fitness: str, cards: Sequence[RunCard]) -> str:
    shown = "\n".join(_card(card, rank) for rank, card in enumerate(cards, 1))
    heading = f"<h2>{escaped(body)} <small>{escaped(fitness)}</small></h2>"
    return f'<section>\n{heading}\n<ol class="cards">\n{shown}\n</ol>\n</section>'


def _card(card: RunCard, rank: int) -> str:
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
    if card.tags:
        parts.append(f"<p>tags: {escaped(', '.join(card.tags))}</p>")
    parts += [f'<p class="problem">{escaped(one)}</p>' for one in card.problems]
    parts.append(_code(card))
    return "<li>\n" + "\n".join(filter(None, parts)) + "\n</li>"


def _image(card: RunCard) -> str:
    width, height = SIZE
    return (
        '<picture><source media="(prefers-color-scheme: dark)" '
        f'srcset="{card.pictures["dark"]}"><img src="{card.pictures["light"]}" '
        f'width="{width}" height="{height}" alt="the champion of {escaped(card.name)}"></picture>'
    )


def _code(card: RunCard) -> str:
    size = f"{len(card.code):,} characters"
    if not card.code:
        return ""
    return (
        f"<details><summary>Challenge code, {size}</summary>"
        f"<p>Click the code to select it.</p><code>{html.escape(card.code)}</code></details>"
    )


def _link(content: str, page: str) -> str:
    return f'<a href="{html.escape(page)}">{content}</a>' if page else content


INDEX, RECORD, PAGES = "index.html", "gallery.json", "pages"
KIND = "gaitsim gallery"
MAX_RECORD_BYTES = 50_000_000  # maximum bytes of a gallery's record
_LETTERS = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_")


@dataclass(frozen=True)
class Gallery:
    """The result of writing a gallery.

    Attributes:
        index: path of the index.
        shown: number of runs with a card.
        problems: names of runs with missing parts, each with the reason.
    """

    index: Path
    shown: int
    problems: tuple[tuple[str, str], ...]


def write_gallery(
    root: Path,
    out: Path,
    *,
    begin: Callable[[int], None] = lambda total: None,
    advance: Callable[[], None] = lambda: None,
) -> Gallery:
    """Write a gallery of the runs in a folder; runs that cannot be shown are listed with reasons.

    Ctrl-C leaves a gallery of the runs processed so far. The same runs give the same files.

    Args:
        root: folder of the runs.
        out: folder of the gallery; an existing gallery is replaced.
        begin: function called with the number of runs.
        advance: function called after each run.
    """
    before = _own_files(out)
    paths = sorted(list_runs(root), key=lambda path: path.name)
    create_out_folder(out / PAGES)
    for folder in (out, out / PAGES):
        check_links(folder, "remove it, or choose a different folder")
    _write_record(out, [], before)  # marks the folder as a gallery from here on
    begin(len(paths))
    cards: list[RunCard] = []
    problems: list[tuple[str, str]] = []
    left = [*paths]
    try:
        for path, name in zip(paths, _file_names(paths), strict=True):
            try:
                cards.append(_write_run(path, out, f"{PAGES}/{name}"))
                problems += [(path.name, one) for one in cards[-1].problems]
            except GaitsimError as error:
                problems.append((path.name, _reason(error)))
            left.remove(path)
            advance()
    except KeyboardInterrupt:
        problems += [(path.name, "interrupted before this run") for path in left]
        _finish(root, out, cards, problems, before)
        raise
    written = _finish(root, out, cards, problems, before)
    for name in before - written:
        with suppress(OSError):
            (out / name).unlink()
    _write_record(out, ranked(cards), written)
    return Gallery(out / INDEX, len(cards), tuple(problems))


def _write_run(path: Path, out: Path, name: str) -> RunCard:
    """Write the files of a run, and return its card.

    Args:
        path: folder of the run.
        out: folder of the gallery.
        name: path of the run's files, relative to `out`, without extension.
    """
    run, champion = read_champion(path)
    card = card_of(run, champion)
    if not card.pictures:
        return card
    try:
        write_page([champion], out / f"{name}.html", run)
    except PluginError as error:  # for example in a measure, which pictures do not need
        return replace(card, problems=(*card.problems, f"no page: {_reason(error)}"))
    return replace(card, page=f"{name}.html")


def _finish(
    root: Path,
    out: Path,
    cards: Sequence[RunCard],
    problems: Sequence[tuple[str, str]],
    before: set[str],
) -> set[str]:
    """Write the index, and the record with new and earlier files; return the new files."""
    shown = {card.name for card in cards}
    missing = [(name, why) for name, why in problems if name not in shown]
    title = f"Gallery of {root.resolve().name or root}"
    write_bytes(out / INDEX, index(title, cards, missing))
    written = {card.page for card in cards if card.page}
    _write_record(out, ranked(cards), before | written)
    return written


def _write_record(out: Path, cards: Iterable[RunCard], written: Iterable[str]) -> None:
    """Write the record that marks a folder as a gallery."""
    runs = [
        {
            "run": card.name,
            "body": card.body,
            "fitness": card.fitness,
            "score": card.score,
            "unit": card.unit,
            "page": card.page or None,
            "code": card.code or None,
        }
        for card in cards
    ]
    record = {"kind": KIND, "files": sorted(written), "runs": runs}
    write_bytes(out / RECORD, json.dumps(record, indent=1).encode() + b"\n")


def _own_files(out: Path) -> set[str]:
    """Return the files of an existing gallery, as paths relative to it; empty for a new folder."""
    if not os.path.lexists(out):
        return set()
    try:
        if out.is_dir() and not any(out.iterdir()):
            return set()
        record = json.loads(read_regular(out / RECORD, MAX_RECORD_BYTES))
        if record["kind"] == KIND:
            found = {str(name) for name in record["files"]}
            return {name for name in found if name == f"{PAGES}/{Path(name).name}"}
    except (OSError, ValueError, LookupError, TypeError, RecursionError):
        pass
    raise GaitsimError(
        f"{out} exists and is not a gallery",
        where="--out",
        allowed=f"a new or empty folder, or one with the {RECORD} of a gallery",
        remedy="choose a different folder",
    )


def _file_names(paths: Iterable[Path]) -> list[str]:
    """Return a distinct file name for each run, safe in URLs and on any system."""
    found: list[str] = []
    taken: set[str] = set()
    for path in paths:
        short = "".join(c if c in _LETTERS else "-" for c in path.name)[:80].strip("-")
        name, number = f"run-{short}" if short else "run", 1
        while name.casefold() in taken:
            number += 1
            name = f"run-{short}-{number}"
        taken.add(name.casefold())
        found.append(name)
    return found


def _reason(error: GaitsimError) -> str:
    """Return the problems of an error, without paths on this machine."""
    problems = error.problems if isinstance(error, ExperimentError) else (error,)
    return "; ".join(" ".join(one.what.split()) for one in problems)

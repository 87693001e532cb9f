"""Galleries: a site with an index of a folder of runs and a page that plays each run."""

import base64
import html
import json
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from gaitsim.plugin import ExperimentError, GaitsimError, Skeleton, read_regular
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

T = TypeVar("T")


class RunCard(NamedTuple):
    """The card of a run in the index.

    Attributes:
        record: run, body, fitness, score, unit, page and code for programs, as in the record.
        head: picture and name, as HTML.
        details: score and everything below it, as HTML.
        problems: reasons why parts are missing.
    """

    record: dict[str, Any]
    head: str
    details: str
    problems: tuple[str, ...]


def write_run(path: Path, out: Path, name: str) -> RunCard:
    """Write the page of a run that plays its champion, and return the run's card.

    Parts that fail are listed as problems.

    Args:
        path: folder of the run.
        out: folder of the gallery.
        name: path of the page, relative to `out`.
    """
    run = RunSnapshot(path)
    champion = run.individual()
    experiment, problems = champion.experiment, list[str]()

    def attempt(missing: str, create: Callable[[], T], otherwise: T) -> T:
        try:
            return create()
        except GaitsimError as error:
            problems.append(missing + _reason(error))
            return otherwise

    note = attempt("", lambda: read_note(path), "")
    tags = attempt("", lambda: ", ".join(read_tags(path)), "")
    code = attempt("no challenge code: ", lambda: code_of(champion), "")
    image = attempt("no picture: ", lambda: _image(champion), "")

    def create_page() -> str:
        write_page([champion], out / name, run)
        return name

    page = attempt("no page: ", create_page, "") if image else ""
    record = {
        "run": champion.name,
        "body": experiment.entries["organism"].name,
        "fitness": experiment.entries["fitness"].name,
        "score": champion.score,
        "unit": experiment.fitness.unit,
        "page": page or None,
        "code": code or None,
    }
    score = f"{number(champion.score)} {experiment.fitness.unit}".rstrip()
    details = [
        f"<b>{escaped(score)}</b>{escaped(champion.over_worlds)}</p>",
        f"<p>best of {escaped(champion.label)} of {run.generation}</p>",
        f"<p>{escaped(experiment.description)}</p>" * bool(experiment.description),
        f'<p class="note">{html.escape(visible_lines(note))}</p>' * bool(note),
        f"<p>tags: {escaped(tags)}</p>" * bool(tags),
        *(f'<p class="problem">{escaped(one)}</p>' for one in problems),
        f"<details><summary>Challenge code, {len(code):,} characters</summary>"
        f"<p>Click the code to select it.</p><code>{html.escape(code)}</code></details>"
        * bool(code),
    ]
    linked = f'<a href="{html.escape(page)}">{{}}</a>' if page else "{}"
    head = linked.format(image) if image else '<p class="none">no picture</p>'
    heading = f"<h3>{linked.format(escaped(champion.name))}</h3>"
    return RunCard(record, f"{head}\n{heading}", "\n".join(filter(None, details)), tuple(problems))


def _image(champion: Individual) -> str:
    """Return pictures of a body in motion for both themes, as HTML."""
    width, height = SIZE
    light, dark = (_picture(champion.skeleton, theme) for theme in ("light", "dark"))
    return (
        f'<picture><source media="(prefers-color-scheme: dark)" srcset="{dark}"><img src="{light}" '
        f'width="{width}" height="{height}" alt="the champion of {escaped(champion.name)}">'
        "</picture>"
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


def index(title: str, cards: Sequence[RunCard], problems: Sequence[tuple[str, str]]) -> bytes:
    """Return the index, in UTF-8.

    Args:
        title: title of the gallery.
        cards: cards of the runs, sorted by body and fitness, then from the best score down.
        problems: names of runs that cannot be shown, each with the reason.
    """
    sections = []
    for (body, fitness), group in groupby(cards, key=lambda one: _order(one)[:2]):
        shown = "\n".join(
            f'<li>\n{card.head}\n<p class="score"><span class="rank">{rank}</span> '
            f"{card.details}\n</li>"
            for rank, card in enumerate(group, 1)
        )
        heading = f"<h2>{escaped(body)} <small>{escaped(fitness)}</small></h2>"
        sections.append(f'<section>\n{heading}\n<ol class="cards">\n{shown}\n</ol>\n</section>')
    if problems:
        rows = "\n".join(
            f"<li><b>{escaped(name)}</b> {escaped(why)}</li>" for name, why in problems
        )
        heading = '<h2 id="missing">Not shown</h2>'
        sections.append(
            f'<section aria-labelledby="missing">\n{heading}\n<ul>\n{rows}\n</ul>\n</section>'
        )
    return _PAGE.format(
        head=head(title, "img-src data:", asset("gallery.css")),
        made=escaped(program_version()),
        title=escaped(title),
        about=f"{len(cards)} run{'s' * (len(cards) != 1)}",
        main="\n".join(sections) or "<p>There are no runs here yet.</p>",
    ).encode()


def _order(card: RunCard) -> tuple[str, str, float, str]:
    """Return the place of a card: body and fitness, then from the best score down."""
    one = card.record
    return one["body"], one["fitness"], -one["score"], one["run"]


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
    stopped = None
    for place, (path, name) in enumerate(zip(paths, _file_names(paths), strict=True)):
        try:
            cards.append(write_run(path, out, f"{PAGES}/{name}.html"))
            problems += [(path.name, one) for one in cards[-1].problems]
            advance()
        except GaitsimError as error:
            problems.append((path.name, _reason(error)))
            advance()
        except KeyboardInterrupt as interrupt:
            stopped = interrupt
            problems += [(left.name, "interrupted before this run") for left in paths[place:]]
            break
    cards.sort(key=_order)
    shown = {card.record["run"] for card in cards}
    missing = [(name, why) for name, why in problems if name not in shown]
    write_bytes(out / INDEX, index(f"Gallery of {root.resolve().name or root}", cards, missing))
    written = {card.record["page"] for card in cards} - {None}
    _write_record(out, cards, before | written)
    if stopped:
        raise stopped
    for name in before - written:
        with suppress(OSError):
            (out / name).unlink()
    _write_record(out, cards, written)
    return Gallery(out / INDEX, len(cards), tuple(problems))


def _write_record(out: Path, cards: Sequence[RunCard], files: Iterable[str]) -> None:
    """Write the record that marks a folder as a gallery, with the files that belong to it."""
    record = {"kind": KIND, "files": sorted(files), "runs": [card.record for card in cards]}
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

"""Write a gallery: a folder with an index, a page for each run, and files of long codes."""

import json
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from gaitsim.errors import ExperimentError, GaitsimError, PluginError
from gaitsim.opening import read_regular
from gaitsim.render.gallery.cards import Card, card_of, read_champion
from gaitsim.render.gallery.index import index, ranked
from gaitsim.render.page.player import write_page
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import check_links, create_out_folder, list_runs

INDEX, RECORD, PAGES = "index.html", "gallery.json", "pages"
KIND = "gaitsim gallery"
MAX_INLINE_CODE = 4000  # maximum characters of a code in the index; longer codes have a file
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
    cards: list[Card] = []
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


def _write_run(path: Path, out: Path, name: str) -> Card:
    """Write the files of a run, and return its card.

    Args:
        path: folder of the run.
        out: folder of the gallery.
        name: path of the run's files, relative to `out`, without extension.
    """
    run, champion = read_champion(path)
    card = card_of(run, champion)
    if len(card.code) > MAX_INLINE_CODE:
        card = replace(card, code_file=f"{name}.code.txt")
        write_bytes(out / card.code_file, f"{card.code}\n".encode())
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
    cards: Sequence[Card],
    problems: Sequence[tuple[str, str]],
    before: set[str],
) -> set[str]:
    """Write the index, and the record with new and earlier files; return the new files."""
    shown = {card.name for card in cards}
    missing = [(name, why) for name, why in problems if name not in shown]
    title = f"Gallery of {root.resolve().name or root}"
    write_bytes(out / INDEX, index(title, cards, missing))
    written = {name for card in cards for name in (card.page, card.code_file) if name}
    _write_record(out, ranked(cards), before | written)
    return written


def _write_record(out: Path, cards: Iterable[Card], written: Iterable[str]) -> None:
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

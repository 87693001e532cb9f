"""Run folders: the names of their files, and how to create, find and list them.

This module imports nothing heavy, as every command needs it.
"""

import errno
import math
import os
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, count, takewhile
from pathlib import Path

from gaitsim.errors import GaitsimError, RunError
from gaitsim.opening import is_folder
from gaitsim.storage.files.atomic import draft_folder, sweep, sync_folder, write_bytes, writing

RUNS = Path("runs")
EXPERIMENT = "experiment.toml"
START = "start.pickle"
CHECKPOINT, PREVIOUS = "population.pickle", "population.previous.pickle"
HISTORY, BESTS, ALL_SCORES = "history.csv", "bests.bin", "scores.bin"
CHANGING = (EXPERIMENT, CHECKPOINT, PREVIOUS, HISTORY)
"""The files whose times are those of the last change of a run."""
ISLANDS = "islands.csv"
CHECKSUMS, SAVES, PROVENANCE = "checksums.bin", "saves.bin", "provenance.json"
CHAMPIONS, EXPORTS = "champions", "exports"
ADAPTATIONS = "adaptations"
MEASURES = "measures.json"
NOTE, TAGS = "note.txt", "tags.txt"
ONE_COPY = "restore all files of the run from one copy"
"""The remedy for files that do not belong together."""


def command(verb: str, *words: object) -> str:
    """Return a gaitsim command, quoted for a shell."""
    return shlex.join(["gaitsim", verb, *map(str, words)])


def find_run(reference: str) -> Path:
    """Return the folder of a run, given by its path or by its name in `runs/`."""
    paths = [Path(path) for path in (reference, RUNS / reference) if reference]
    for path in paths:
        if holds_run(path):
            return path
    for path in paths:
        if os.path.isfile(path / CHECKPOINT):  # noqa: PTH113
            raise RunError(
                f"the run {path} has lost its {EXPERIMENT}",
                remedy="restore it from a copy of the run; the checkpoint also contains its text",
            )
    for path in paths:
        if os.path.isdir(path):  # noqa: PTH112
            raise RunError(
                f"{path} is not a run: it has no {EXPERIMENT}",
                remedy="'gaitsim runs' lists the runs here",
            )
    known = [run.name for run in list_runs(RUNS)]
    raise RunError(
        f"there is no run {reference!r}"
        + ("" if known else f": {RUNS}/ in this folder has no runs yet"),
        allowed=", ".join(known),
        remedy="give a run's name or the path of its folder; 'gaitsim runs' lists them",
    )


def holds_run(path: Path) -> bool:
    """Return whether a folder is a run, even a damaged one: it has an `experiment.toml`."""
    # Unlike pathlib, os.path does not raise an error for an invalid file name.
    return os.path.lexists(path / EXPERIMENT)


def resolve_run(path: Path, verb: str) -> Path:
    """Return the absolute path of a run's folder, for deleting or renaming it."""
    if path.is_symlink():
        raise RunError(
            f"{path} is a symbolic link to a run",
            allowed="the folder of a run",
            remedy=f"{verb} the run at {path.resolve()}, or {verb} only the link, by hand",
        )
    if not holds_run(path):
        raise RunError(
            f"{path} is not a run: it has no {EXPERIMENT}",
            remedy="'gaitsim runs' lists the runs here",
        )
    return path.resolve()  # a path such as '.' has no name


def truncation_error(run: Path, name: str, found: int, generation: int) -> RunError:
    """Return the error of a file that ends before the generation of the checkpoint."""
    exists = (run / name).exists()
    what = f"{name} ends at generation {found}" if exists else f"{name} is missing"
    return RunError(
        f"{what}, but the checkpoint is of generation {generation}",
        where=str(run / name),
        remedy=ONE_COPY,
    )


def unfinished_error(run: Path) -> RunError:
    """Return the error of a run whose first generation is not finished."""
    return RunError(
        f"the run {run} has no finished generation yet",
        remedy=f"continue it: {command('resume', run)}",
    )


def deleted_or_moved(run: Path) -> RunError:
    """Return the error of a run whose folder disappeared while the run was open."""
    return RunError(
        f"the folder of the run {run} was deleted or moved",
        remedy="start a new run, or resume this one at its new path",
    )


def create_subfolder(run: Path, name: str) -> Path:
    """Return a folder within a run; create it if it is missing."""
    folder = run / name
    with writing(folder):
        if folder.is_symlink():
            raise OSError(errno.ELOOP, "it is a symbolic link")
        folder.mkdir(exist_ok=True)
    return folder


def check_out_folder(folder: Path) -> None:
    """Check, before a long computation, that an output folder exists or can be created."""
    nearest = next(path for path in (folder, *folder.absolute().parents) if os.path.lexists(path))
    if not nearest.is_dir():
        raise RunError(
            f"cannot create the folder {folder}: {nearest} is not a folder",
            remedy="choose another folder",
        )


def create_out_folder(folder: Path) -> None:
    """Create a folder and its parents if they are missing."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)


def exports_folder(run: Path) -> Path:
    """Return the folder for exports of a run; create it if it is missing."""
    folder = create_subfolder(run, EXPORTS)
    check_links(folder, "remove it, or choose another place with --out")
    return folder


def check_links(folder: Path, remedy: str = "remove it") -> None:
    """Check that a folder contains no links to files outside it."""
    with writing(folder):
        for entry in folder.iterdir():
            if entry.is_symlink() and not entry.resolve().is_relative_to(folder.resolve()):
                raise RunError(
                    f"{entry} is a symbolic link that leads out of the folder", remedy=remedy
                )


def champion_file(generation: int) -> str:
    """Return the path of a generation's champion, relative to the run's folder."""
    return f"{CHAMPIONS}/generation-{generation:06d}.pickle"


def champion_generations(run: Path, last: float = math.inf) -> list[int]:
    """Return the generations up to `last` whose champions are kept in a run's folder, in order."""
    if not os.path.lexists(run / CHAMPIONS):
        return []
    folder = create_subfolder(run, CHAMPIONS)
    names = (path.stem for path in folder.glob("generation-*.pickle"))
    matches = (re.fullmatch(r"generation-(\d+)", name) for name in names)
    numbers = sorted(int(match[1]) for match in matches if match)
    return [number for number in numbers if number <= last]


def list_runs(root: Path) -> list[Path]:
    """Return the run folders in `root`, oldest first."""
    found = []
    try:
        # Folders with a leading dot are drafts that `create_run` is still writing.
        for path in root.iterdir() if root.exists() else ():
            if not path.name.startswith(".") and holds_run(path):
                found.append((_time_of(path / EXPERIMENT), path.name, path))
    except OSError as error:
        raise RunError(
            f"cannot list {root}: {error.strerror}", remedy="give a folder that contains runs"
        ) from None
    return [path for *_, path in sorted(found)]


def last_modified(run: Path) -> float:
    """Return the time of the last change of a run's files, seconds since 1970; 0 without files."""
    return max(map(_time_of, (run / name for name in CHANGING)))


def _time_of(file: Path) -> float:
    try:
        return file.stat().st_mtime_ns / 1e9
    except OSError:  # the run has just been deleted
        return 0.0


def create_folder(
    wanted: Path, files: Mapping[str, str | bytes | Iterable[bytes]], folders: Iterable[str] = ()
) -> Path:
    """Create a folder with its content atomically; a number is added to an existing name.

    Args:
        wanted: path of the folder.
        files: contents of files by path relative to the folder, possibly in subfolders; a large
            one in parts.
        folders: names of empty folders to create in it.
    """
    if wanted.name in ("", ".."):
        raise RunError(
            f"cannot create {wanted}: it already exists",
            remedy="give --out the path of a new folder",
        )
    with writing(wanted):
        wanted.parent.mkdir(parents=True, exist_ok=True)
        sweep(wanted.parent)
        for taken in filter(is_folder, takewhile(os.path.lexists, numbered_names(wanted))):
            sweep(taken)
        with draft_folder(wanted.parent) as draft:
            for name in folders:
                (draft / name).mkdir()
            for name, content in files.items():
                (draft / name).parent.mkdir(exist_ok=True)
                data = content.encode() if isinstance(content, str) else content
                if isinstance(data, bytes):
                    write_bytes(draft / name, data, follow=False)
                else:  # the draft becomes visible only as a whole
                    with (draft / name).open("xb") as file:
                        file.writelines(data)
                        os.fsync(file.fileno())
            path = _rename_to_free_name(draft, wanted)
            sync_folder(path.parent)
    return path


def free_name(wanted: Path) -> Path:
    """Return the first free name of a, a-2, a-3, …, which `create_run` would use."""
    return next(path for path in numbered_names(wanted) if not os.path.lexists(path))


def numbered_names(wanted: Path) -> Iterator[Path]:
    """Return the names of `free_name`: a, a-2, a-3, …"""
    others = (wanted.with_name(f"{wanted.name}-{number}") for number in count(2))
    return chain([wanted], others)


def _rename_to_free_name(draft: Path, wanted: Path) -> Path:
    """Rename `draft` to the first free name."""
    while True:
        path = free_name(wanted)
        try:
            return draft.rename(path)
        except OSError:
            if not os.path.lexists(path):  # otherwise another run has just taken the name
                raise


def check_root(root: Path) -> None:
    """Check that a folder can hold runs; only `runs` may be missing, before the first run."""
    if holds_run(root):
        raise GaitsimError(
            f"{root} is a run",
            allowed="a folder that holds runs",
            remedy=command("show", root),
        )
    # Unlike pathlib, os.path accepts names that are invalid for files.
    if root != RUNS and not os.path.exists(root):  # noqa: PTH110
        raise GaitsimError(
            f"folder not found: {root}",
            allowed="a folder that holds runs",
            remedy="'gaitsim runs' lists the runs in runs/",
        )

"""Runs at a glance, cheaply enough to look once a second while others write them."""

import csv
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from gaitsim.errors import GaitsimError, RunError
from gaitsim.experiment import Evolution
from gaitsim.registry import KINDS
from gaitsim.runs.files.folder import CHECKPOINT, EXPERIMENT, HISTORY, PREVIOUS, list_runs
from gaitsim.runs.files.lock import is_locked
from gaitsim.runs.reader import Run
from gaitsim.runs.resume import is_finished
from gaitsim.toml import parse

POINTS = 256
"""How many points a run's curve has at most; at least half as many once there are so many."""
PATIENCE = 10
"""How many times as long as reading took we wait before we read again."""

State = Literal["running", "stopped", "finished", "damaged"]


@dataclass(frozen=True)
class Overview:
    """A run at a glance.

    Attributes:
        path: its folder.
        state: whether a process evolves it now, it can be gone on with, a stop condition
            holds, or it cannot be read.
        plugins: the name of each plugin by kind.
        description: of its experiment.
        seed: of its experiment.
        generation: the last one that is finished.
        generations: how many are planned.
        best: the best score so far that can be compared with the last one's; None before
            the first, and where all failed.
        stage: the number of the stage it is in, from 1.
        seconds: how long it was evolved for.
        changed: when it last changed, in seconds since 1970.
        curve: the best score over the generations, thinned; NaN where all failed.
        problem: why it is damaged.
    """

    path: Path
    state: State
    plugins: Mapping[str, str]
    description: str = ""
    seed: int = 0
    generation: int = 0
    generations: int = 0
    best: float | None = None
    stage: int = 1
    seconds: float = 0.0
    changed: float = 0.0
    curve: tuple[float, ...] = ()
    problem: GaitsimError | None = None

    @property
    def name(self) -> str:
        """Of its folder."""
        return self.path.name


_ODD = (ValueError, IndexError, StopIteration, csv.Error)


class Curve:
    """Best score and time of a history that grows, read from where it was left.

    Neighbours are merged, the better one kept, once there are `POINTS` of them.

    Attributes:
        seconds: how long the generations took.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._clear()

    def _clear(self) -> None:
        self._file = 0  # its number in the file system: another one when it was rewritten
        self._offset = 0
        self._columns: list[int] = []
        self._points: list[float] = []
        self._stride = 1
        self._count = 0
        self.seconds = 0.0

    @property
    def points(self) -> tuple[float, ...]:
        """The best score, every `stride` generations the best of them."""
        return tuple(self._points)

    def read(self) -> None:
        """Read what has been added.

        Raises:
            GaitsimError: it is no history, or cannot be read.
        """
        try:
            try:
                self._read_on()
            except _ODD:
                # Whoever goes on with a killed run writes rows anew that came after its
                # checkpoint, and what was read of them has another length now.
                self._clear()
                self._read_on()
        except _ODD:
            self._clear()
            raise RunError(
                f"{self._path.name} is damaged",
                where=str(self._path),
                remedy="restore it from a copy; the checkpoint beside it is separate",
            ) from None

    def _read_on(self) -> None:
        try:
            with self._path.open("rb") as file:
                found = file.seek(0, 2)
                inode = self._path.stat().st_ino
                if inode != self._file or found < self._offset:
                    self._clear()
                    self._file = inode
                file.seek(self._offset)
                data = file.read()
        except FileNotFoundError:
            self._clear()
            return
        except OSError as error:
            raise RunError(f"cannot read {self._path}: {error.strerror}") from None
        data = data[: data.rfind(b"\n") + 1]
        self._offset += len(data)
        rows = csv.reader(data.decode().splitlines())
        if data and not self._columns:
            names = next(rows)
            self._columns = [names.index(name) for name in ("generation", "best", "seconds")]
        for row in rows:
            number, best, seconds = (float(row[column]) for column in self._columns)
            if number != self._count + 1:
                raise ValueError(number)
            self._add(best if math.isfinite(best) else math.nan)
            self.seconds += seconds

    def _add(self, best: float) -> None:
        if self._count % self._stride == 0:
            self._points.append(best)
        elif not self._points[-1] >= best:  # NaN gives way to any number
            self._points[-1] = best if not math.isnan(best) else self._points[-1]
        self._count += 1
        if len(self._points) == POINTS and self._count % self._stride == 0:
            pairs = zip(self._points[::2], self._points[1::2], strict=True)
            self._points = [a if a >= b or math.isnan(b) else b for a, b in pairs]
            self._stride *= 2


class Watch:
    """Looks at the runs in a folder again and again, and reads only what has changed.

    Args:
        root: the folder.
    """

    def __init__(self, root: Path) -> None:
        self._root = root
        self._seen: dict[Path, _Seen] = {}

    def look(self) -> list[Overview]:
        """The runs there are now, oldest first; it takes no more than what changed is worth.

        Raises:
            RunError: `root` is no folder, or may not be read.
        """
        paths = list_runs(self._root)
        self._seen = {path: self._seen.get(path) or _Seen(path) for path in paths}
        return [found for path in paths if (found := self._seen[path].look()) is not None]


def overview(path: Path) -> Overview | None:
    """One run at a glance; None where it is gone."""
    return _Seen(path).look()


class _Seen:
    """What is known of one run, with what it was read from."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._curve = Curve(path / HISTORY)
        self._signature: tuple[object, ...] = ()
        self._overview: Overview | None = None
        self._finished = False
        self._not_before = 0.0

    def look(self) -> Overview | None:
        signature = tuple(map(_stamp, _files(self._path)))
        if signature[0] is None:
            return None
        now = time.monotonic()
        if self._overview is None or (signature != self._signature and now >= self._not_before):
            self._overview = self._read(max(filter(None, map(_time, signature)), default=0.0))
            self._signature = signature
            self._not_before = now + PATIENCE * (time.monotonic() - now)
        found = self._overview
        if found is None or found.state == "damaged":
            return found
        running = is_locked(self._path)
        state: State = "running" if running else "finished" if self._finished else "stopped"
        if found.state != state:
            found = self._overview = replace(found, state=state)
        return found

    def _read(self, changed: float) -> Overview:
        run = Run(self._path)
        known: dict[str, Any] = {"path": self._path, "changed": changed, "plugins": {}}
        try:
            table = parse(run.experiment_text, str(self._path / EXPERIMENT))
            known["plugins"] = {kind: str(table[kind]["plugin"]) for kind in KINDS}
            known["description"] = str(table.get("description", ""))
            known["seed"] = int(table.get("seed", 0))
            evolution = Evolution.model_validate(table["evolution"])
            known["generations"] = evolution.generations
            found = run.checkpoint()
            if found is not None:
                checkpoint = found[0]
                known["generation"] = checkpoint.generation
                known["stage"] = len(checkpoint.stages) + 1
                best = checkpoint.best_score
                known["best"] = best if math.isfinite(best) else None
                self._finished = is_finished(evolution, checkpoint, run.experiment_text)
            self._curve.read()
        # Pydantic's errors are ValueErrors.
        except (GaitsimError, KeyError, TypeError, ValueError) as error:
            problem = error if isinstance(error, GaitsimError) else _incomplete(self._path)
            return Overview(state="damaged", problem=problem, **known)
        known |= {"curve": self._curve.points, "seconds": self._curve.seconds}
        return Overview(state="stopped", **known)


def _incomplete(path: Path) -> RunError:
    return RunError(
        f"{EXPERIMENT} of the run {path.name} lacks what every experiment has",
        where=str(path / EXPERIMENT),
        remedy="restore it from a copy of the run; the checkpoint holds its text, too",
    )


def _files(path: Path) -> list[Path]:
    return [path / name for name in (EXPERIMENT, CHECKPOINT, PREVIOUS, HISTORY)]


def _stamp(path: Path) -> tuple[int, int, int] | None:
    """By which it is seen whether a file has changed."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def _time(stamp: object) -> float:
    return stamp[0] / 1e9 if isinstance(stamp, tuple) else 0.0

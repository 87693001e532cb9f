"""Displays of an evolving run: a live view, plain lines, or JSON lines."""

import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from gaitsim.cli.display import BEST_SHOWN, Display, Row, stage_line
from gaitsim.cli.live_view import LiveView
from gaitsim.console.printing import echo, output, print_json
from gaitsim.evolution import Generation
from gaitsim.experiment import Experiment
from gaitsim.live.protocol import Best, Snapshot, top_individuals
from gaitsim.runs.files.history import island_bests, row


def display(path: Path, known: Snapshot, json: bool) -> Display:
    """Return the display that suits the output: JSON lines, a terminal or a log."""
    if json:
        return JsonLines(path, known)
    if output().is_terminal:
        return LiveView(path, known)
    return PlainLines(path, known)


def snapshot_of(generation: Generation | None, experiment: Experiment, **more: Any) -> Snapshot:
    """Return the snapshot of a generation for displays; an empty one before the first."""
    generations, islands = experiment.evolution.generations, experiment.islands.number
    if generation is None:
        return Snapshot("running", generations=generations, **more)
    progress, number = generation.progress, generation.number
    bests = tuple(island_bests(generation, islands).tolist()) if islands > 1 else ()
    found = number - progress.stagnation
    return Snapshot(
        "finished" if generation.stop else "running",
        reason=generation.stop,
        generation=number,
        generations=generations,
        stage=progress.stage,
        evaluations=progress.evaluations,
        top=top_individuals(generation.scores, generation.evaluation.terms, BEST_SHOWN),
        islands=bests,
        # A re-evaluated generation has no champion yet.
        champion=Best(found, progress.best_score, ()) if progress.stagnation >= 0 else None,
        **more,
    )


def row_of(generation: Generation, snapshot: Snapshot) -> Row:
    """Return a generation's row of the history, with the best score of each island, if any."""
    islands = list(snapshot.islands)
    return {**row(generation), **({"islands": islands} if islands else {})}


class JsonLines(Display):
    """One object per generation, with the columns of the history, and one per new stage.

    With islands, the objects also hold the best score of each.
    """

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print the number of the stage, its first generation and its changes."""
        print_json({"stage": number, "first": first, "changes": list(changes)})

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Print the rows."""
        for one in rows:
            print_json(one)


class PlainLines(Display):
    """Plain lines for pipes and logs: the first, the last, and one every two seconds."""

    def __init__(
        self, path: Path, known: Snapshot, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(path, known)
        self._clock = clock
        self._printed = -math.inf
        self._row: Row = {}
        echo(f"run {path}")

    def start_stage(
        self, number: int, first: int, changes: Sequence[str], rescored: Snapshot | None
    ) -> None:
        """Print a line."""
        echo(stage_line(number, first, changes))

    def update(self, snapshot: Snapshot, rows: Sequence[Row]) -> None:
        """Print a line if two seconds have passed or the run has ended."""
        now = self._clock()
        self._row = rows[-1] if rows else self._row
        if self._row and (snapshot.ended or now - self._printed > 2):
            self._printed, values = now, self._row
            bests = snapshot.islands
            more = "  islands " + " ".join(f"{b:.4f}" for b in bests) if bests else ""
            echo(
                f"generation {values['generation']}/{snapshot.generations}  "
                f"best {values['best']:.4f}  mean {values['mean']:.4f}  "
                f"diversity {values['diversity']:.3f}{more}",
            )
            self._row = {}

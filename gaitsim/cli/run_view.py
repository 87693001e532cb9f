"""The full description of a run."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim import toml
from gaitsim.cli.summary import champion_of, print_champion, to_dict
from gaitsim.console.printing import notice, output, print_json, print_table
from gaitsim.errors import MissingFunctionError, RunError
from gaitsim.evaluation.worlds import ranges_of
from gaitsim.evolution.transferability import RealityTests
from gaitsim.individual import Individual
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.folder import command
from gaitsim.runs.files.history import FIGURE, best_terms, figures_of
from gaitsim.runs.snapshot import RunSnapshot


def print_run_as_json(run: RunSnapshot) -> None:
    """Print a run as one line of JSON."""
    experiment, history = run.experiment, run.history
    champion = _champion(run)
    members = run.members if history else None
    tests = RealityTests.of(run.finished.state) if history else None
    start = run.start
    print_json(
        {
            "run": str(run.path),
            "note": _note(run),
            "background": process.state if (process := run.process) else None,
            "failure": failure.to_dict() if (failure := run.failure) else None,
            "experiment": experiment.name,
            "seed": experiment.seed,
            "results": run.portability.partition(":")[0],
            "portability": run.portability,
            "plugins": {kind: entry.name for kind, entry in experiment.entries.items()},
            "generation": len(history["best"]) if history else 0,
            "generations": experiment.evolution.generations,
            "evaluations": int(history["evaluations"][-1]) if history else 0,
            "seconds": float(history["seconds"].sum()) if history else 0.0,
            "islands": experiment.islands.model_dump() if experiment.islands.number > 1 else None,
            "worlds": experiment.worlds.model_dump() if experiment.worlds.number else None,
            "start": {"generation": start.generation, "score": start.score} if start else None,
            "stages": [
                {
                    "stage": stage.number,
                    "first": stage.first,
                    "last": stage.last,
                    "changes": [str(change) for change in stage.changes],
                }
                for stage in run.stages
            ],
            "pending": [str(change) for change in run.pending],
            "members": len(members.scores) if members else None,
            "tests": tests.to_dicts() if tests else [],
            "champion": to_dict(champion) if isinstance(champion, Individual) else champion,
            "outside": [entry.name for entry in run.outside],
            "figures": {name: float(history[FIGURE + name][-1]) for name in figures_of(history)},
            "fingerprint": run.fingerprint() if history else None,
        }
    )


def print_run(run: RunSnapshot) -> None:
    """Print a run for people."""
    experiment, history = run.experiment, run.history
    console = output()
    console.print(str(run.path), style="bold")
    console.print(f"{experiment.name}: {experiment.description}")
    if note := _note(run):
        console.print(note, style="italic")
    process, failure = run.process, run.failure
    if process is not None:
        console.print(f"in the background: {process.state}, process {process.pid}")
    if failure is not None:
        console.print(f"Failed in the background: {failure}", style="red")
    parts = "  ".join(f"{kind} {entry.name}" for kind, entry in experiment.entries.items())
    console.print(f"seed {experiment.seed}  {parts}")
    console.print(f"results: {run.portability}")
    for entry in run.outside:
        console.print(f"{entry.notice}.")
    islands = experiment.islands
    if islands.number > 1:
        where = "on a ring" if islands.topology == "ring" else "that are all neighbours"
        console.print(
            f"{islands.number:,} islands {where}; every {islands.every:,} generations the best "
            f"{islands.migrants:,} of each migrate"
        )
    worlds = experiment.worlds
    if worlds.number:
        again = f", redrawn every {worlds.redraw:,} generations" if worlds.redraw else ""
        ranges = ", ".join(
            f"{name} {low:g} to {high:g}" for name, (low, high) in ranges_of(experiment).items()
        )
        which = f"{worlds.number:,} world{'s' * (worlds.number != 1)}{again}"
        console.print(f"{which}, {worlds.combine} of their scores: {ranges}")
    start = run.start
    if start is not None:
        console.print(
            f"started from an individual of generation {start.generation} "
            f"with the score {number(start.score, 4)}"
        )
    if not history:
        again = command("resume", run.path)
        console.print(f"No generation is finished yet. To continue: {again}")
        return
    console.print(
        f"generation {len(history['best'])} of {experiment.evolution.generations}, "
        f"{int(history['evaluations'][-1]):,} evaluations in {history['seconds'].sum():.1f} s"
    )
    for name in ("best", "mean"):
        course = history[name][run.first_comparable - 1 :]
        console.print(f"{name} {sparkline(list(course), 48)} {number(course[-1])}")
    for name in figures_of(history):
        console.print(f"{name} {number(history[FIGURE + name][-1])}")
    _print_stages(run, history)
    _print_members(run)
    _print_tests(run)
    console.print()
    champion = _champion(run)
    if not isinstance(champion, dict):
        print_champion(run, champion)
        return
    score = number(champion["score"], 4)
    console.print(f"Champion of generation {champion['generation']}, score {score}")
    terms = "  ".join(f"{name} {number(value)}" for name, value in champion["terms"].items())
    console.print(f"score = {terms}")


def _champion(run: RunSnapshot) -> Individual | dict[str, Any] | None:
    """Return the champion; values from its row of the history if its Python code is missing."""
    try:
        return champion_of(run)
    except MissingFunctionError:
        generation = run.best_generation or 1
        return {
            "generation": generation,
            "score": float(run.history["best"][generation - 1]),
            "terms": best_terms(run.history, generation),
            "measures": {},
            "units": {},
        }


def _print_members(run: RunSnapshot) -> None:
    """Print the number of members that the search keeps, and the ranges of their values."""
    members = run.members
    if members is None or not len(members.scores):
        return
    count = len(members.scores)
    ranges = "; ".join(
        f"{name} {number(values.min())} to {number(values.max())}"
        for name, values in members.values.items()
    )
    output().print(
        f"{run.experiment.search.keeps} of {count:,} member{'s' * (count != 1)}: {ranges}\n"
        f"List them: {command('members', run.path)}"
    )


def _print_tests(run: RunSnapshot) -> None:
    """Print the tests in reality that the search has learned from, in order."""
    tests = RealityTests.of(run.finished.state)
    if tests is None or not tests.count:
        return
    unit = run.experiment.fitness.unit
    scores = ("in simulation", "in reality", "disparity", "predicted")
    columns = ["generation", *(f"{name}, {unit}" if unit else name for name in scores)]
    rows = [
        [str(row["generation"]), *(number(row[name]) for name in scores)]
        for row in tests.to_dicts()
    ]
    rows[0][-1] = "–"  # the first test has no earlier ones to predict from
    output().print()
    output().print(f"tests in reality, {toml.text(run.experiment.transferability.reality)}:")
    print_table(columns, rows, numbers=columns)


def _note(run: RunSnapshot) -> str:
    """Return the note of a run; print a warning if it cannot be read."""
    try:
        return run.note
    except RunError as error:
        notice(f"Warning: {error.what}")
        return ""


def _print_stages(run: RunSnapshot, history: Mapping[str, NDArray[np.float64]]) -> None:
    """Print the stages of a run if it has several, and pending changes."""
    console = output()
    stages = run.stages
    if len(stages) > 1:
        rows = []
        for stage in stages:
            best = history["best"][stage.first - 1 : stage.last].max()
            changed = "; ".join(map(str, stage.changes))
            span = f"{stage.first} to {stage.last}"
            rows.append([str(stage.number), span, number(best), changed])
        console.print()
        columns = "stage", "generations", "best", "changed"
        print_table(columns, rows, numbers=["stage", "best"])
    if run.pending:
        changed = "; ".join(map(str, run.pending))
        console.print(f"from generation {stages[-1].last + 1}: {changed}")

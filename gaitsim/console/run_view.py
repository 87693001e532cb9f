"""The description of a run and of its champion."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from gaitsim import toml
from gaitsim.console.printing import notice, output, print_json, print_table
from gaitsim.errors import MissingFunctionError, RunError
from gaitsim.evaluation.worlds import describe, ranges_of
from gaitsim.evolution.transferability import RealityTests
from gaitsim.experiment import Experiment
from gaitsim.individual import Individual
from gaitsim.render.terminal.curves import sparkline
from gaitsim.render.terminal.text import number
from gaitsim.storage.files.checkpoint import Start
from gaitsim.storage.files.folder import command
from gaitsim.storage.files.history import FIGURE, best_terms, figures_of
from gaitsim.storage.manage import read_tags
from gaitsim.storage.measured import Measured, read_measured
from gaitsim.storage.snapshot import RunSnapshot


def champion_of(run: RunSnapshot) -> Individual | None:
    """Return the champion of a run; None without a generation, or if all failed."""
    return run.individual() if run.best_generation else None


def measured_of(champion: Individual) -> Measured:
    """Return the measures stored in a champion's run; if they are missing, simulate it."""
    stored = read_measured(champion.source, champion) if champion.source else None
    return stored or Measured.of(champion)


def to_dict(champion: Individual) -> dict[str, Any]:
    """Return a champion as JSON values."""
    measures = measured_of(champion).measures
    return {
        "generation": champion.generation,
        "score": champion.score,
        "terms": dict(champion.terms),
        "dimensions": dict(getattr(champion.body, "dimensions", {})),
        "design": champion.body.design(),
        "measures": {name: one.value for name, one in measures.items()},
        "units": {name: one.unit for name, one in measures.items()},
    }


def print_champion(run: RunSnapshot, champion: Individual | None) -> None:
    """Print the champion's score and measures, or why there is none."""
    console = output()
    if champion is None:
        console.print("Every individual failed, so the run has no champion.")
        reasons = run.checkpoint.reasons if run.checkpoint else {}
        for index, reason in list(reasons.items())[:1]:
            console.print(f"Individual {index}: {reason}")
        return
    console.print(
        f"Champion of generation {champion.generation}, score {number(champion.score, 4)}"
        f"{champion.over_worlds}{'; in its own world' if champion.worlds else ''}:"
    )
    if design := champion.body.design():
        console.print(f"design: {design}")
    measured = measured_of(champion)
    if measured.measures:
        rows = [
            (name, number(value), unit, meaning)
            for name, (value, unit, meaning) in measured.measures.items()
        ]
        print_table(["measure", "value", "", "meaning"], rows, numbers=["value"])
    for warning in measured.warnings:
        console.print(Text(warning, style="yellow"))
    parts = "  ".join(f"{name} {number(value)}" for name, value in champion.terms.items())
    console.print(f"score = {parts}")


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
            "tags": _tags(run),
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
            "worlds": experiment.worlds.model_dump() if experiment.worlds.count else None,
            "start": _start(start) if start else None,
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


def _start(start: Start) -> dict[str, Any]:
    if start.generation:
        return {"generation": start.generation, "score": start.score}
    return {"genomes": len(start.genomes)}


def _worlds(experiment: Experiment) -> str:
    """Return the worlds in which each individual is evaluated, in words."""
    worlds = experiment.worlds
    found = [describe(case) or "own world" for case in worlds.cases]
    if worlds.number:
        again = f", redrawn every {worlds.redraw:,} generations," if worlds.redraw else ""
        ranges = ", ".join(
            f"{name} {low:g} to {high:g}" for name, (low, high) in ranges_of(experiment).items()
        )
        found.append(f"{worlds.number:,} drawn{again} from {ranges}")
    which = f"{worlds.count:,} world{'s' * (worlds.count != 1)}"
    return f"{which}, {worlds.combine} of their scores: {'; '.join(found)}"


def print_run(run: RunSnapshot) -> None:
    """Print a run for people."""
    experiment, history = run.experiment, run.history
    console = output()
    console.print(str(run.path), style="bold")
    console.print(f"{experiment.name}: {experiment.description}")
    if note := _note(run):
        console.print(note, style="italic")
    if tags := _tags(run):
        console.print(f"tags: {', '.join(tags)}")
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
    if experiment.worlds.count:
        console.print(_worlds(experiment))
    start = run.start
    if start is not None:
        individual = f"an individual of generation {start.generation}"
        many = f"{len(start.genomes):,} given genomes"
        console.print(
            f"started from {individual} with the score {number(start.score, 4)}"
            if start.generation
            else f"started from {many if len(start.genomes) > 1 else 'a given genome'}"
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


def _tags(run: RunSnapshot) -> tuple[str, ...]:
    """Return the tags of a run; print a warning if they cannot be read."""
    try:
        return read_tags(run.path)
    except RunError as error:
        notice(f"Warning: {error.what}")
        return ()


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

"""What came of a run: the champion's measures and terms, and what to do next."""

from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.cli.console import number, output, print_json, table
from gaitsim.contracts import Measure, Motion
from gaitsim.errors import RunError
from gaitsim.evaluation import judge
from gaitsim.registry import containing
from gaitsim.runs.directory import Run


def champion_motion(run: Run, genome: np.ndarray[Any, Any]) -> Motion:
    """One genome (genes,), moved: a population of one."""
    with containing(run.experiment.entries["organism"], "moving the champion"):
        return run.experiment.organism.move(genome[None])


def champion_measures(run: Run, motion: Motion) -> dict[str, Measure]:
    """What the body says of its motion."""
    with containing(run.experiment.entries["organism"], "measuring the champion"):
        return dict(run.experiment.organism.measures(motion))


def summarise(path: Path, reason: str, json: bool) -> None:
    """Print how a finished run ended; as one JSON object on request."""
    run = Run(path)
    try:
        generation, score, genome = run.champion()
    except RunError:
        if json:
            print_json({"run": str(path), "finished": reason, "score": None})
        else:
            output().print(f"\n{path}: {reason}. Every individual failed; no score is finite.")
            _say_why(run)
        return
    measures = champion_measures(run, champion_motion(run, genome))
    terms = {k: float(v[0]) for k, v in judge(run.experiment, genome[None]).terms.items()}
    if json:
        print_json(
            {
                "run": str(path),
                "finished": reason,
                "generation": generation,
                "score": score,
                "terms": terms,
                "measures": {name: float(measure.values[0]) for name, measure in measures.items()},
                "fingerprint": run.fingerprint(),
            }
        )
        return
    console = output()
    console.print(f"\n{path}: {reason}", style="bold", markup=False)
    console.print(f"Champion of generation {generation}, score {number(score, 4)}:")
    print_measures(measures, terms)
    console.print("\nNext:")
    for command, purpose in (
        (f"gaitsim show {path}", "the run in full"),
        (f"gaitsim plot {path} --kind fitness", "its fitness curve"),
        (f"gaitsim export {path} --format mat", "the gait for a robot or MATLAB"),
        (f"gaitsim resume {path} --generations {next_goal(run)}", "go on evolving"),
    ):
        console.print(f"  {command}  [dim]# {purpose}[/dim]", soft_wrap=True)


def next_goal(run: Run) -> int:
    """Half as many generations again."""
    return run.experiment.evolution.generations * 3 // 2 + 1


def print_measures(measures: dict[str, Measure], terms: dict[str, float]) -> None:
    """The champion's measures with their units, then the terms of its score."""
    console = output()
    if measures:
        made = table("measure", "value", "", "what it is", numbers=("value",))
        for name, measure in measures.items():
            made.add_row(name, number(float(measure.values[0])), measure.unit, measure.help)
        console.print(made)
    parts = "  ".join(f"{name} {number(value)}" for name, value in terms.items())
    console.print(f"score = {parts}", markup=False)


def _say_why(run: Run) -> None:
    found = run.checkpoint()
    if found is not None and found[0].reasons:
        index, reason = next(iter(found[0].reasons.items()))
        output().print(f"Individual {index}: {reason}", markup=False)

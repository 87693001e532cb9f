"""Print the result of a run: the champion's measures and terms, and commands to run next."""

from collections.abc import Iterator
from typing import Any

from gaitsim.cli.unseen import evaluate_champion
from gaitsim.console.printing import output, print_json, print_table
from gaitsim.gait.changed import can_be_damaged
from gaitsim.individual import Individual
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.explanation import summary_line
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.folder import command
from gaitsim.runs.files.history import FIGURE, figures_of
from gaitsim.runs.snapshot import RunSnapshot


def champion_of(run: RunSnapshot) -> Individual | None:
    """Return the champion of a run; None without a generation, or if all failed."""
    return run.individual() if run.best_generation else None


def to_dict(champion: Individual) -> dict[str, Any]:
    """Return a champion as JSON values."""
    return {
        "generation": champion.generation,
        "score": champion.score,
        "terms": dict(champion.terms),
        "measures": champion.measures,
        "units": {name: one.unit for name, one in champion.measurements.items()},
    }


def summarise(run: RunSnapshot, reason: str, json: bool, workers: int | None = None) -> None:
    """Print how a run ended and its champion; with `json`, as one object.

    The champion of a run over worlds is evaluated in unseen worlds, with `workers` workers.
    """
    champion = champion_of(run)
    if json:
        parts: dict[str, Any] = {"generation": run.generation, "score": None}
        if champion:
            parts = to_dict(champion)
            if unseen := evaluate_champion(run, champion, workers):
                parts["unseen_worlds"] = unseen.statistics()
        print_json(
            {"run": str(run.path), "finished": reason, **parts, "fingerprint": run.fingerprint()}
        )
        return
    console = output()
    console.print(f"\n{run.path}: {reason}", style="bold")
    print_champion(run, champion)
    if champion is None:
        return
    if unseen := evaluate_champion(run, champion, workers):
        console.print(summary_line(unseen))
    view = ArchiveView.of(run.members) if run.experiment.search.keeps == "archive" else None
    if view is not None:
        print_archive(run, view)
    console.print("\nNext:")
    for line, purpose in (
        _next_commands(run) if view is None else _next_commands_of_archive(run, view)
    ):
        console.print(f"  {line}  ", end="", soft_wrap=True)
        console.print(f"# {purpose}", style="dim")


def _next_commands(run: RunSnapshot) -> Iterator[tuple[str, str]]:
    """Yield commands for a finished run, and their purposes."""
    yield command("analyse", run.path), "which gait it is, and what its score consists of"
    if run.experiment.worlds.number:
        unseen = command("analyse", run.path, "--worlds", 100, "--figure", "worlds.png")
        yield unseen, "which conditions hurt, and where"
    yield command("video", run.path), "watch it"
    yield command("plot", run.path, "--kind", "fitness"), "its fitness curve"
    if "joint_angles" in run.experiment.organism.channels:
        yield command("export", run.path, "--format", "mat"), "the gait for a robot or MATLAB"
    yield command("resume", run.path, "--generations", next_goal(run)), "continue evolving"


def _next_commands_of_archive(run: RunSnapshot, view: ArchiveView) -> Iterator[tuple[str, str]]:
    """Yield commands for a finished run that keeps an archive, and their purposes."""
    yield command("plot", run.path, "--kind", "archive"), "the map"
    yield command("plot", run.path, "--kind", "search"), "coverage and QD score"
    yield command("members", run.path, "--out", "atlas.csv"), "the table of all cells"
    if view.best is not None:
        yield (
            command("play", run.path, "--member", view.best),
            "the best gait; other members have other numbers",
        )
    legs = [*run.experiment.organism.leg_joints()]
    if legs and can_be_damaged(run.experiment):
        lost = command("adapt", run.path, "--damage", f"{legs[0]} lost")
        yield lost, "find a gait without a leg"
    yield command("resume", run.path, "--generations", next_goal(run)), "continue evolving"


def print_archive(run: RunSnapshot, view: ArchiveView) -> None:
    """Print how many cells are occupied, and the other figures of the search."""
    shown = [view.coverage]
    for name in figures_of(run.history):
        if name != "coverage":
            value = float(run.history[FIGURE + name][-1])
            shown.append(
                f"{name} {value:,.0f}" if abs(value) >= 1000 else f"{name} {number(value)}"
            )
    output().print(f"Archive: {', '.join(shown)}")


def next_goal(run: RunSnapshot) -> int:
    """Return 1.5 times the planned generations, rounded down, but at least one more."""
    planned = run.experiment.evolution.generations
    return planned + max(1, planned // 2)


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
    if champion.measurements:
        rows = [
            (name, number(value), unit, meaning)
            for name, (value, unit, meaning) in champion.measurements.items()
        ]
        print_table(["measure", "value", "", "meaning"], rows, numbers=["value"])
    parts = "  ".join(f"{name} {number(value)}" for name, value in champion.terms.items())
    console.print(f"score = {parts}")

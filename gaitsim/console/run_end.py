"""The summary at the end of a run: its champion, and what to do next."""

from collections.abc import Iterator
from typing import Any

from gaitsim.console.printing import output, print_json
from gaitsim.console.run_view import champion_of, print_champion, to_dict
from gaitsim.console.unseen import check_champion, evaluate_champion
from gaitsim.gait.changed import can_be_damaged
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.explanation import summary_line
from gaitsim.render.terminal.text import number
from gaitsim.storage.files.folder import command
from gaitsim.storage.files.history import FIGURE, figures_of
from gaitsim.storage.snapshot import RunSnapshot


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
            if checks := check_champion(champion, workers):
                parts["checks"] = checks.to_dict()
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
    if checks := check_champion(champion, workers):
        console.print(checks.summary, style="" if checks.holds else "yellow")
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
    if run.experiment.worlds.count:
        unseen = command("analyse", run.path, "--worlds", 100, "--figure", "worlds.png")
        yield unseen, "which conditions hurt, and where"
    yield command("video", run.path), "watch it"
    yield command("plot", run.path, "--kind", "fitness"), "its fitness curve"
    if "joint_angles" in run.experiment.organism.channels:
        yield command("export", run.path, "--format", "mat"), "the gait for a robot or MATLAB"
    if not run.finished.finished:
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
    if len(legs) > 2 and can_be_damaged(run.experiment):
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

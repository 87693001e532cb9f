"""Print the results of `gaitsim imitate`."""

from collections.abc import Sequence
from math import degrees, sqrt
from pathlib import Path
from typing import Any

from gaitsim.cli.console import notice, number, output, table
from gaitsim.imitation.imitating import Result
from gaitsim.imitation.results import Files
from gaitsim.individual import Individual
from gaitsim.runs.files.folder import command

ENOUGH = 0.9  # of the way forward


def print_results(results: Sequence[Result], files: Files, preset: str = "") -> None:
    """Print expert and imitator side by side, both errors, and the files."""
    first, console = results[0], output()
    expert = first.expert
    run = expert.source or Path(expert.name)
    sizes = first.imitation.imitator.network.sizes
    console.print(
        f"{run}: imitator of the best of generation {expert.generation}, "
        f"network {'-'.join(map(str, sizes))}, {first.settings.activation}",
        style="bold",
        markup=False,
    )
    console.print(
        f"next frame from the expert's: rms error {_degrees(first.one_step)} "
        f"(MSE {first.one_step:.2e} rad²)\n"
        f"on its own for {len(first.imitation.commanded)} frames: {_degrees(first.free_running)} "
        f"from the expert (MSE {first.free_running:.2e} rad²)"
    )
    if first.played is None:
        console.print(
            "This body has no play(): its limits are not checked, and the imitator has no score.",
            style="dim",
        )
    else:
        commanded = first.imitation.commanded.size
        console.print(
            f"{first.beyond_limits:,} of {commanded:,} commanded angles exceeded the body's limits "
            "of angle or speed"
        )
        console.print()
        console.print(_side_by_side(expert, first.played), markup=False)
        kept = first.forward_kept
        if kept is not None:
            console.print(f"It keeps {kept:.1%} of its expert's way forward.")
            if kept < ENOUGH and preset != "steady":
                again = command("imitate", run, "--settings", "steady")
                notice(f"A gait that lasts may need another training: {again}")
    if len(results) > 1:
        console.print()
        console.print(_activations(results), markup=False)
    console.print()
    for path in files.values():
        console.print(str(path), markup=False, soft_wrap=True)


def _side_by_side(expert: Individual, imitator: Individual) -> Any:
    made = table("", "expert", "imitator", "unit", numbers=("expert", "imitator"))
    made.add_row("score", number(expert.score), number(imitator.score), "")
    for name, value in expert.terms.items():
        other = imitator.terms.get(name)
        made.add_row(f"  {name}", number(value), "" if other is None else number(other), "")
    for name, measured in expert.measurements.items():
        other = imitator.measures.get(name)
        reached = "" if other is None else number(other)
        made.add_row(name, number(measured.value), reached, measured.unit)
    return made


def _activations(results: Sequence[Result]) -> Any:
    columns = ("next frame", "on its own", "forward", "score")
    made = table("activation", *columns, numbers=columns)
    for result in results:
        kept = result.forward_kept
        made.add_row(
            result.settings.activation,
            _degrees(result.one_step),
            _degrees(result.free_running),
            "" if kept is None else f"{kept:.1%}".replace("-", "−"),
            "" if result.played is None else number(result.played.score),
        )
    return made


def _degrees(mean_square: float) -> str:
    return f"{degrees(sqrt(mean_square)):.3g}°"

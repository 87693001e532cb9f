"""What `gaitsim imitate` writes and prints."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import degrees, sqrt
from pathlib import Path
from typing import Any

from gaitsim.cli.console import notice, number, output, table
from gaitsim.imitation.imitating import Expert, Result
from gaitsim.imitation.performance import Performance
from gaitsim.runs.files.folder import command

Files = Mapping[str, Path]
FORWARD, ENOUGH = "forward", 0.9


def files_of(folder: Path, format: str, several: bool) -> Files:
    """The files that are written, by what they hold."""
    files = {
        "imitator": folder / "imitator.npz",
        "gait": folder / f"imitator-gait.{format}",
        "error": folder / "imitator-error.png",
    }
    if several:
        files["activations"] = folder / "imitator-activations.png"
    return files


def write_results(expert: Expert, results: Sequence[Result], files: Files) -> None:
    """Write the first result in full, and the errors of all where `files` names a plot of them.

    Raises:
        RunError: a file cannot be written.
    """
    from gaitsim.gait.files.writer import Gait, write_gait
    from gaitsim.imitation.file import save_imitator
    from gaitsim.render.plots import save
    from gaitsim.render.plots.imitation import errors_figure
    from gaitsim.render.plots.labels import heading_of_experiment

    first = results[0]
    learnt = first.imitation
    save_imitator(learnt, files["imitator"])
    score = first.performance.score if first.performance else float("nan")
    gait = Gait(
        learnt.joint_angles, learnt.joint_names, learnt.frame_rate, learnt.generation, score
    )
    write_gait(gait, files["gait"], files["gait"].suffix[1:])
    heading = f"imitator of {heading_of_experiment(expert.individual.experiment)}"
    errors = {result.settings.activation: result.errors for result in results}
    one = {first.settings.activation: first.errors}
    save(errors_figure(one, f"{heading}, {first.settings.activation}"), files["error"])
    if "activations" in files:
        save(errors_figure(errors, heading), files["activations"])


def plain(expert: Expert, results: Sequence[Result], files: Files) -> dict[str, Any]:
    """For JSON: the first result, and those of the other activations."""
    found = {
        "run": str(expert.individual.source),
        "generation": expert.gait.generation,
        "expert": expert.performance.to_dict(),
        **_plain(expert, results[0]),
        "files": {what: str(path) for what, path in files.items()},
    }
    if len(results) > 1:
        found["activations"] = [_plain(expert, result) for result in results]
    return found


def _plain(expert: Expert, result: Result) -> dict[str, Any]:
    return {
        "settings": asdict(result.settings),
        "one_step_mse": result.one_step,
        "free_running_mse": result.free_running,
        "beyond_limits": result.beyond_limits,
        "angles": result.imitation.commanded.size,
        "imitator": result.performance.to_dict() if result.performance else None,
        "forward_kept": _kept(expert, result),
    }


def print_results(
    expert: Expert, results: Sequence[Result], files: Files, preset: str = ""
) -> None:
    """Expert and imitator side by side, both errors, and the files."""
    first, console = results[0], output()
    source = expert.individual.source
    run = source or Path(expert.individual.name)
    sizes = first.imitation.imitator.network.sizes
    console.print(
        f"{run}: imitator of the best of generation {expert.gait.generation}, "
        f"network {'-'.join(map(str, sizes))}, {first.settings.activation}",
        style="bold",
        markup=False,
    )
    console.print(
        f"next frame from the expert's: rms error {_degrees(first.one_step)} "
        f"(MSE {first.one_step:.2e} rad²)\n"
        f"on its own for {len(expert.gait.angles)} frames: {_degrees(first.free_running)} "
        f"from the expert (MSE {first.free_running:.2e} rad²)"
    )
    if first.performance is None:
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
        console.print(_side_by_side(expert.performance, first.performance), markup=False)
        kept = _kept(expert, first)
        if kept is not None:
            console.print(f"It keeps {kept:.1%} of its expert's way forward.")
            if kept < ENOUGH and preset != "steady":
                again = command("imitate", run, "--settings", "steady")
                notice(f"A gait that lasts may need another training: {again}")
    if len(results) > 1:
        console.print()
        console.print(_activations(expert, results), markup=False)
    console.print()
    for path in files.values():
        console.print(str(path), markup=False, soft_wrap=True)


def _side_by_side(expert: Performance, imitator: Performance) -> Any:
    made = table("", "expert", "imitator", "unit", numbers=("expert", "imitator"))
    made.add_row("score", number(expert.score), number(imitator.score), "")
    for name, value in expert.terms.items():
        made.add_row(f"  {name}", number(value), number(imitator.terms[name]), "")
    for name, (value, unit) in expert.measures.items():
        other = imitator.measures.get(name)
        made.add_row(name, number(value), number(other[0]) if other else "", unit)
    return made


def _activations(expert: Expert, results: Sequence[Result]) -> Any:
    columns = ("next frame", "on its own", "forward", "score")
    made = table("activation", *columns, numbers=columns)
    for result in results:
        judged, kept = result.performance, _kept(expert, result)
        made.add_row(
            result.settings.activation,
            _degrees(result.one_step),
            _degrees(result.free_running),
            "" if kept is None else f"{kept:.1%}".replace("-", "−"),
            "" if judged is None else number(judged.score),
        )
    return made


def _degrees(mean_square: float) -> str:
    return f"{degrees(sqrt(mean_square)):.3g}°"


def _kept(expert: Expert, result: Result) -> float | None:
    """The share of the expert's way forward, where the body measures it and it went forward."""
    if result.performance is None or FORWARD not in expert.performance.measures:
        return None
    whole, _ = expert.performance.measures[FORWARD]
    reached = result.performance.measures.get(FORWARD)
    return reached[0] / whole if reached and whole > 0 else None

"""Write the results of trainings: the imitator, its gait, and plots of the errors."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gaitsim.gait.files.writer import write_gait
from gaitsim.imitation.file import save_imitator
from gaitsim.imitation.imitating import Result
from gaitsim.individual import Individual

Files = Mapping[str, Path]


def files_of(folder: Path, format: str, several: bool) -> Files:
    """Return the files to write, by what they hold."""
    files = {
        "imitator": folder / "imitator.npz",
        "gait": folder / f"imitator-gait.{format}",
        "error": folder / "imitator-error.png",
    }
    if several:
        files["activations"] = folder / "imitator-activations.png"
    return files


def write_results(results: Sequence[Result], files: Files) -> None:
    """Write the first result in full, and a plot of the errors of all where `files` names one.

    Raises:
        RunError: a file cannot be written.
    """
    from gaitsim.render.plots.imitation import errors_figure
    from gaitsim.render.plots.labels import heading_of_run
    from gaitsim.render.plots.style import save

    first = results[0]
    save_imitator(first.imitation, files["imitator"])
    write_gait(first.imitation.gait, files["gait"], files["gait"].suffix[1:])
    heading = f"imitator of {heading_of_run(first.expert.name, first.expert.experiment)}"
    errors = {result.settings.activation: result.errors for result in results}
    one = {first.settings.activation: first.errors}
    save(errors_figure(one, f"{heading}, {first.settings.activation}"), files["error"])
    if "activations" in files:
        save(errors_figure(errors, heading), files["activations"])


def to_dict(results: Sequence[Result], files: Files) -> dict[str, Any]:
    """Return the first result, and those of the other activations, for JSON."""
    expert = results[0].expert
    found = {
        "run": str(expert.source),
        "generation": expert.generation,
        "expert": _performance(expert),
        **_result(results[0]),
        "files": {what: str(path) for what, path in files.items()},
    }
    if len(results) > 1:
        found["activations"] = [_result(result) for result in results]
    return found


def _result(result: Result) -> dict[str, Any]:
    return {
        "settings": asdict(result.settings),
        "one_step_mse": result.one_step,
        "free_running_mse": result.free_running,
        "beyond_limits": result.beyond_limits,
        "angles": result.imitation.commanded.size,
        "imitator": _performance(result.played) if result.played else None,
        "forward_kept": result.forward_kept,
    }


def _performance(individual: Individual) -> dict[str, object]:
    return {
        "score": individual.score,
        "terms": dict(individual.terms),
        "measures": individual.measures,
    }

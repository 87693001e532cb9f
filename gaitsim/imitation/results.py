"""Write the results of training: the imitator, its gait, and plots of the errors."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import write_gait
from gaitsim.imitation.file import save_imitator
from gaitsim.imitation.imitating import Result
from gaitsim.individual import Individual

Files = Mapping[str, Path]


def files_of(
    folder: Path, format: str, *, several: bool = False, video: bool = False, gait: Path | None
) -> Files:
    """Return the files to write, by their content.

    Args:
        folder: folder to write to.
        format: format of the imitator's gait file.
        several: whether to plot the errors of several trainings.
        video: whether to include a video.
        gait: imitated gait file, which must not be replaced.
    """
    files = {
        "imitator": folder / "imitator.npz",
        "gait": folder / f"imitator-gait.{format}",
        "error": folder / "imitator-error.png",
    }
    if several:
        files["activations"] = folder / "imitator-activations.png"
    if video:
        files["video"] = folder / "imitator.mp4"
    if gait is not None and any(path.absolute() == gait.absolute() for path in files.values()):
        raise GaitsimError(
            f"the imitator's files would replace the imitated gait file {gait}",
            remedy="choose a different folder: --out FOLDER",
        )
    return files


def write_results(results: Sequence[Result], files: Files) -> None:
    """Write the first result, and a plot of the errors of all results if `files` includes one."""
    from gaitsim.render.plots.imitation import errors_figure
    from gaitsim.render.plots.style import save

    first = results[0]
    save_imitator(first.imitation, files["imitator"])
    write_gait(first.imitation.gait, files["gait"], files["gait"].suffix[1:])
    errors = {result.settings.activation: result.errors for result in results}
    one = {first.settings.activation: first.errors}
    save(errors_figure(one, first.heading), files["error"])
    if "activations" in files:
        save(errors_figure(errors, f"imitator of {first.expert.heading}"), files["activations"])


def to_dict(results: Sequence[Result], files: Files) -> dict[str, Any]:
    """Return the first result, and with several activations the results of all, for JSON."""
    expert = results[0].expert
    found = {
        "run": None if expert.file else str(expert.source),
        "gait": str(expert.file) if expert.file else None,
        "body": expert.body or None,
        "generation": expert.gait.generation or None,
        "expert": _performance(expert.individual),
        "expert_beyond_limits": results[0].expert_beyond_limits,
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
        "imitator": _performance(result.played),
        "forward_kept": result.forward_kept,
    }


def _performance(individual: Individual | None) -> dict[str, object] | None:
    if individual is None:
        return None
    return {
        "score": individual.score,
        "terms": dict(individual.terms),
        "measures": individual.measures,
    }

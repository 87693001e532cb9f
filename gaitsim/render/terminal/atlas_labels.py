"""Labels for the map of an archive: axes with units, and a summary with the coverage."""

from gaitsim.individual import Individual
from gaitsim.render.archive_view import ArchiveView
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.history import FIGURE
from gaitsim.runs.snapshot import RunSnapshot


def axis_labels(individual: Individual, view: ArchiveView) -> dict[str, str]:
    """Return labels with units for the score and the axes of an archive, by name.

    Args:
        individual: a member of the archive.
        view: the archive.
    """
    units = {name: individual.unit_of(name) for name in ("score", *view.names)}
    return {name: f"{name} ({unit})" if unit else name for name, unit in units.items()}


def summary(run: RunSnapshot, view: ArchiveView) -> str:
    """Return generation, elites, coverage and, if the search records it, the QD score."""
    score = run.history.get(f"{FIGURE}QD score")
    parts = [
        f"generation {run.generation:,}",
        view.coverage,
        *([f"QD score {number(float(score[-1]), 1)}"] if score is not None else []),
    ]
    return "  ".join(parts)

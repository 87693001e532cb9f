"""Pages that play the champions of a run."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.gait import check_folder
from gaitsim.plugin.pictures import THEMES, default_speed, fastest_movement
from gaitsim.plugin.runs import Individual, RunSnapshot, code_of, holds_run, write_bytes
from gaitsim_page.clips import clip_data, finite_or_none
from gaitsim_page.document import document, program_version

MAX_BODIES = 12  # maximum number of individuals side by side
MAX_CURVE_POINTS = 500  # maximum number of points of the fitness curve
FPS = 30.0  # pictures per second that the default speed assumes, as slow computers draw
SLOWEST = 1 / 32  # lowest speed that a page offers
MAX_BYTES = 100_000_000  # maximum bytes of a page


def write_page(
    individuals: Sequence[Individual], path: Path, run: RunSnapshot | None = None
) -> str:
    """Write a page that plays individuals side by side; return a one-line description.

    Args:
        individuals: one or more individuals.
        path: path of the file.
        run: run whose fitness curve to show; None for the run of the first individual, if any.
    """
    check_folder(path)
    data = page(individuals, run)
    check_size(data, path, "choose fewer individuals, or a shorter motion")
    write_bytes(path, data)
    one = individuals[0]
    what = one.label if len(individuals) == 1 else f"{len(individuals)} champions side by side"
    seconds = max((len(i.skeleton.segments) - 1) / i.skeleton.frame_rate for i in individuals)
    return f"{what}, {seconds:.1f} s, {len(data) / 1e3:,.0f} kB, for any browser"


def check_size(data: bytes, path: Path, remedy: str) -> None:
    """Raise a `GaitsimError` for a page that is too large for browsers."""
    if len(data) > MAX_BYTES:
        raise GaitsimError(
            f"a page of {len(data):,} bytes is too large for browsers",
            where=str(path),
            allowed=f"at most {MAX_BYTES:,} bytes",
            remedy=remedy,
        )


def page(
    individuals: Sequence[Individual],
    run: RunSnapshot | None = None,
    *,
    embedded: bool = False,
) -> bytes:
    """Return a page that plays individuals, in UTF-8.

    Args:
        individuals: one or more individuals.
        run: run whose fitness curve to show; None for the run of the first individual, if any.
        embedded: whether the page is part of another page, such as a notebook.
    """
    data = page_data(individuals, run)
    if embedded:
        data["page"] = {"embedded": True}
    return document(data["title"], "player", data, description=data["description"])


def page_data(individuals: Sequence[Individual], run: RunSnapshot | None = None) -> dict[str, Any]:
    """Return the data of a page that plays individuals.

    Args:
        individuals: one or more individuals.
        run: run whose fitness curve to show; None for the run of the first individual, if any.
    """
    if len(individuals) > MAX_BODIES:
        raise GaitsimError(
            f"{len(individuals)} bodies are too many for a page",
            where="--generations",
            allowed=f"at most {MAX_BODIES}",
        )
    experiment = individuals[0].experiment
    return {
        "title": individuals[0].name,
        "description": _described(individuals) or experiment.description,
        "theme": themes(),
        "clips": [clip_data(one) for one in individuals],
        "speed": default_speed(
            fastest_movement((one.skeleton for one in individuals), FPS), FPS, SLOWEST
        ),
        "curve": _curve(run or _run_of(individuals[0])),
        "code": _code(individuals),
        "made": program_version(),
    }


def _described(individuals: Sequence[Individual]) -> str:
    """Return the notes about individuals; '' without any."""
    return "; ".join(f"{one.label}: {one.note}" for one in individuals if one.note)


def themes() -> dict[str, Any]:
    """Return the colours of both themes, as data for pages."""
    return {name: asdict(theme) for name, theme in THEMES.items()}


def _code(individuals: Sequence[Individual]) -> str:
    """Return the challenge code of the individual with the best score, or ''."""
    try:
        return code_of(max(individuals, key=lambda one: one.score))
    except GaitsimError:
        return ""


def _run_of(individual: Individual) -> RunSnapshot | None:
    """Return the run on disk that contains an individual; None if there is none."""
    source = individual.source
    return RunSnapshot(source) if source is not None and holds_run(source) else None


def _curve(run: RunSnapshot | None) -> dict[str, list[Any]]:
    """Return the best scores of at most `MAX_CURVE_POINTS` generations, evenly spaced."""
    history = run.history if run else {}
    best = history.get("best", np.empty(0))
    last = len(best) - 1
    every = (
        sorted({round(one) for one in np.linspace(0, last, MAX_CURVE_POINTS)}) if len(best) else []
    )
    return {
        "generation": [int(history["generation"][i]) for i in every],
        "best": [finite_or_none(float(best[i])) for i in every],
    }

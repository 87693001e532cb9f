"""Plots for papers and screens; drawn without a display."""

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gaitsim.errors import GaitsimError, RunError
from gaitsim.runs.atomic import write_bytes
from gaitsim.runs.directory import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
# Okabe & Ito (2008): told apart by colour-blind readers, too.
BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"


def plot_fitness(run: Run, path: Path) -> None:
    """Best, mean and spread of the scores over the generations.

    Raises:
        RunError: no generation is finished yet, or the file cannot be written.
        GaitsimError: the file's name ends with no known format.
    """
    from matplotlib.figure import Figure

    history = run.history
    if not history:
        raise RunError(
            f"the run {run.path} has no finished generation yet",
            remedy=f"go on with it: gaitsim resume {run.path}",
        )
    generations, best, mean, spread = (
        history[name] for name in ("generation", "best", "mean", "spread")
    )
    figure = Figure(figsize=(5.0, 3.2), layout="constrained")
    axes = figure.subplots()
    axes.fill_between(
        generations,
        mean - spread,
        mean + spread,
        color=BLUE,
        alpha=0.15,
        linewidth=0,
        label="mean ± standard deviation",
    )
    axes.plot(generations, mean, color=BLUE, linewidth=1.2, label="mean")
    axes.plot(generations, best, color=ORANGE, linewidth=1.6, label="best")
    axes.set_xlabel("generation")
    axes.set_ylabel(f"score ({run.experiment.entries['fitness'].name})")
    axes.set_title(f"{run.experiment.name}, seed {run.experiment.seed}", fontsize="medium")
    axes.set_xlim(1, max(2, generations[-1]))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.3, linewidth=0.5)
    finite = np.concatenate([best, mean])
    if not np.isfinite(finite).all():
        axes.text(
            0.5,
            0.02,
            "generations without a finite score are left out",
            transform=axes.transAxes,
            ha="center",
            fontsize="x-small",
        )
    axes.legend(frameon=False, fontsize="small", loc="lower right")
    save(figure, path)


def save(figure: "Figure", path: Path) -> None:
    """Write a figure at one stroke, in the format that the name ends with."""
    format = path.suffix.removeprefix(".").lower()
    if format not in FORMATS:
        raise GaitsimError(
            f"{path} does not end with a format that can be drawn",
            allowed=", ".join(f".{known}" for known in FORMATS),
        )
    if not path.parent.is_dir():
        raise RunError(
            f"cannot write {path}: there is no folder {path.parent}", remedy="make it first"
        )
    drawn = io.BytesIO()
    figure.savefig(drawn, format=format, dpi=200)
    write_bytes(path, drawn.getvalue())

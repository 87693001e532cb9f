"""Plots for papers and screens; drawn without a display."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.export.gait import check_folder
from gaitsim.runs.atomic import write_bytes
from gaitsim.runs.reader import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("png", "svg", "pdf")
_UNDATED: dict[str, dict[str, Any]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
# Okabe & Ito (2008): told apart by colour-blind readers, too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
BLUE, ORANGE, *_ = COLOURS


def plot_fitness(run: Run, path: Path) -> None:
    """Best, mean and spread of the scores over the generations.

    Raises:
        RunError: no generation is finished yet, or the file cannot be written.
        GaitsimError: the file's name ends with no known format.
    """
    from matplotlib.figure import Figure

    history = run.history
    if not history:
        raise run.unfinished()
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
    # Names are no mathematics, whatever dollar signs they hold.
    axes.set_ylabel(f"score ({run.experiment.entries['fitness'].name})", parse_math=False)
    title = f"{run.experiment.name}, seed {run.experiment.seed}"
    axes.set_title(title, fontsize="medium", parse_math=False)
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
    from matplotlib import rc_context

    format = path.suffix.removeprefix(".").lower()
    if format not in FORMATS:
        raise GaitsimError(
            f"{path} does not end with a format that can be drawn",
            allowed=", ".join(f".{known}" for known in FORMATS),
        )
    check_folder(path)
    drawn = io.BytesIO()
    # The same picture is the same file: without dates, and names in it that are not at random.
    with rc_context({"svg.hashsalt": "gaitsim"}):
        figure.savefig(drawn, format=format, dpi=200, metadata=_UNDATED[format])
    write_bytes(path, drawn.getvalue())

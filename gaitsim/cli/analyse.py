"""`gaitsim analyse`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from gaitsim.cli.console import echo, print_json, wrote
from gaitsim.cli.gait_view import print_gait
from gaitsim.cli.options import BestOf, Json, RunName
from gaitsim.cli.progress_bar import Progress
from gaitsim.cli.why_view import print_robustness, print_why
from gaitsim.errors import GaitsimError
from gaitsim.gait import Gait, analyse_gait, robustness, to_dict
from gaitsim.gait.files.reader import individual_of, read_gait
from gaitsim.gait.robustness import Robustness
from gaitsim.gait.score_breakdown import changes, course, in_words
from gaitsim.individual import Individual
from gaitsim.render.plots import check_target
from gaitsim.render.plots.gait import plot_gait
from gaitsim.runs.files.folder import find_run
from gaitsim.runs.reader import Run


def analyse(
    run: RunName,
    generation: BestOf = None,
    gait: Annotated[
        Path | None,
        typer.Option(help="Joint angles to play on the run's body: .npz, .csv or .mat."),
    ] = None,
    perturb: Annotated[
        bool, typer.Option("--perturb", help="Play it again with late and inexact servos.")
    ] = False,
    figure: Annotated[
        Path | None, typer.Option(help="PNG, SVG or PDF of footfalls, phases and stability.")
    ] = None,
    json: Json = False,
) -> None:
    """Say which gait emerged, and why it scored.

    [bold]Examples[/bold]

    gaitsim analyse spider

    gaitsim analyse spider --perturb

    gaitsim analyse spider --generation 10 --figure gait.pdf

    gaitsim analyse spider --gait my-gait.csv --json
    """
    if figure is not None:
        check_target(figure)
    opened = Run(find_run(run))
    individual = _individual(opened, generation, gait)
    history = opened.history
    found = analyse_gait(
        individual.skeleton, individual.joint_angles, dynamic=individual.experiment.organism.dynamic
    )
    if figure is not None:
        plot_gait(found, individual.title, figure)
        wrote(figure)
    robust = None
    if perturb:
        with Progress("perturbing the gait", "kinds") as progress:
            robust = robustness.perturb(
                individual, _first_best(history, individual), progress.expect, progress.advance
            )
    if json:
        print_json(_to_dict(opened, individual, found, robust, figure))
        return
    print_gait(individual, found)
    print_why(individual, history)
    if robust is not None:
        print_robustness(robust)
    if figure is not None:
        echo(f"\n{figure}")


def _individual(run: Run, generation: int | None, gait: Path | None) -> Individual:
    if gait is None:
        return run.individual(generation)
    if generation is not None:
        raise GaitsimError(
            "--generation and --gait each say what to analyse", remedy="give one of them"
        )
    return individual_of(read_gait(gait), run.experiment)


def _first_best(history: Mapping[str, NDArray[np.float64]], individual: Individual) -> float | None:
    """Return the best score of the first generation with the individual's fitness, if any."""
    if not history:
        return None
    generation = individual.generation or len(history["best"])
    return float(history["best"][changes(history, generation)[0] - 1])


def _to_dict(
    run: Run, individual: Individual, found: Gait, robust: Robustness | None, figure: Path | None
) -> dict[str, Any]:
    history, generation = run.history, individual.generation or None
    return {
        "run": str(run.path),
        "subject": individual.title,
        "generation": generation,
        "score": individual.replayed_score,
        "recorded_score": individual.score if generation else None,
        "terms": individual.replayed_terms,
        **to_dict.gait(found),
        "terms_over_time": to_dict.course(course(individual)),
        "terms_over_generations": (
            None if generation is None else to_dict.changes(*changes(history, generation))
        ),
        "why": list(in_words(individual.replayed_terms, history, generation)),
        "robustness": to_dict.robustness(robust) if robust else None,
        "figure": str(figure) if figure else None,
    }

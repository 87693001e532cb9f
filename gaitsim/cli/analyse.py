"""`gaitsim analyse`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gaitsim.cli.console import echo
from gaitsim.cli.run import Json

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from gaitsim.individual import Individual
    from gaitsim.runs.reader import Run


def analyse(
    run: Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")],
    generation: Annotated[
        int | None, typer.Option(min=1, help="The best of this generation. Default: of all.")
    ] = None,
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
    from gaitsim.cli.console import wrote
    from gaitsim.cli.progress_bar import Progress
    from gaitsim.gait import analyse_gait
    from gaitsim.gait.robustness import perturb as perturbed
    from gaitsim.runs.files.folder import find_run
    from gaitsim.runs.reader import Run

    if figure is not None:
        from gaitsim.render.plots import check_target

        check_target(figure)
    opened = Run(find_run(run))
    individual = _individual(opened, generation, gait)
    history = opened.history
    found = analyse_gait(
        individual.skeleton, individual.joint_angles, dynamic=individual.experiment.organism.dynamic
    )
    if figure is not None:
        from gaitsim.render.plots.gait import plot_gait

        plot_gait(found, individual.title, figure)
        wrote(figure)
    robustness = None
    if perturb:
        with Progress("perturbing the gait", "kinds") as progress:
            robustness = perturbed(
                individual, _first_best(history, individual), progress.expect, progress.advance
            )
    if json:
        from gaitsim.cli.console import print_json

        print_json(_plain(opened, individual, found, robustness, figure))
        return
    from gaitsim.cli.gait_view import print_gait
    from gaitsim.cli.why_view import print_robustness, print_why

    print_gait(individual, found)
    print_why(individual, history)
    if robustness is not None:
        print_robustness(robustness)
    if figure is not None:
        echo(f"\n{figure}")


def _individual(run: "Run", generation: int | None, gait: Path | None) -> "Individual":
    from gaitsim.errors import GaitsimError
    from gaitsim.gait.files.reader import individual_of, read_gait

    if gait is None:
        return run.individual(generation)
    if generation is not None:
        raise GaitsimError(
            "--generation and --gait each say what to analyse", remedy="give one of them"
        )
    return individual_of(read_gait(gait), run.experiment)


def _first_best(
    history: "Mapping[str, NDArray[np.float64]]", individual: "Individual"
) -> float | None:
    """The best score of the first generation that was judged as the individual is, if any."""
    from gaitsim.gait.score_breakdown import changes

    if not history:
        return None
    generation = individual.generation or len(history["best"])
    return float(history["best"][changes(history, generation)[0] - 1])


def _plain(
    run: "Run", individual: "Individual", found: Any, robustness: Any, figure: Path | None
) -> dict[str, Any]:
    from gaitsim.gait import to_dict as plain
    from gaitsim.gait.score_breakdown import changes, course, in_words

    history, generation = run.history, individual.generation or None
    return {
        "run": str(run.path),
        "subject": individual.title,
        "generation": generation,
        "score": individual.replayed_score,
        "recorded_score": individual.score if generation else None,
        "terms": individual.replayed_terms,
        **plain.gait(found),
        "terms_over_time": plain.course(course(individual)),
        "terms_over_generations": (
            None if generation is None else plain.changes(*changes(history, generation))
        ),
        "why": list(in_words(individual.replayed_terms, history, generation)),
        "robustness": plain.robustness(robustness) if robustness else None,
        "figure": str(figure) if figure else None,
    }

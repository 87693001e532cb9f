"""`gaitsim analyse`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitsim.cli.options import (
    BestOf,
    Damage,
    Json,
    MemberOf,
    RunName,
    Workers,
    World,
    Worlds,
    WorldSeed,
)
from gaitsim.console.printing import echo, output, print_json, report_files, status
from gaitsim.console.progress_bar import Progress

if TYPE_CHECKING:
    from gaitsim.gait import GaitAnalysis
    from gaitsim.gait.unseen import UnseenResults
    from gaitsim.individual import Choice, Individual
    from gaitsim.runs.snapshot import RunSnapshot


def analyse(
    run: RunName,
    generation: BestOf = None,
    member: MemberOf = None,
    damage: Damage = None,
    world: World = None,
    engine: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Physics engine for the robot, such as 'bullet'; with --physics, for the body's "
            "version in rigid-body physics.",
        ),
    ] = None,
    gait: Annotated[
        Path | None,
        typer.Option(
            help="Analyse the joint angles in this file (.npz, .csv or .mat) instead of the run's "
            "own gait; the run's body plays them."
        ),
    ] = None,
    perturb: Annotated[
        bool,
        typer.Option(
            "--perturb",
            help="Repeat the gait with delayed, slow and inaccurate servos, mirrored, and with "
            "half the time step, and report how the score changes.",
        ),
    ] = False,
    physics: Annotated[
        bool,
        typer.Option(
            "--physics",
            help="Also play the gait on the body's twin, which is its version in rigid-body "
            "physics, and compare the two.",
        ),
    ] = False,
    worlds: Worlds = None,
    world_seed: WorldSeed = None,
    workers: Workers = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            help="Plot footfalls, phases and stability to a PNG, SVG or PDF file; with "
            "--worlds, plot the results by world and condition."
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Report which gait evolved and how its score is made up.

    [bold]Examples[/bold]

    gaitsim analyse spider

    gaitsim analyse spider --perturb

    gaitsim analyse spider --physics

    gaitsim analyse spider --damage "L2 lost" --physics

    gaitsim analyse walker --world "friction 0.4"

    gaitsim analyse quadruped --engine bullet

    gaitsim analyse walker --worlds 100 --figure worlds.png

    gaitsim analyse spider --generation 10 --figure gait.pdf

    gaitsim analyse spider --gait my-gait.csv --json
    """
    with status("Simulating the champion …" if gait is None else f"Playing {gait} …"):
        # These imports take most of the start-up time.
        from gaitsim.cli.analysis_view import (
            print_gait,
            print_robustness,
            print_score_breakdown,
            print_section,
        )
        from gaitsim.cli.parsing import parse_body_changes, parse_individual
        from gaitsim.cli.unseen import check_worlds, evaluate_with_progress
        from gaitsim.gait import analyse_individual
        from gaitsim.gait.robustness import measure_robustness
        from gaitsim.gait.to_dict import analysis_to_dict
        from gaitsim.render.plots.style import check_target
        from gaitsim.render.terminal.explanation import (
            compare_engines,
            compare_with_twin,
            world_results,
        )
        from gaitsim.runs.files.folder import find_run
        from gaitsim.runs.snapshot import RunSnapshot

        if figure is not None:
            check_target(figure)
        changed = parse_body_changes(damage, world)
        check_worlds(worlds, world_seed)
        opened = RunSnapshot(find_run(run))
        individual = changed(_individual(opened, parse_individual(generation, member), gait))
        history = opened.history
        found = analyse_individual(individual)
    unseen = None
    if worlds is not None:
        unseen = evaluate_with_progress(individual, worlds, world_seed, workers=workers)
    if figure is not None:
        _plot(individual, found, unseen, figure)
        report_files(figure)
    with status("Simulating other physics …"):
        twin, elsewhere = _other_simulations(individual, physics, engine)
    robustness = None
    if perturb:
        with Progress("perturbing the gait", "kinds") as progress:
            robustness = measure_robustness(individual, history, progress.expect, progress.advance)
    if json:
        analysis = analysis_to_dict(individual, found, history, robustness, twin, elsewhere)
        print_json(
            {
                "run": str(opened.path),
                **analysis,
                "unseen_worlds": unseen.to_dict() if unseen else None,
                "figure": str(figure) if figure else None,
            }
        )
        return
    print_gait(individual, found)
    print_score_breakdown(individual, history)
    if robustness is not None:
        print_robustness(robustness)
    sections = [compare_with_twin(individual, twin)] if twin else []
    sections += [compare_engines(individual, elsewhere)] if elsewhere else []
    for section in (*sections, *(world_results(unseen) if unseen else ())):
        output().print()
        print_section(section)
    if figure is not None:
        echo(f"\n{figure}")


def _plot(
    individual: "Individual", found: "GaitAnalysis", unseen: "UnseenResults | None", path: Path
) -> None:
    with status(f"Plotting {path.name} …"):
        from gaitsim.render.plots.gait import plot_gait
        from gaitsim.render.plots.style import save
        from gaitsim.render.plots.worlds import heading_of_worlds, worlds_figure

        if unseen is None:
            plot_gait(found, individual.title, path)
        else:
            save(worlds_figure(unseen, heading_of_worlds(unseen, individual.title)), path)


def _other_simulations(
    individual: "Individual", physics: bool, engine: str | None
) -> "tuple[Individual | None, Individual | None]":
    """Return the gait on the twin, and the gait in an engine without a twin.

    Each is None if it is not requested.
    """
    from gaitsim.gait import play_on_twin
    from gaitsim.gait.changed import in_engine

    if not physics:
        return None, in_engine(individual, engine) if engine else None
    twin = play_on_twin(individual)
    return in_engine(twin, engine) if engine else twin, None


def _individual(run: "RunSnapshot", choice: "Choice", gait: Path | None) -> "Individual":
    from gaitsim.cli.parsing import not_combinable
    from gaitsim.gait.gait_files import play_gait, read_gait
    from gaitsim.individual import Member

    if gait is None:
        return run.individual(choice)
    if choice is not None:
        option = "--member" if isinstance(choice, Member) else "--generation"
        raise not_combinable(option, "--gait")
    return play_gait(read_gait(gait), run.experiment)

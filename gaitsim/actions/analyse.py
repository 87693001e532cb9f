"""`gaitsim analyse`."""

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.actions.action import (
    JSON,
    RUN,
    WORKERS,
    WORLD_SEED,
    OneIndividual,
    argument,
)
from gaitsim.contracts.plugin import option

if TYPE_CHECKING:
    from gaitsim.gait import GaitAnalysis
    from gaitsim.gait.worlds import UnseenResults
    from gaitsim.individual import Individual


class Analyse(OneIndividual):
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

    title: ClassVar[str] = "Analysis"

    run: str = argument(RUN, "RUN")
    engine: str | None = option(
        None,
        "physics engine for the robot, such as 'bullet'; with --physics, for the body's version in "
        "rigid-body physics",
        placeholder="NAME",
    )
    perturb: bool = option(
        False,
        "repeat the gait with delayed, slow and inaccurate servos, mirrored, and with half the "
        "time step, and report how the score changes",
    )
    physics: bool = option(
        False,
        "also play the gait on the body's twin, which is its version in rigid-body physics, and "
        "compare the two",
    )
    worlds: int | None = option(
        None,
        "evaluate the gait in N unseen worlds, such as 100: worlds with randomly drawn conditions. "
        "Report how far it moves, how often it falls, and which condition harms it most",
        placeholder="N",
    )
    world_seed: int | None = WORLD_SEED
    workers: int | None = WORKERS
    figure: Path | None = option(
        None,
        "plot footfalls, phases and stability to a PNG, SVG or PDF file; with --worlds, plot the "
        "results by world and condition",
        placeholder="FILE",
        written=True,
    )
    json_lines: bool = JSON

    def do(self) -> None:
        """Print the report."""
        from functools import partial

        from gaitsim.console.printing import echo, output, print_json, report_files, status
        from gaitsim.console.progress_bar import Progress

        with status("Simulating the champion …" if self.gait is None else f"Playing {self.gait} …"):
            from gaitsim.console.analysis_view import (
                print_gait,
                print_score_breakdown,
                print_section,
            )
            from gaitsim.console.unseen import check_worlds, with_progress
            from gaitsim.gait import (
                analyse_individual,
                check_gait,
                compare_blind,
                evaluate_unseen,
            )
            from gaitsim.gait.robustness import measure_robustness
            from gaitsim.gait.to_dict import analysis_to_dict
            from gaitsim.render.plots.style import check_target
            from gaitsim.render.terminal.explanation import (
                check_results,
                compare_engines,
                compare_with_twin,
                feedback_results,
                perturbation_results,
                world_results,
            )
            from gaitsim.storage.snapshot import RunSnapshot

            if self.figure is not None:
                check_target(self.figure)
            check_worlds(self.worlds, self.world_seed)
            opened = RunSnapshot.find(self.run)
            individual = self.changed(opened.individual(self.choice))
            history = opened.history
            found = analyse_individual(individual)
        unseen = None
        if self.worlds is not None:
            unseen = with_progress(
                "unseen worlds",
                partial(
                    evaluate_unseen,
                    individual,
                    self.worlds,
                    seed=self.world_seed or 0,
                    workers=self.workers,
                ),
            )
        checks = with_progress(
            "checking whether the gait holds",
            partial(check_gait, individual, workers=self.workers),
        )
        feedback = with_progress(
            "walking with and without reflexes",
            partial(compare_blind, individual, workers=self.workers),
        )
        if self.figure is not None:
            _plot(individual, found, unseen, self.figure)
            report_files(self.figure)
        with status("Simulating other physics …"):
            twin, elsewhere = _other_simulations(individual, self.physics, self.engine)
        robustness = None
        if self.perturb:
            with Progress("perturbing the gait", "kinds") as progress:
                robustness = measure_robustness(
                    individual, history, progress.expect, progress.advance
                )
        if self.json_lines:
            analysis = analysis_to_dict(individual, found, history, robustness, twin, elsewhere)
            print_json(
                {
                    "run": str(opened.path),
                    **analysis,
                    "checks": checks.to_dict() if checks else None,
                    "feedback": feedback.to_dict() if feedback else None,
                    "unseen_worlds": unseen.to_dict() if unseen else None,
                    "figure": str(self.figure) if self.figure else None,
                }
            )
            return
        print_gait(individual, found)
        print_score_breakdown(individual, history)
        sections = [perturbation_results(robustness)] if robustness else []
        sections += [check_results(checks)] if checks else []
        sections += [feedback_results(feedback)] if feedback else []
        sections += [compare_with_twin(individual, twin)] if twin else []
        sections += [compare_engines(individual, elsewhere)] if elsewhere else []
        for section in (*sections, *(world_results(unseen) if unseen else ())):
            output().print()
            print_section(section)
        if self.figure is not None:
            echo(f"\n{self.figure}")

    def changed(self, individual: "Individual") -> "Individual":
        """Return an individual with the chosen damage and world; the engine is only compared."""
        return super(Analyse, self.model_copy(update={"engine": None})).changed(individual)


def _plot(
    individual: "Individual", found: "GaitAnalysis", unseen: "UnseenResults | None", path: Path
) -> None:
    from gaitsim.console.printing import status

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

"""`gaitsim show`."""

from typing import Annotated

import typer

from gaitsim.cli.run import Json


def show(
    run: Annotated[str, typer.Argument(help="Name of a run under runs/, or its folder.")],
    fingerprint: Annotated[
        bool,
        typer.Option(
            "--fingerprint", help="Only the SHA-256 of population, scores and history, times apart."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Show a run in full: what it is made of, how far it is, and its champion.

    [bold]Examples[/bold]

    gaitsim show spider

    gaitsim show spider --fingerprint
    """
    from gaitsim.cli.console import notice, number, output, print_json
    from gaitsim.cli.progress import sparkline
    from gaitsim.cli.summary import champion_measures, champion_motion, print_measures
    from gaitsim.evaluation import judge
    from gaitsim.runs.directory import Run, find_run

    opened = Run(find_run(run))
    if fingerprint:
        print(opened.fingerprint())
        return
    experiment = opened.experiment
    found = opened.checkpoint()
    if found is not None and found[1]:
        notice(f"Warning: {found[1]}")
    generation, score, genome = opened.champion()
    measures = champion_measures(opened, champion_motion(opened, genome))
    terms = {k: float(v[0]) for k, v in judge(experiment, genome[None]).terms.items()}
    history = opened.history
    if json:
        print_json(
            {
                "run": str(opened.path),
                "experiment": experiment.name,
                "seed": experiment.seed,
                "plugins": {kind: entry.name for kind, entry in experiment.entries.items()},
                "generation": len(history["best"]),
                "generations": experiment.evolution.generations,
                "evaluations": int(history["evaluations"][-1]),
                "seconds": float(history["seconds"].sum()),
                "champion": {
                    "generation": generation,
                    "score": score,
                    "terms": terms,
                    "measures": {name: float(m.values[0]) for name, m in measures.items()},
                },
                "fingerprint": opened.fingerprint(),
            }
        )
        return
    console = output()
    console.print(str(opened.path), style="bold", markup=False)
    console.print(f"{experiment.name}: {experiment.description}", markup=False)
    parts = "  ".join(f"{kind} {entry.name}" for kind, entry in experiment.entries.items())
    console.print(f"seed {experiment.seed}  {parts}", markup=False)
    console.print(
        f"generation {len(history['best'])} of {experiment.evolution.generations}, "
        f"{int(history['evaluations'][-1]):,} evaluations in {history['seconds'].sum():.1f} s"
    )
    for name in ("best", "mean"):
        console.print(
            f"{name} {sparkline(list(history[name]), 48)} {number(history[name][-1])}",
            markup=False,
        )
    console.print(f"\nChampion of generation {generation}, score {number(score, 4)}:")
    print_measures(measures, terms)

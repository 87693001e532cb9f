"""One generation of the preset fly, one trial: 100 flies × 3 s, 1 ms steps, 10 ms commands.

It is compared with one worker, with one fly at a time, and with real time.
"""

from timing import medians, milliseconds, print_figure, print_machine

from gaitsim.contracts import Results
from gaitsim.evaluation import Evaluator, evaluate
from gaitsim.evolution import ask, first_population
from gaitsim.experiment import load_experiment

BUDGET = 0.020  # seconds


def main() -> None:
    """Print the figures."""
    print_machine()
    experiment = load_experiment("fly-genetic", {"organism.trials": 1})
    genomes = first_population(experiment)
    flown = 100 * 3.0
    with Evaluator(experiment) as every, Evaluator(experiment, 1) as one:
        every.prepare()
        scores = every.evaluate(genomes).scores
        together, alone = medians(
            lambda: every.evaluate(genomes), lambda: one.evaluate(genomes), repeats=40
        )
        bred, single = medians(
            lambda: ask(experiment, experiment.space(), {}, Results(genomes, scores), 2)[0],
            lambda: evaluate(experiment, genomes[:1]),
            repeats=20,
        )
    print_figure("evaluating", milliseconds(together), f"budget {milliseconds(BUDGET)}")
    print_figure("", f"{flown / together:,.0f} × real time")
    print_figure("one worker", milliseconds(alone), f"{alone / together:.1f} ×")
    print_figure(
        "a hundred flies one by one", milliseconds(100 * single), f"{100 * single / together:.1f} ×"
    )
    print_figure("breeding", milliseconds(bred))


if __name__ == "__main__":
    main()

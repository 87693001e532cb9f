"""`gaitsim compare --worlds`: rank runs by their results in the same unseen worlds."""

from collections.abc import Mapping, Sequence

from gaitsim.console.printing import notice, output, print_json, print_table
from gaitsim.console.unseen import evaluate_with_progress
from gaitsim.errors import GaitsimError
from gaitsim.evaluation.worlds import Ranges
from gaitsim.gait.unseen import UnseenResults
from gaitsim.individual import Individual
from gaitsim.render.terminal.explanation import (
    format_or_dash,
    format_percent,
    format_spans,
    format_strongest,
)
from gaitsim.runs.files.folder import find_run
from gaitsim.study.in_worlds import Ranking, rank_in_worlds
from gaitsim.study.statistics import CONFIDENCE


def rank_runs(
    runs: Sequence[str],
    number: int,
    seed: int | None,
    workers: int | None,
    unused: Mapping[str, object],
    json: bool,
) -> None:
    """Evaluate the champions of runs in the same unseen worlds, and print their ranking.

    Args:
        runs: names or folders of runs.
        number: number of worlds.
        seed: seed of the worlds.
        workers: number of parallel workers.
        unused: values by name of options that do not apply; a value that was given is an error.
        json: whether to print one JSON object.
    """
    if given := [name for name, value in unused.items() if value]:
        raise GaitsimError(
            f"--worlds ranks existing runs, and cannot be combined with {' and '.join(given)}",
            allowed="--world-seed, --workers and --json",
        )

    def evaluate(label: str, champion: Individual, ranges: Ranges) -> UnseenResults:
        return evaluate_with_progress(
            champion, number, seed, workers=workers, ranges=ranges, what=label
        )

    paths = [find_run(one) for one in runs]
    found = rank_in_worlds(paths, number, seed=seed or 0, evaluate=evaluate)
    if json:
        print_json(found.to_dict())
    else:
        _print(found, number)


def _print(found: Ranking, number: int) -> None:
    console = output()
    first = found.runs[0].unseen
    unit = f"{first.measure} {first.unit}".rstrip()
    interval = f"{100 * CONFIDENCE:.0f} % CI"
    for note in found.notes:
        notice(note)
    title = f"Champions in the same {number:,} unseen worlds, {unit}"
    console.print(title, style="bold")
    rows = [
        (
            one.label,
            format_or_dash(one.unseen.worst_tenth, 3),
            _range(one.low, one.high),
            format_or_dash(one.unseen.median, 3),
            format_or_dash(one.unseen.nominal.result, 3),
            format_percent(one.unseen.kept(one.unseen.worst_tenth)),
            f"{one.unseen.falls:,}",
            format_strongest(one.unseen),
        )
        for one in found.runs
    ]
    numbers = "worst tenth", interval, "median", "nominal", "of nominal", "falls"
    print_table(["run", *numbers, "worst condition"], rows, numbers)
    console.print("\nDifferences of the worst tenths", style="bold")
    pairs = [
        (
            f"{pair.first} − {pair.second}",
            format_or_dash(pair.difference, 3),
            _range(pair.low, pair.high),
            "yes" if pair.differs else "no",
        )
        for pair in found.pairs
    ]
    print_table(["pair", "difference", interval, "differs"], pairs, ("difference", interval))
    console.print(
        "\nWorst tenth: the mean of the worst tenth of the results. Of nominal: that mean divided "
        "by the nominal result.\nThe intervals come from resampling the worlds, equally for both "
        "runs of a pair; they describe these champions,\nnot repeats of the runs.\n"
        f"Worlds: seed {first.seed}; {', '.join(format_spans(first))}.",
        style="dim",
        soft_wrap=True,
    )


def _range(low: float, high: float) -> str:
    return f"{format_or_dash(low, 3)} to {format_or_dash(high, 3)}"

"""Print the results of `gaitsim imitate`."""

from collections.abc import Sequence
from math import degrees, sqrt

from gaitsim.console.printing import notice, output, print_table
from gaitsim.imitation.imitating import Files, Result
from gaitsim.individual import Individual
from gaitsim.render.terminal.text import number
from gaitsim.runs.files.folder import command

ENOUGH = 0.9  # share of the expert's distance forward


def print_results(
    results: Sequence[Result], files: Files, preset: str = "", body: str | None = None
) -> None:
    """Print expert and imitator side by side, both errors, and the files.

    Args:
        results: results of the trainings; the first is printed in full.
        files: files that were written.
        preset: name of the training settings.
        body: value of `--body`.
    """
    first, console = results[0], output()
    expert = first.expert
    console.print(
        f"{expert.title}: imitator, network {first.sizes}, {first.settings.activation}",
        style="bold",
        markup=False,
    )
    console.print(
        f"predicting the expert's next frame: RMS error {_degrees(first.one_step)} "
        f"(MSE {first.one_step:.2e} rad²)\n"
        f"on its own for {len(first.imitation.commanded)} frames: RMS error "
        f"{_degrees(first.free_running)} (MSE {first.free_running:.2e} rad²)"
    )
    if first.played is None:
        console.print(
            "This body cannot play joint angles: its limits are not checked, and the imitator has "
            "no score.",
            style="dim",
        )
    else:
        commanded = first.imitation.commanded.size
        console.print(
            f"{first.beyond_limits:,} of {commanded:,} commanded angles exceeded the body's limits "
            "of angle or speed"
        )
        if first.expert_beyond_limits:
            console.print(
                f"{first.expert_beyond_limits:,} angles of the gait file exceed these limits, too; "
                "the values below are for the gait as the body plays it"
            )
        console.print()
        assert expert.individual is not None, "a body that plays the imitator plays its expert"
        _print_side_by_side(expert.individual, first.played)
        kept = first.forward_kept
        if kept is not None:
            console.print(f"The imitator covers {kept:.1%} of the expert's distance forward.")
            if kept < ENOUGH and preset != "steady":
                words = ("--body", body) if body else ()
                again = command("imitate", expert.source, *words, "--settings", "steady")
                notice(f"For a gait that lasts, try other training settings: {again}")
    if len(results) > 1:
        console.print()
        _print_activations(results)
    console.print()
    for path in files.values():
        console.print(str(path), soft_wrap=True)


def _print_side_by_side(expert: Individual, imitator: Individual) -> None:
    rows: list[tuple[str, float, float | None, str]]
    rows = [("score", expert.score, imitator.score, "")]
    rows += [(f"  {name}", one, imitator.terms.get(name), "") for name, one in expert.terms.items()]
    rows += [
        (name, measured.value, imitator.measures.get(name), measured.unit)
        for name, measured in expert.measurements.items()
    ]
    print_table(
        ["", "expert", "imitator", "unit"],
        [
            [name, number(one), "" if other is None else number(other), unit]
            for name, one, other, unit in rows
        ],
        numbers=["expert", "imitator"],
    )


def _print_activations(results: Sequence[Result]) -> None:
    rows = []
    for result in results:
        kept = result.forward_kept
        row = (
            result.settings.activation,
            _degrees(result.one_step),
            _degrees(result.free_running),
            "" if kept is None else f"{kept:.1%}".replace("-", "−"),
            "" if result.played is None else number(result.played.score),
        )
        rows.append(row)
    numbers = "next frame", "on its own", "forward", "score"
    print_table(["activation", *numbers], rows, numbers)


def _degrees(mean_square: float) -> str:
    return f"{degrees(sqrt(mean_square)):.3g}°"

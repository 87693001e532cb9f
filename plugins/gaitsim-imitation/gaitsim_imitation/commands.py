"""`gaitsim imitate`."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import degrees, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from gaitsim.plugin import Activation, GaitFormat, OutputActivation, TrainingPreset, option
from gaitsim.plugin.commands import JSON, ChosenIndividual, argument

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Individual
    from gaitsim_imitation.expert import Expert
    from gaitsim_imitation.imitating import Files, Result
    from gaitsim_imitation.learning import TrainingSettings

ENOUGH = 0.9  # share of the expert's distance forward


class Imitate(ChosenIndividual):
    """Train a network to imitate the champion or a gait file, and evaluate the gait that the
    network generates.

    The network learns to predict each frame of joint angles from the frame before. Then it
    generates a whole gait from the first frame, which is evaluated like the original. Ctrl-C stops
    without writing anything.

    [bold]Examples[/bold]

    gaitsim imitate spider

    gaitsim imitate spider --settings steady --seed 3

    gaitsim imitate spider --compare-activations --output same

    gaitsim imitate spider --video

    gaitsim export spider --out bestGait.mat

    gaitsim imitate bestGait.mat --body spider
    """

    title: ClassVar[str] = "Imitation network"
    menu: ClassVar[str] = "More"

    run: str = argument(
        "name of a run in runs/, or its folder; or a gait file: .mat, .npz or .csv",
        "RUN|GAIT",
        shown=True,
    )
    body: str | None = option(
        None,
        "body that plays the gait file: a preset, an experiment or robot file, or a run folder",
        unset="the body of the run that exported the file, or of the preset with the same joint "
        "names",
        placeholder="NAME|FILE|RUN",
        completion="preset_names",
    )
    settings: TrainingPreset = option(
        "source",
        "training settings: 'source' has a fixed learning rate; 'steady' has noisy inputs and a "
        "falling learning rate, for a gait that lasts",
    )
    activation: Activation | None = option(
        None, "activation of the hidden layer", unset="'leaky-relu'"
    )
    output: OutputActivation | None = option(
        None,
        "activation of the outputs: 'linear' for none (the default), 'same' for that of the hidden "
        "layer",
    )
    hidden: int | None = option(None, "number of hidden neurons", ge=1, le=4096, unset="48")
    epochs: int | None = option(
        None,
        "number of passes over the training data",
        ge=1,
        le=1_000_000,
        unset="1000; with --settings steady, 3000",
    )
    learning_rate: float | None = option(
        None,
        "learning rate",
        ge=1e-9,
        le=10,
        unset="0.008; with --settings steady, 0.02 falling to 0",
    )
    seed: int = option(
        0, "seed of the initial weights, the order of the samples and the noise", ge=0
    )
    compare_activations: bool = option(
        False, "train with all four activations, and plot their errors"
    )
    video: bool = option(
        False,
        "also make a video: first the training error, then the network's gait beside the imitated "
        "gait",
    )
    format: GaitFormat = option("mat", "format of the file of the network's gait")
    out: Path | None = option(
        None,
        "folder to write to; created if missing",
        unset="the run's exports folder, or the folder of the gait file",
        placeholder="FOLDER",
    )
    json_lines: bool = JSON

    @classmethod
    def check(cls, individual: Individual) -> None:
        """Check that the gait can be imitated."""
        from gaitsim_imitation.expert import expert_of

        expert_of(individual)

    def do(self) -> None:
        """Train, and write the results."""
        from gaitsim.plugin.commands import (
            Progress,
            all_or_nothing,
            notice,
            print_json,
            report_files,
        )
        from gaitsim.plugin.runs import check_out_folder, create_out_folder, require_play
        from gaitsim_imitation.expert import find_expert
        from gaitsim_imitation.imitating import files_of, imitation_film, to_dict, write_results
        from gaitsim_imitation.learning import ACTIVATIONS, SETTINGS

        if self.out is not None:
            check_out_folder(self.out)
        options = ("activation", "output", "hidden", "epochs", "learning_rate", "seed")
        given: Mapping[str, Any] = {name: getattr(self, name) for name in options}
        chosen = replace(
            SETTINGS[self.settings],
            **{name: value for name, value in given.items() if value is not None},
        )
        expert = find_expert(self.run, self.body, self.choice)
        if expert.body and self.body is None and not self.json_lines:
            notice(f"Using the body of {expert.body}. To use a different one, give --body.")
        if self.video:
            require_play(expert.experiment)
        files = files_of(
            self.out or expert.folder(),
            self.format,
            several=self.compare_activations,
            video=self.video,
            gait=expert.file,
        )
        names = [chosen.activation]
        if self.compare_activations:
            names += [name for name in ACTIVATIONS if name != chosen.activation]
        with all_or_nothing():
            results = _train(
                expert, [replace(chosen, activation=name) for name in names], quiet=self.json_lines
            )
            if self.out is not None:
                create_out_folder(self.out)
            if self.video:
                film = imitation_film(results[0])
                with Progress(files["video"].name, "pictures", len(film)) as progress:
                    film.write(files["video"], progress.advance)
        write_results(results, files)
        report_files(*files.values())
        if self.json_lines:
            print_json(to_dict(results, files))
        else:
            _print_results(results, files, self.settings, self.body)


def _train(expert: Expert, trainings: list[TrainingSettings], quiet: bool) -> list[Result]:
    """Train with each of the settings, with a progress bar."""
    from gaitsim.plugin.commands import Progress, notice, status
    from gaitsim_imitation.imitating import imitate_expert
    from gaitsim_imitation.learning import prepare

    found: list[Result] = []
    start = time.monotonic()
    with status("Preparing: the first training compiles its kernel …"):
        prepare()
    if time.monotonic() - start > 1 and not quiet:
        notice("Prepared; the next training reuses the compiled kernel.")
    for settings in trainings:
        label = f"training, {settings.activation}"
        log = "" if quiet else f"{label}: {settings.epochs} epochs"
        with Progress(label, "epochs", settings.epochs, log=log) as progress:
            found.append(imitate_expert(expert, settings, progress.advance))
    return found


def _print_results(results: Sequence[Result], files: Files, preset: str, body: str | None) -> None:
    """Print expert and imitator side by side, both errors, and the files.

    Only the first of the results is printed in full.
    """
    from gaitsim.plugin.commands import notice, output
    from gaitsim.plugin.runs import command

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
    from gaitsim.plugin.commands import print_table
    from gaitsim.plugin.pictures import number

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
    from gaitsim.plugin.commands import print_table
    from gaitsim.plugin.pictures import number

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

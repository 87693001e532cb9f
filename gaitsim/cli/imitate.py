"""`gaitsim imitate`."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gaitsim.choices import Activation, GaitFormat, OutputActivation, TrainingPreset
from gaitsim.cli import completion
from gaitsim.cli.options import BestOf, Json, MemberOf
from gaitsim.cli.parsing import parse_individual
from gaitsim.console.interrupts import all_or_nothing
from gaitsim.console.printing import notice, print_json, report_files, status
from gaitsim.console.progress_bar import Progress
from gaitsim.runs.files.folder import check_out_folder, create_out_folder

if TYPE_CHECKING:
    from gaitsim.imitation.expert import Expert
    from gaitsim.imitation.imitating import Result
    from gaitsim.imitation.learning import TrainingSettings


def imitate(
    run: Annotated[
        str,
        typer.Argument(
            metavar="RUN|GAIT",
            help="Name of a run in runs/, or its folder; or a gait file: .mat, .npz or .csv.",
            autocompletion=completion.run_names,
        ),
    ],
    generation: BestOf = None,
    member: MemberOf = None,
    body: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE|RUN",
            help="Body that plays the gait file: a preset, an experiment or robot file, or a run "
            "folder. Default: the body of the run that exported the file, or of the preset with "
            "the same joint names.",
            autocompletion=completion.preset_names,
        ),
    ] = None,
    settings: Annotated[
        TrainingPreset,
        typer.Option(
            help="Training settings: 'source' has a fixed learning rate; 'steady' has noisy "
            "inputs and a falling learning rate, for a gait that lasts."
        ),
    ] = "source",
    activation: Annotated[
        Activation | None,
        typer.Option(help="Activation of the hidden layer. Default: 'leaky-relu'."),
    ] = None,
    output: Annotated[
        OutputActivation | None,
        typer.Option(
            help="Activation of the outputs: 'linear' for none (the default), 'same' for that of "
            "the hidden layer."
        ),
    ] = None,
    hidden: Annotated[
        int | None, typer.Option(min=1, max=4096, help="Number of hidden neurons. Default: 48.")
    ] = None,
    epochs: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=1_000_000,
            help="Number of passes over the training data. Default: 1000; with --settings steady, "
            "3000.",
        ),
    ] = None,
    learning_rate: Annotated[
        float | None,
        typer.Option(
            min=1e-9,
            max=10,
            help="Learning rate. Default: 0.008; with --settings steady, 0.02 falling to 0.",
        ),
    ] = None,
    seed: Annotated[
        int,
        typer.Option(
            min=0, help="Seed of the initial weights, the order of the samples and the noise."
        ),
    ] = 0,
    compare_activations: Annotated[
        bool,
        typer.Option(
            "--compare-activations", help="Train with all four activations, and plot their errors."
        ),
    ] = False,
    video: Annotated[
        bool,
        typer.Option(
            "--video",
            help="Also make a video: first the training error, then the network's gait beside the "
            "imitated gait.",
        ),
    ] = False,
    format: Annotated[
        GaitFormat, typer.Option(help="Format of the file of the network's gait.")
    ] = "mat",
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Folder to write to; created if missing. Default: the run's exports folder, or "
            "the folder of the gait file.",
        ),
    ] = None,
    json: Json = False,
) -> None:
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
    from gaitsim.cli.imitation_view import print_results
    from gaitsim.evaluation.playing import require_play
    from gaitsim.imitation.expert import find_expert
    from gaitsim.imitation.imitating import files_of, imitation_film, to_dict, write_results
    from gaitsim.imitation.learning import ACTIVATIONS, SETTINGS

    if out is not None:
        check_out_folder(out)
    given: Mapping[str, Any] = {
        "activation": activation,
        "output": output,
        "hidden": hidden,
        "epochs": epochs,
        "learning_rate": learning_rate,
        "seed": seed,
    }
    chosen = replace(
        SETTINGS[settings], **{name: value for name, value in given.items() if value is not None}
    )
    expert = find_expert(run, body, parse_individual(generation, member))
    if expert.body and body is None and not json:
        notice(f"Using the body of {expert.body}. To use a different one, give --body.")
    if video:
        require_play(expert.experiment)
    files = files_of(
        out or expert.folder(),
        format,
        several=compare_activations,
        video=video,
        gait=expert.file,
    )
    names = [chosen.activation]
    if compare_activations:
        names += [name for name in ACTIVATIONS if name != chosen.activation]
    with all_or_nothing():
        results = _train(expert, [replace(chosen, activation=name) for name in names], quiet=json)
        if out is not None:
            create_out_folder(out)
        if video:
            film = imitation_film(results[0])
            with Progress(files["video"].name, "pictures", len(film)) as progress:
                film.write(files["video"], progress.advance)
    write_results(results, files)
    report_files(*files.values())
    if json:
        print_json(to_dict(results, files))
    else:
        print_results(results, files, settings, body)


def _train(expert: Expert, trainings: list[TrainingSettings], quiet: bool) -> list[Result]:
    """Train with each of the settings, with a progress bar."""
    from gaitsim.imitation.imitating import imitate_expert
    from gaitsim.imitation.learning import prepare

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

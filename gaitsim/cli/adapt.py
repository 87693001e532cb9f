"""`gaitsim adapt`."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gaitsim.adaptation.settings import MOST_TRIALS, AdaptationSettings
from gaitsim.choices import DAMAGE_HELP, GaitFormat
from gaitsim.cli.completion import run_names
from gaitsim.cli.options import Json, Workers
from gaitsim.console import INTERRUPTED
from gaitsim.console.interrupts import interruptible
from gaitsim.console.printing import echo, notice, output, report_files
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.runs.files.folder import command, exports_folder, find_run

if TYPE_CHECKING:
    from gaitsim.adaptation.adaptation import Adaptation, Place
    from gaitsim.cli.adaptation_view import AdaptationView
    from gaitsim.runs.snapshot import RunSnapshot


_trials = partial(typer.Option, rich_help_panel="How trials are chosen")
_report = partial(typer.Option, rich_help_panel="Report on every leg loss")
_robot = partial(typer.Option, rich_help_panel="Trials on a real robot")
DEFAULT = AdaptationSettings()


def adapt(
    atlas: Annotated[
        str,
        typer.Argument(
            metavar="ATLAS",
            help="Run that holds the atlas: a run of map-elites, by name or folder.",
            autocompletion=run_names,
        ),
    ],
    damage: Annotated[
        list[str] | None,
        typer.Option(metavar="TEXT", help=f"Simulate {DAMAGE_HELP}; may be repeated."),
    ] = None,
    physics: Annotated[
        bool,
        typer.Option(
            "--physics",
            help="Run the trials on the body's twin, which is its version in rigid-body physics.",
        ),
    ] = False,
    measure: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Measure to maximise. Default: 'forward', the distance walked forward in metres.",
        ),
    ] = None,
    trials: Annotated[
        int | None,
        _trials(
            min=1, max=MOST_TRIALS, help=f"Maximum number of trials. Default: {DEFAULT.trials}."
        ),
    ] = None,
    stop: Annotated[
        float | None,
        _trials(
            help="Stop once the best trial reaches this share of the best value predicted for any "
            f"gait. Default: {DEFAULT.stop}."
        ),
    ] = None,
    kappa: Annotated[
        float | None,
        _trials(
            help="Weight of uncertainty when choosing a gait; larger values explore more. "
            f"Default: {DEFAULT.kappa}."
        ),
    ] = None,
    length_scale: Annotated[
        float | None,
        _trials(
            help="Distance over which a trial affects the predictions for other gaits, as a share "
            f"of the range of each axis of the atlas. Default: {DEFAULT.length_scale}."
        ),
    ] = None,
    noise: Annotated[
        float | None,
        _trials(
            help="Assumed variance of a measurement, in units in which the best value in the atlas "
            f"is 1. Default: {DEFAULT.noise}."
        ),
    ] = None,
    interactive: Annotated[
        bool,
        _robot(
            "--interactive",
            help="Write a gait file, ask for the robot's result, and repeat with the next gait.",
        ),
    ] = False,
    measured: Annotated[
        str | None,
        _robot(
            metavar="NUMBER",
            help="Record the measured result of the proposed gait and propose the next gait, "
            "for use in scripts.",
        ),
    ] = None,
    format: Annotated[GaitFormat, _robot(help="Format of the gait files.")] = "mat",
    name: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Name of the adaptation. Default: derived from the damage, or 'robot'.",
        ),
    ] = None,
    fresh: Annotated[
        bool,
        typer.Option("--fresh", help="Start over: delete the earlier trials of this adaptation."),
    ] = False,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Plot the trials to a PNG, SVG or PDF file, chosen by its extension.",
        ),
    ] = None,
    report: Annotated[
        Path | None,
        _report(
            metavar="FOLDER",
            help="Adapt to the loss of each leg in turn; write tables and figures to this folder.",
        ),
    ] = None,
    pairs: Annotated[
        bool, _report("--pairs", help="Also adapt to the loss of each pair of legs.")
    ] = False,
    workers: Workers = None,
    json: Json = False,
) -> None:
    """Find a gait for a damaged body in a few trials, guided by an atlas.

    An atlas holds the best gait for each way of using the legs; see 'gaitsim atlas'. A Gaussian
    process predicts how each of these gaits performs on the damaged body, and the most promising
    gait is tried next. Without --damage and --physics, the command proposes gaits to try on your
    robot. Repeat the command to continue an adaptation.

    [bold]Examples[/bold]

    gaitsim adapt spider-atlas --damage "L2 lost"

    gaitsim adapt spider-atlas --damage "R1 femur stuck 20" --physics

    gaitsim adapt spider-atlas --interactive

    gaitsim adapt spider-atlas --name leg-gone

    gaitsim adapt spider-atlas --name leg-gone --measured 1.3

    gaitsim adapt spider-atlas --report losses --pairs --physics
    """
    from gaitsim.adaptation.adaptation import default_name, normalise_damage
    from gaitsim.adaptation.prior import DEFAULT_MEASURE
    from gaitsim.cli.adaptation_view import AdaptationView, write_report
    from gaitsim.legged.damage import damage_options
    from gaitsim.render.plots.adaptation import adaptation_figure
    from gaitsim.render.plots.style import check_target, save
    from gaitsim.runs.snapshot import RunSnapshot

    place: Place = "physics" if physics else "simulation" if damage else "robot"
    _check(place, interactive, measured, json)
    value = None if measured is None else _number(measured)
    if figure is not None:
        check_target(figure)
    run = RunSnapshot(find_run(atlas))
    damaged = normalise_damage(damage or ())
    given = {
        key: value
        for key, value in {
            "trials": trials,
            "stop": stop,
            "kappa": kappa,
            "length_scale": length_scale,
            "noise": noise,
        }.items()
        if value is not None
    }
    if report is not None or pairs:
        others = damage or interactive or measured or name or fresh or figure or json
        options = {"physics": physics, "pairs": pairs, "measure": measure or DEFAULT_MEASURE}
        write_report(run, report, given, supported=not others, workers=workers, **options)
        return
    adaptation_name = name or default_name(place, damaged)
    if value is not None:
        _check_proposed(run, adaptation_name)
    words = [
        *damage_options(damaged),
        *["--physics"] * physics,
        *["--interactive"] * interactive,
        *(["--name", name] if name else []),
    ]
    try:
        with interruptible():
            adaptation = _open(
                run,
                damaged,
                place=place,
                measure=measure,
                settings=given,
                name=adaptation_name,
                fresh=fresh,
                workers=workers,
                json=json,
            )
            view = AdaptationView(adaptation, json)
            if place != "robot":
                view.print_all(adaptation)
            elif interactive:
                _ask(adaptation, view, adaptation_name, format)
            elif value is not None:
                view.print_trial(adaptation.record(value))
            if place == "robot" and not interactive and adaptation.proposal:
                view.print_proposal(
                    adaptation.proposal, _gait_file(adaptation, adaptation_name, format)
                )
                if not json:
                    record = command("adapt", run.path, "--name", adaptation_name, "--measured")
                    output().print(f"  {record} NUMBER  # the measured value", style="dim")
            if adaptation.proposal is None:
                view.print_result()
            if figure is not None:
                save(adaptation_figure(adaptation), figure)
                view.print_figure(figure)
    except KeyboardInterrupt:
        if interactive:
            echo("")  # ends the line of the question
        notice(f"Stopped; all trials are saved. To continue: {command('adapt', run.path, *words)}")
        sys.exit(INTERRUPTED)


def _check(place: Place, interactive: bool, measured: str | None, json: bool) -> None:
    """Check that the options do not contradict each other."""
    wrong = ""
    if place != "robot" and (interactive or measured is not None):
        wrong = "--damage and --physics are for trials in simulation, not on a robot"
    elif interactive and measured is not None:
        wrong = "--measured cannot be combined with --interactive, which asks for the value"
    elif interactive and json:
        wrong = "--interactive cannot be combined with --json"
    if wrong:
        option = "--interactive" if interactive else "--measured"
        remedy = "pass values with --measured instead" if json else f"omit {option}"
        raise GaitsimError(wrong, where=option, remedy=remedy)


def _check_proposed(run: RunSnapshot, name: str) -> None:
    """Check that an adaptation has begun, so that a gait can have been measured."""
    from gaitsim.adaptation.adaptation import session_file

    if not session_file(run.path, name).exists():
        raise GaitsimError(
            f"there is no adaptation {name!r}, and thus no proposed gait",
            where="--measured",
            remedy="check --name, or omit --measured to get the first gait",
        )


def _open(run: RunSnapshot, damage: Sequence[str], *, json: bool, **options: Any) -> Adaptation:
    from gaitsim.adaptation.adaptation import open_adaptation
    from gaitsim.adaptation.trials import count_intact_gaits

    gaits = count_intact_gaits(run, physics=options["place"] == "physics")
    log = "" if json else f"reading the {gaits:,} gaits of the atlas"
    with Progress("evaluating the atlas", "gaits", gaits, log=log) as progress:
        return open_adaptation(
            run, damage, on_progress=progress.advance, on_warning=notice, **options
        )


def _ask(adaptation: Adaptation, view: AdaptationView, name: str, format: GaitFormat) -> None:
    """Propose gaits and ask for their measured values, until the answer is empty."""
    view.print_earlier()
    prior = adaptation.prior
    unit = f", {prior.unit}" if prior.unit else ""
    while (proposal := adaptation.proposal) is not None:
        view.print_proposal(proposal, _gait_file(adaptation, name, format))
        while True:
            echo(f"{prior.measure} of the robot{unit} (Enter to quit): ", end="")
            answer = sys.stdin.readline()
            if not sys.stdin.isatty():
                echo(answer.rstrip("\n"))
            if not answer.strip():
                count = len(adaptation.trials)
                saved = "1 trial is saved" if count == 1 else f"{count} trials are saved"
                notice(f"{saved}. Repeat the command to continue.")
                return
            try:
                view.print_trial(adaptation.record(_number(answer)))
                break
            except GaitsimError as error:
                notice(str(error))


def _number(text: str) -> float:
    """Return the measured value in a text."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise GaitsimError(
            f"invalid measured value: {text.strip()!r:.60}", allowed="a finite number, such as 1.3"
        )
    return value


def _gait_file(adaptation: Adaptation, name: str, format: GaitFormat) -> Path:
    """Write the proposed gait for the robot, and return the file."""
    from gaitsim.gait.gait_files import gait_of, write_gait

    proposal, prior = adaptation.proposal, adaptation.prior
    if proposal is None:
        raise ValueError("the adaptation has ended; there is no gait to export")
    folder = exports_folder(prior.source)
    path = folder / f"{name}-trial-{proposal.number}.{format}"
    write_gait(gait_of(prior.individual(proposal.member)), path, format)
    report_files(path)
    return path

"""`gaitsim adapt`."""

import math
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from gaitsim.adaptation.adaptation import Adaptation, open_adaptation
from gaitsim.adaptation.performance import MEASURE
from gaitsim.adaptation.session import Place, canonical, default_name, session_file
from gaitsim.adaptation.settings import MOST_TRIALS, Settings
from gaitsim.adaptation.transfer import intact_gaits
from gaitsim.choices import GaitFormat
from gaitsim.cli import INTERRUPTED
from gaitsim.cli.adaptation_report import report_to
from gaitsim.cli.adaptation_view import View
from gaitsim.cli.console import echo, notice, output, wrote
from gaitsim.cli.interrupts import interruptible
from gaitsim.cli.options import Json, RunName, Workers
from gaitsim.cli.progress_bar import Progress
from gaitsim.errors import GaitsimError
from gaitsim.gait.files.writer import gait_of, write_gait
from gaitsim.legged.damage import DAMAGE_HELP, damage_options
from gaitsim.render.plots.adaptation import adaptation_figure
from gaitsim.render.plots.style import check_target, save
from gaitsim.runs.files.folder import command, exports_folder, find_run
from gaitsim.runs.snapshot import RunSnapshot

_trials = partial(typer.Option, rich_help_panel="How trials are chosen")
_report = partial(typer.Option, rich_help_panel="Report over all leg losses")
_robot = partial(typer.Option, rich_help_panel="Trials on a real robot")
DEFAULT = Settings()


def adapt(
    atlas: RunName,
    damage: Annotated[
        list[str] | None,
        typer.Option(metavar="TEXT", help=f"Simulate {DAMAGE_HELP}; may be repeated."),
    ] = None,
    physics: Annotated[
        bool,
        typer.Option("--physics", help="Make the trials on the body's physical twin."),
    ] = False,
    measure: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Measure of which more is better. Default: forward, in metres."
        ),
    ] = None,
    trials: Annotated[
        int | None, _trials(min=1, max=MOST_TRIALS, help=f"At most. Default: {DEFAULT.trials}.")
    ] = None,
    stop: Annotated[
        float | None,
        _trials(
            help="Stop when the best trial is this share of what is still expected. Default: "
            f"{DEFAULT.stop}."
        ),
    ] = None,
    kappa: Annotated[
        float | None,
        _trials(help=f"Weight of uncertainty in the choice. Default: {DEFAULT.kappa}."),
    ] = None,
    length_scale: Annotated[
        float | None,
        _trials(
            help="Distance over which a trial informs about other gaits, in shares of the axes. "
            f"Default: {DEFAULT.length_scale}."
        ),
    ] = None,
    noise: Annotated[
        float | None,
        _trials(
            help=f"Variance of a measured value in shares of the best. Default: {DEFAULT.noise}."
        ),
    ] = None,
    interactive: Annotated[
        bool,
        _robot("--interactive", help="Write a gait file, ask what the robot did, and so on."),
    ] = False,
    measured: Annotated[
        str | None,
        _robot(
            metavar="NUMBER",
            help="Record what the proposed gait measured, and propose the next; for scripts.",
        ),
    ] = None,
    format: Annotated[GaitFormat, _robot(help="Of the gait files.")] = "mat",
    name: Annotated[
        str | None,
        typer.Option(help="Of the adaptation. Default: after the damage, or 'robot'."),
    ] = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Begin again; earlier trials of this name are deleted.")
    ] = False,
    figure: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Plot the trials: PNG, SVG or PDF, as the name ends."),
    ] = None,
    report: Annotated[
        Path | None,
        _report(metavar="DIR", help="Adapt to the loss of each leg: tables and figures."),
    ] = None,
    pairs: Annotated[bool, _report("--pairs", help="And to the loss of each two legs.")] = False,
    workers: Workers = None,
    json: Json = False,
) -> None:
    """Find a gait for a damaged body in a few trials, by the map of an atlas.

    A Gaussian process over the map predicts how each gait performs with the damage.
    The most promising one is tried next. The same command continues later.
    Without --damage it proposes gaits for your robot.

    [bold]Examples[/bold]

    gaitsim adapt spider-atlas --damage "L2 lost"

    gaitsim adapt spider-atlas --damage "R1 femur stuck 20" --physics

    gaitsim adapt spider-atlas --interactive

    gaitsim adapt spider-atlas --name leg-gone

    gaitsim adapt spider-atlas --name leg-gone --measured 1.3

    gaitsim adapt spider-atlas --report losses --pairs --physics
    """
    place: Place = "physics" if physics else "simulation" if damage else "robot"
    _check(place, interactive, measured, json)
    value = None if measured is None else _number(measured)
    if figure is not None:
        check_target(figure)
    run = RunSnapshot(find_run(atlas))
    damaged = canonical(damage or ())
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
        options = {"physics": physics, "pairs": pairs, "measure": measure or MEASURE}
        report_to(run, None if others else report, given, workers=workers, **options)
        return
    called = name or default_name(place, damaged)
    if value is not None and not session_file(run.path, called).exists():
        raise GaitsimError(
            f"nothing was proposed yet in the adaptation {called!r}",
            where="--measured",
            remedy="leave --measured out, to get the first gait",
        )
    words = damage_options(damaged) + ["--physics"] * physics + ["--interactive"] * interactive
    words += ["--name", name] if name else []
    try:
        with interruptible():
            adaptation = _opened(
                run,
                damaged,
                place=place,
                measure=measure,
                settings=given,
                name=called,
                fresh=fresh,
                workers=workers,
                json=json,
            )
            view = View(adaptation, json)
            if place != "robot":
                view.show(adaptation)
            elif interactive:
                _ask(adaptation, view, called, format)
            elif value is not None:
                view.trial(adaptation.record(value))
            if place == "robot" and not interactive and adaptation.proposal:
                view.proposal(adaptation.proposal, _gait_file(adaptation, called, format))
                if not json:
                    record = command("adapt", run.path, "--name", called, "--measured")
                    output().print(f"  {record} NUMBER  # what it measured", style="dim")
            if adaptation.proposal is None:
                view.end()
            if figure is not None:
                save(adaptation_figure(adaptation), figure)
                view.figure(figure)
    except KeyboardInterrupt:
        if interactive:
            echo("")  # after the question
        notice(f"Stopped; the trials are kept. Continue: {command('adapt', run.path, *words)}")
        sys.exit(INTERRUPTED)


def _check(place: Place, interactive: bool, measured: str | None, json: bool) -> None:
    """Refuse options that contradict each other."""
    wrong = ""
    if place != "robot" and (interactive or measured is not None):
        wrong = "--damage and --physics are for trials in simulation"
    elif interactive and measured is not None:
        wrong = "--interactive asks for the measured value"
    elif interactive and json:
        wrong = "--json does not ask questions"
    if wrong:
        option = "--interactive" if interactive else "--measured"
        remedy = "programs give the values with --measured" if json else f"leave out {option}"
        raise GaitsimError(wrong, where=option, remedy=remedy)


def _opened(run: RunSnapshot, damage: Sequence[str], *, json: bool, **options: Any) -> Adaptation:
    gaits = intact_gaits(run, physics=options["place"] == "physics")
    log = "" if json else f"reading the {gaits:,} gaits of the atlas"
    with Progress("evaluating the atlas", "gaits", gaits, log=log) as progress:
        return open_adaptation(
            run, damage, on_progress=progress.advance, on_warning=notice, **options
        )


def _ask(adaptation: Adaptation, view: View, name: str, format: GaitFormat) -> None:
    """Propose gaits and ask what they measured, until there is no answer."""
    view.earlier()
    prior = adaptation.prior
    unit = f", {prior.unit}" if prior.unit else ""
    while (proposal := adaptation.proposal) is not None:
        view.proposal(proposal, _gait_file(adaptation, name, format))
        while True:
            echo(f"{prior.measure} of the robot{unit} (Enter to leave): ", end="")
            answer = sys.stdin.readline()
            if not sys.stdin.isatty():
                echo(answer.rstrip("\n"))
            if not answer.strip():
                notice(f"{len(adaptation.trials)} trials are kept; the same command continues.")
                return
            try:
                view.trial(adaptation.record(_number(answer)))
                break
            except GaitsimError as error:
                notice(str(error))


def _number(text: str) -> float:
    """Return a measured value.

    Raises:
        GaitsimError: it is not a finite number.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise GaitsimError(
            f"{text.strip()!r:.60} is not a measured value", allowed="a finite number, such as 1.3"
        )
    return value


def _gait_file(adaptation: Adaptation, name: str, format: GaitFormat) -> Path:
    """Write the proposed gait for the robot, and return the file."""
    proposal, prior = adaptation.proposal, adaptation.prior
    if proposal is None:
        raise ValueError("the adaptation has ended")
    folder = exports_folder(prior.source)
    path = folder / f"{name}-trial-{proposal.number}.{format}"
    write_gait(gait_of(prior.individual(proposal.member)), path, format)
    wrote(path)
    return path

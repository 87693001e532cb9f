"""`gaitsim adapt`."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict

from gaitsim.actions.action import JSON, WORKERS, Action, argument
from gaitsim.adaptation.settings import MOST_TRIALS, AdaptationSettings
from gaitsim.choices import DAMAGE_HELP, GaitFormat
from gaitsim.console import INTERRUPTED
from gaitsim.console.printing import echo, notice, output, report_files
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError
from gaitsim.storage.files.folder import command, exports_folder

if TYPE_CHECKING:
    from gaitsim.adaptation.adaptation import Adaptation, Place
    from gaitsim.console.adaptation_view import AdaptationView
    from gaitsim.storage.snapshot import RunSnapshot

TRIALS = "How trials are chosen"  # panels of the help
ROBOT = "Trials on a real robot"
LOSSES = "Report on every leg loss"
DEFAULT = AdaptationSettings()
SETTINGS = "trials", "stop", "kappa", "length_scale", "noise"


class Adapt(Action):
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

    model_config = ConfigDict(allow_inf_nan=True)  # the settings themselves explain their limits

    atlas: str = argument(
        "run that holds the atlas: a run of map-elites, by name or folder", "ATLAS"
    )
    damage: Names | None = option(None, f"simulate {DAMAGE_HELP}", placeholder="TEXT")
    physics: bool = option(
        False, "run the trials on the body's twin, which is its version in rigid-body physics"
    )
    measure: str | None = option(
        None,
        "measure to maximise",
        unset="'forward', the distance walked forward in metres",
        placeholder="NAME",
    )
    trials: int | None = option(
        None,
        "maximum number of trials",
        unset=f"{DEFAULT.trials}",
        ge=1,
        le=MOST_TRIALS,
        panel=TRIALS,
    )
    stop: float | None = option(
        None,
        "stop once the best trial reaches this share of the best value predicted for any gait",
        unset=f"{DEFAULT.stop}",
        panel=TRIALS,
    )
    kappa: float | None = option(
        None,
        "weight of uncertainty when choosing a gait; larger values explore more",
        unset=f"{DEFAULT.kappa}",
        panel=TRIALS,
    )
    length_scale: float | None = option(
        None,
        "distance over which a trial affects the predictions for other gaits, as a share of the "
        "range of each axis of the atlas",
        unset=f"{DEFAULT.length_scale}",
        panel=TRIALS,
    )
    noise: float | None = option(
        None,
        "assumed variance of a measurement, in units in which the best value in the atlas is 1",
        unset=f"{DEFAULT.noise}",
        panel=TRIALS,
    )
    interactive: bool = option(
        False,
        "write a gait file, ask for the robot's result, and repeat with the next gait",
        panel=ROBOT,
    )
    measured: str | None = option(
        None,
        "record the measured result of the proposed gait and propose the next gait, for use in "
        "scripts",
        placeholder="NUMBER",
        panel=ROBOT,
    )
    format: GaitFormat = option("mat", "format of the gait files", panel=ROBOT)
    name: str | None = option(
        None,
        "name of the adaptation",
        unset="derived from the damage, or 'robot'",
        placeholder="NAME",
    )
    fresh: bool = option(False, "start over: delete the earlier trials of this adaptation")
    figure: Path | None = option(
        None,
        "plot the trials to a PNG, SVG or PDF file, chosen by its extension",
        placeholder="FILE",
    )
    report: Path | None = option(
        None,
        "adapt to the loss of each leg in turn; write tables and figures to this folder",
        placeholder="FOLDER",
        panel=LOSSES,
    )
    pairs: bool = option(False, "also adapt to the loss of each pair of legs", panel=LOSSES)
    workers: int | None = WORKERS
    json_lines: bool = JSON

    @property
    def place(self) -> Place:
        """The place of the trials."""
        return "physics" if self.physics else "simulation" if self.damage else "robot"

    @property
    def settings(self) -> dict[str, Any]:
        """The given settings of the trials."""
        values = {name: getattr(self, name) for name in SETTINGS}
        return {name: value for name, value in values.items() if value is not None}

    def do(self) -> None:
        """Run the trials, propose a gait for the robot, or write the report on all leg losses."""
        from gaitsim.adaptation.adaptation import default_name, normalise_damage
        from gaitsim.render.plots.style import check_target
        from gaitsim.storage.snapshot import RunSnapshot

        self._check()
        value = None if self.measured is None else _number(self.measured)
        if self.figure is not None:
            check_target(self.figure)
        run = RunSnapshot.find(self.atlas)
        damage = normalise_damage(self.damage or ())
        if self.report is not None or self.pairs:
            self._report(run)
            return
        name = self.name or default_name(self.place, damage)
        if value is not None:
            _check_proposed(run, name)
        self._adapt(run, damage, name, value)

    def _check(self) -> None:
        """Check that the options do not contradict each other."""
        wrong = ""
        if self.place != "robot" and (self.interactive or self.measured is not None):
            wrong = "--damage and --physics are for trials in simulation, not on a robot"
        elif self.interactive and self.measured is not None:
            wrong = "--measured cannot be combined with --interactive, which asks for the value"
        elif self.interactive and self.json_lines:
            wrong = "--interactive cannot be combined with --json"
        if wrong:
            option = "--interactive" if self.interactive else "--measured"
            remedy = "pass values with --measured instead" if self.json_lines else f"omit {option}"
            raise GaitsimError(wrong, where=option, remedy=remedy)

    def _report(self, run: RunSnapshot) -> None:
        from gaitsim.adaptation.prior import DEFAULT_MEASURE
        from gaitsim.console.adaptation_view import write_report

        others = (self.damage, self.interactive, self.measured, self.name, self.fresh, self.figure)
        write_report(
            run,
            self.report,
            self.settings,
            supported=not (any(others) or self.json_lines),
            physics=self.physics,
            pairs=self.pairs,
            measure=self.measure or DEFAULT_MEASURE,
            workers=self.workers,
        )

    def _adapt(
        self, run: RunSnapshot, damage: Sequence[str], name: str, value: float | None
    ) -> None:
        """Run the trials, or record the measured value and propose the next gait."""
        from gaitsim.console.adaptation_view import AdaptationView
        from gaitsim.console.interrupts import interruptible
        from gaitsim.legged.damage import damage_options
        from gaitsim.render.plots.adaptation import adaptation_figure
        from gaitsim.render.plots.style import save

        words = [
            *damage_options(damage),
            *["--physics"] * self.physics,
            *["--interactive"] * self.interactive,
            *(["--name", self.name] if self.name else []),
        ]
        try:
            with interruptible():
                adaptation = self._open(run, damage, name)
                view = AdaptationView(adaptation, self.json_lines)
                if self.place != "robot":
                    view.print_all(adaptation)
                elif self.interactive:
                    _ask(adaptation, view, name, self.format)
                elif value is not None:
                    view.print_trial(adaptation.record(value))
                if self.place == "robot" and not self.interactive and adaptation.proposal:
                    view.print_proposal(
                        adaptation.proposal, _gait_file(adaptation, name, self.format)
                    )
                    if not self.json_lines:
                        record = command("adapt", run.path, "--name", name, "--measured")
                        output().print(f"  {record} NUMBER  # the measured value", style="dim")
                if adaptation.proposal is None:
                    view.print_result()
                if self.figure is not None:
                    save(adaptation_figure(adaptation), self.figure)
                    view.print_figure(self.figure)
        except KeyboardInterrupt:
            if self.interactive:
                echo("")  # ends the line of the question
            again = command("adapt", run.path, *words)
            notice(f"Stopped; all trials are saved. To continue: {again}")
            sys.exit(INTERRUPTED)

    def _open(self, run: RunSnapshot, damage: Sequence[str], name: str) -> Adaptation:
        from gaitsim.adaptation.adaptation import open_adaptation
        from gaitsim.adaptation.trials import count_intact_gaits
        from gaitsim.console.progress_bar import Progress

        gaits = count_intact_gaits(run, physics=self.physics)
        log = "" if self.json_lines else f"reading the {gaits:,} gaits of the atlas"
        with Progress("evaluating the atlas", "gaits", gaits, log=log) as progress:
            return open_adaptation(
                run,
                damage,
                place=self.place,
                measure=self.measure,
                settings=self.settings,
                name=name,
                fresh=self.fresh,
                workers=self.workers,
                on_progress=progress.advance,
                on_warning=notice,
            )


def _check_proposed(run: RunSnapshot, name: str) -> None:
    """Check that an adaptation has begun, so that a gait can have been measured."""
    from gaitsim.adaptation.adaptation import session_file

    if not session_file(run.path, name).exists():
        raise GaitsimError(
            f"there is no adaptation {name!r}, and thus no proposed gait",
            where="--measured",
            remedy="check --name, or omit --measured to get the first gait",
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

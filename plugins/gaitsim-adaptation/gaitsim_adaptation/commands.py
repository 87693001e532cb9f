"""`gaitsim adapt`."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict

from gaitsim.plugin import DAMAGE_HELP, GaitFormat, GaitsimError, Names, Pair, option
from gaitsim.plugin.commands import (
    INTERRUPTED,
    JSON,
    WORKERS,
    Action,
    argument,
    echo,
    not_combinable,
    notice,
    output,
    report_files,
)
from gaitsim.plugin.runs import command
from gaitsim_adaptation.settings import MOST_TRIALS, AdaptationSettings

if TYPE_CHECKING:
    from gaitsim.plugin.runs import RunSnapshot
    from gaitsim_adaptation.adaptation import Adaptation
    from gaitsim_adaptation.record import Place
    from gaitsim_adaptation.trials import Proposal
    from gaitsim_adaptation.view import AdaptationView

TRIALS = "How trials are chosen"  # panels of the help
ROBOT = "Trials on a real robot"
LOSSES = "Report on every leg loss"
CHANGES = "measured", "correct", "repeat", "undo"  # options that change the results of a robot
DEFAULT = AdaptationSettings()
SETTINGS = "trials", "stop", "refine", "kappa", "length_scale", "noise"


class AdaptOptions(Action):
    """The options of each adaptation."""

    atlas: str = argument(
        "run that holds the atlas: a run of map-elites, by name or folder", "ATLAS"
    )
    trials: int | None = option(
        None,
        "maximum number of trials",
        unset=f"{DEFAULT.trials}",
        ge=1,
        le=MOST_TRIALS,
        panel=TRIALS,
    )
    refine: int | None = option(
        None,
        "number of small changes of the best gait to try after the gaits of the atlas",
        unset="0",
        ge=0,
        le=MOST_TRIALS,
        panel=TRIALS,
    )
    unit: str | None = option(
        None,
        "unit of results without a unit, such as cm",
        unset="the unit of the measure, or s with --course",
        placeholder="UNIT",
        panel=ROBOT,
    )
    scale: str | None = option(
        None,
        "performance of the intact robot as a share of that in simulation, or the --name of trials "
        "on the intact robot that measured it",
        unset="estimated from the trials",
        placeholder="NUMBER|NAME",
        panel=ROBOT,
    )
    name: str | None = option(
        None,
        "name of the adaptation",
        unset="derived from the damage, or 'robot'",
        placeholder="NAME",
    )
    fresh: bool = option(False, "start over: delete the earlier trials of this adaptation")


class Adapt(AdaptOptions):
    """Find a gait for a damaged body in a few trials, guided by an atlas.

    An atlas holds the best gait for each way of using the legs; see 'gaitsim atlas'. A Gaussian
    process predicts how each of these gaits performs on the damaged body, and the most promising
    gait is tried next. --refine then changes the best gait in small steps. Without --damage and
    --physics, the command proposes gaits to try on your robot. Repeat the command to continue.

    [bold]Examples[/bold]

    gaitsim adapt spider-atlas --damage "L2 lost"

    gaitsim adapt spider-atlas --damage "R1 femur stuck 20" --physics

    gaitsim adapt spider-atlas --damage "L2 lost" --refine 20

    gaitsim adapt spider-atlas --interactive --damage "L2 lost" --unit cm

    gaitsim adapt spider-atlas --name leg-gone

    gaitsim adapt spider-atlas --name leg-gone --measured 62cm

    gaitsim adapt spider-atlas --name leg-gone --correct 1 0.58

    gaitsim adapt spider-atlas --report losses --pairs --physics
    """

    model_config = ConfigDict(allow_inf_nan=True)  # the settings themselves explain their limits

    damage: Names | None = option(None, f"simulate {DAMAGE_HELP}", placeholder="TEXT")
    robot: bool = option(
        False,
        "run the trials on a real robot; --damage is then the damage that you see, which improves "
        "the predictions. Implied by the options of this group, and without --damage",
        panel=ROBOT,
    )
    physics: bool = option(
        False, "run the trials on the body's twin, which is its version in rigid-body physics"
    )
    measure: str | None = option(
        None,
        "measure to maximise",
        unset="'forward', the distance walked forward in metres",
        placeholder="NAME",
    )
    stop: float | None = option(
        None,
        "stop once the best trial reaches this share of the best value predicted for any gait",
        unset=f"{DEFAULT.stop}",
        panel=TRIALS,
    )
    visible: bool = option(
        False,
        "predict from the damaged kinematic body, too, as if you saw the damage",
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
        "scripts: '62cm', '0,62', 'fell 0.3', 'could not play', or several attempts",
        placeholder="RESULT",
        panel=ROBOT,
    )
    correct: Pair | None = option(
        None, "replace the result of trial N", placeholder="N RESULT", panel=ROBOT
    )
    repeat: Pair | None = option(
        None, "add another attempt at the gait of trial N", placeholder="N RESULT", panel=ROBOT
    )
    undo: bool = option(False, "remove the last trial", panel=ROBOT)
    sure: bool = option(
        False, "accept results above twice the best expected performance", panel=ROBOT
    )
    course: float | None = option(
        None,
        "results are times for this distance; shorter is better",
        unit="m",
        gt=0,
        le=1e6,
        placeholder="METRES",
        panel=ROBOT,
    )
    format: GaitFormat | None = option(
        None, "format of the gait files", unset="that of the earlier files, or mat", panel=ROBOT
    )
    champion: str | None = option(
        None,
        "also compare with the champion of this run, on the intact body",
        unset="the champion from which the atlas began",
        placeholder="RUN",
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
        if self.physics:
            return "physics"
        return "robot" if self._of_robot or not self.damage else "simulation"

    @property
    def _of_robot(self) -> list[str]:
        """The flags of those options that apply only to trials on a robot."""
        return self.flags_of("robot", "interactive", *CHANGES, "sure", "scale", "unit", "course")

    @property
    def settings(self) -> dict[str, Any]:
        """The given settings of the trials."""
        values = {name: getattr(self, name) for name in SETTINGS}
        return {name: value for name, value in values.items() if value is not None}

    def do(self) -> None:
        """Run the trials, propose a gait for the robot, or write the report on all leg losses."""
        from gaitsim.plugin.runs import RunSnapshot
        from gaitsim_adaptation.record import default_name, normalise_damage

        self._check()
        run = RunSnapshot.find(self.atlas)
        if self.report is not None or self.pairs:
            self._report(run)
            return
        name = self.name or default_name(self.place, normalise_damage(self.damage or ()))
        if self.flags_of(*CHANGES):
            _check_proposed(run, name, self.flags_of(*CHANGES)[0])
        self._adapt(run, name)

    def _check(self) -> None:
        """Check that the options do not contradict each other."""
        changes, flags = self.flags_of(*CHANGES), self._of_robot
        if self.physics and flags:
            raise not_combinable(flags[0], "--physics", "--physics for trials in simulation")
        if self.visible and (self.place == "robot" or not self.damage):
            raise GaitsimError(
                "--visible needs --damage to a body in simulation",
                where="--visible",
                remedy="omit it; --damage of a robot is always visible",
            )
        if len(changes) > 1 or (changes and self.interactive):
            raise not_combinable(changes[0], "--interactive" if self.interactive else changes[1])
        if self.interactive and self.json_lines:
            raise not_combinable(
                "--interactive", "--json", "--json with results passed with --measured"
            )

    def _report(self, run: RunSnapshot) -> None:
        from gaitsim_adaptation.prior import DEFAULT_MEASURE
        from gaitsim_adaptation.view import write_report

        others = (self.damage, self._of_robot, self.name, self.fresh, self.visible)
        write_report(
            run,
            self.report,
            self.settings,
            supported=not (any(others) or self.json_lines),
            physics=self.physics,
            pairs=self.pairs,
            measure=self.measure or DEFAULT_MEASURE,
            champion=self.champion,
            workers=self.workers,
        )

    def _adapt(self, run: RunSnapshot, name: str) -> None:
        """Run the trials, or change the results of a robot and propose the next gait."""
        from gaitsim.plugin.commands import interruptible
        from gaitsim.plugin.toolkit import damage_options
        from gaitsim_adaptation.view import AdaptationView

        words = [
            *damage_options(self.damage or ()),
            *self.flags_of("physics", "visible", "robot", "interactive"),
            *(["--name", self.name] if self.name else []),
            *(["--champion", self.champion] if self.champion else []),
        ]
        try:
            with interruptible():
                adaptation = self.opened(run, name)
                view = AdaptationView(adaptation, self.json_lines)
                if self.place != "robot":
                    view.print_all(adaptation)
                elif self.interactive:
                    ask(adaptation, view)
                else:
                    self._change(adaptation, view)
                if adaptation.proposal is None:
                    best, file = adaptation.best, None
                    if best is not None and best.genome:
                        file = _gait_file(adaptation, best, "best")
                    view.print_result(file)
        except KeyboardInterrupt:
            if self.interactive:
                echo("")  # ends the line of the question
            again = command("adapt", run.path, *words)
            notice(f"Stopped; all trials are saved. To continue: {again}")
            sys.exit(INTERRUPTED)

    def _change(self, adaptation: Adaptation, view: AdaptationView) -> None:
        """Record, correct, repeat or undo a result, and propose the next gait."""
        text = "undo" if self.undo else self.measured
        for word, given in (("correct", self.correct), ("repeat", self.repeat)):
            text = f"{word} {' '.join(given)}" if given else text
        if text is not None:
            reply = adaptation.understand(text)
            if (doubt := adaptation.doubt(reply.answer)) and not self.sure:
                raise GaitsimError(
                    f"{text!r:.60} is probably a mistake: {doubt}",
                    where=self.flags_of(*CHANGES)[0],
                    remedy="give the unit, such as 62cm, or add --sure",
                )
            view.print_done(reply, adaptation.carry_out(reply))
        elif not self.json_lines:
            view.print_earlier()
        if proposal := adaptation.proposal:
            file = _gait_file(adaptation, proposal)
            view.print_proposal(proposal, file)
            if not self.json_lines:
                atlas, name = adaptation.prior.source, adaptation.name
                record = command("adapt", atlas, "--name", name, "--measured")
                output().print(f"  {record} RESULT  # such as 62cm", style="dim")

    def opened(self, run: RunSnapshot, name: str) -> Adaptation:
        """Start or continue the adaptation, with its progress."""
        from gaitsim.plugin.commands import Progress
        from gaitsim_adaptation.adaptation import measured_scale, open_adaptation
        from gaitsim_adaptation.trials import count_gaits

        known = bool(self.damage) and (self.visible or self.place == "robot")
        gaits = count_gaits(run, physics=self.physics, known=known)
        log = "" if self.json_lines else f"reading the {gaits:,} gaits of the atlas"
        settings = self.settings
        answers = {"gait_format": self.format, "unit": self.unit, "course": self.course}
        if self.scale is not None:
            number = re.fullmatch(r"\d+([.,]\d+)?", self.scale)
            settings["scale"] = (
                float(self.scale.replace(",", ".")) if number else measured_scale(run, self.scale)
            )
        with Progress("evaluating the atlas", "gaits", gaits, log=log) as progress:
            return open_adaptation(
                run,
                self.damage,
                place=self.place,
                measure=self.measure,
                settings=settings,
                known=self.visible,
                answers={key: value for key, value in answers.items() if value is not None},
                name=name,
                fresh=self.fresh,
                champion=self.champion,
                workers=self.workers,
                on_progress=progress.advance,
                on_warning=notice,
            )


def _check_proposed(run: RunSnapshot, name: str, flag: str) -> None:
    """Check that an adaptation has begun, so that a gait can have been measured."""
    from gaitsim_adaptation.record import adaptation_file

    if not adaptation_file(run.path, name).exists():
        raise GaitsimError(
            f"there is no adaptation {name!r}, and thus no proposed gait",
            where=flag,
            remedy=f"check --name, or omit {flag} to get the first gait",
        )


def ask(
    adaptation: Adaptation,
    view: AdaptationView,
    play: Callable[[Proposal], object] | None = None,
) -> None:
    """Propose gaits and ask for their results, until the answer is empty.

    Args:
        adaptation: the adaptation.
        view: prints it.
        play: plays each proposal on the robot, before its result is asked for, and after 'again'.
    """
    from gaitsim_adaptation.answers import ANSWERS

    view.print_earlier()
    echo(ANSWERS)
    proposed = None
    while (proposal := adaptation.proposal) is not None:
        if proposal != proposed:
            file = _gait_file(adaptation, proposal)
            view.print_proposal(proposal, file)
            if play:
                play(proposal)
            proposed = proposal
        text = question(f"{adaptation.question} (Enter to quit): ")
        if not text:
            count = len(adaptation.trials)
            saved = "1 trial is saved" if count == 1 else f"{count} trials are saved"
            notice(f"{saved}. Repeat the command to continue.")
            return
        if text == "again" and play:
            play(proposal)
            continue
        try:
            reply = adaptation.understand(text)
            doubt = adaptation.doubt(reply.answer)
            if doubt and not confirmed(doubt):
                continue
            view.print_done(reply, adaptation.carry_out(reply))
        except GaitsimError as error:
            notice(str(error))


def confirmed(doubt: str) -> bool:
    """Ask whether a doubtful answer is right."""
    return question(f"{doubt}. Is that right? (y/n): ").lower() in ("y", "yes")


def question(text: str) -> str:
    """Print a question, and return the answer."""
    echo(text, end="")
    answer = sys.stdin.readline()
    if not sys.stdin.isatty():
        echo(answer.rstrip("\n"))
    return answer.strip()


def _gait_file(adaptation: Adaptation, proposal: Proposal, part: str = "") -> Path:
    """Write the gait of a proposal or trial for the robot, and return the file."""
    path = adaptation.export(proposal, part)
    report_files(path)
    return path

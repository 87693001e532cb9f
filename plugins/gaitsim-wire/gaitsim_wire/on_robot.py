"""`gaitsim robots adapt` and `gaitsim robots evolve`: trials on a real robot."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.plugin import GaitsimError, Names, option
from gaitsim.plugin.commands import RUN_OR_CODE, ChosenIndividual, argument
from gaitsim_adaptation.commands import Adapt, AdaptOptions, ask, confirmed, question
from gaitsim_wire.wire import WireOptions

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Individual
    from gaitsim_adaptation.answers import AnswerReader
    from gaitsim_adaptation.trials import Proposal
    from gaitsim_wire.trials import Played, RobotSearch, RobotTrial

READY = "Put the robot at its start. Enter plays the gait; Space then stops the robot: "


class AdaptRobot(AdaptOptions, WireOptions):
    """Find a gait for a damaged robot in a few trials, which the robot plays.

    As 'gaitsim adapt ATLAS --interactive', but each proposed gait is streamed to the servos of
    the robot. Then type how far it walked, such as 62cm, 'fell 0.3' or 'could not play'; 'again'
    plays the gait once more. Repeat the command to continue, even on another day.

    [bold]Examples[/bold]

    gaitsim robots adapt ATLAS --port /dev/ttyUSB0 --calibration servos.toml

    gaitsim robots adapt ATLAS --port robot.port --calibration servos.toml --imu
    """

    damage: Names | None = option(
        None, "damage that you see, which improves the predictions", placeholder="TEXT"
    )

    def do(self) -> None:
        """Propose gaits, play them, and ask for their results."""
        from gaitsim.plugin.commands import INTERRUPTED, interruptible, notice
        from gaitsim.plugin.runs import RunSnapshot, exports_folder
        from gaitsim_adaptation.record import default_name, normalise_damage
        from gaitsim_adaptation.view import AdaptationView

        self.check_wire()
        run = RunSnapshot.find(self.atlas)
        name = self.name or default_name("robot", normalise_damage(self.damage or ()))
        given = {one: getattr(self, one) for one in AdaptOptions.model_fields}
        action = Adapt(robot=True, interactive=True, damage=self.damage, **given)
        try:
            with interruptible():
                adaptation = action.opened(run, name)
                view = AdaptationView(adaptation, json=False)

                def offer(proposal: Proposal) -> None:
                    file = exports_folder(run.path) / f"{name}-trial-{proposal.number}-robot.npz"
                    _ready()
                    _play(self, adaptation.individual(proposal), file)

                ask(adaptation, view, offer)
                if adaptation.proposal is None:
                    view.print_result()
        except KeyboardInterrupt:
            notice("Stopped; all trials are saved. Repeat the command to continue.")
            sys.exit(INTERRUPTED)


class EvolveRobot(ChosenIndividual, WireOptions):
    """Improve a gait on the real robot: CMA-ES, whose gaits the robot plays.

    The search begins around the champion of a run. The robot plays one gait after the other, and
    you type how far it walked; with an IMU, turning costs points. Every trial is saved: repeat the
    command to continue after Ctrl-C, a failure or a day. No gait is played twice unless you type
    'again'.

    [bold]Examples[/bold]

    gaitsim robots evolve hexapod --port /dev/ttyUSB0 --calibration robot.toml

    gaitsim robots evolve RUN --port robot.port --calibration servos.toml --imu
    """

    run: str = argument(RUN_OR_CODE, "RUN|CODE")
    trials: int = option(30, "end after this number of gaits", ge=1, le=10_000)
    population: int | None = option(None, "gaits per generation", unset="6", ge=4, le=100)
    step: float | None = option(
        None,
        "standard deviation of the first changes, as a share of each gene's range",
        unset="0.05",
        gt=0,
        le=0.5,
    )
    turn_weight: float | None = option(
        None,
        "with an IMU: penalty per radian of the root mean square of the robot's turn",
        unit="m/rad",
        unset="0.5",
        ge=0,
        le=1000,
    )
    seed: int | None = option(None, "seed of the search", unset="0", ge=0)
    unit: str = option("m", "unit of results without a unit, such as cm", placeholder="UNIT")
    out: Path | None = option(
        None, "folder of the search", unset="NAME-robot, after the run", placeholder="FOLDER"
    )

    def do(self) -> None:
        """Propose gaits, play them, and ask for their results."""
        from gaitsim.plugin.commands import (
            INTERRUPTED,
            echo,
            interruptible,
            notice,
            read_individual,
        )
        from gaitsim_adaptation.answers import AnswerReader

        self.check_wire()
        reading = AnswerReader("m", self.unit)
        individual = read_individual(self.run, self.choice)
        folder = self.out or Path(f"{individual.experiment.name}-robot")
        search = self._search(folder, individual)
        for number, trial in enumerate(search.log.trials, 1):
            echo(_line(search, number, trial))
        try:
            with interruptible():
                while len(search.log.trials) < self.trials:
                    if not self._try_next(search, reading):
                        break
        except KeyboardInterrupt:
            echo("")
            notice("Stopped; all trials are saved. Repeat the command to continue.")
            sys.exit(INTERRUPTED)
        self._report(search)

    def _search(self, folder: Path, individual: Individual) -> RobotSearch:
        """Continue the search in a folder, or begin one around an individual.

        Raises:
            RunError: the folder cannot be used, or holds a search with other settings.
        """
        from gaitsim.plugin import RunError
        from gaitsim.plugin.commands import echo
        from gaitsim.plugin.gait import gait_of
        from gaitsim.plugin.runs import code_of
        from gaitsim_wire.trials import FILE, Log, RobotSearch, read_log

        given = {
            name: value
            for name in ("population", "step", "turn_weight", "seed")
            if (value := getattr(self, name)) is not None
        }
        log = read_log(folder / FILE)
        if log is None:
            gait_of(individual)  # the body can be played
            log = Log(code_of(individual), **given)
            echo(f"{folder}: a new search around {individual.title}")
        changed = [name for name, value in given.items() if getattr(log, name) != value]
        if changed:
            raise RunError(
                f"the search in {folder} has {changed[0]} {getattr(log, changed[0])}",
                where=self.flags_of(*changed)[0],
                remedy="omit the option, or choose another folder with --out",
            )
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise RunError(f"cannot create {folder}: {error.strerror}", where="--out") from None
        return RobotSearch(folder / FILE, log)

    def _try_next(self, search: RobotSearch, reading: AnswerReader) -> bool:
        """Play the next gait and record its result; return False if the user quits."""
        from gaitsim.plugin.commands import echo, notice

        number = len(search.log.trials) + 1
        echo(f"trial {number} of {self.trials}, generation {search.generation}")
        file = search.path.with_name(f"trial-{number}.npz")
        individual = search.individual(search.proposal)
        if _ready(*["undo"] * bool(search.log.trials)):
            search.undo()
            return True
        played = _play(self, individual, file)
        while text := question("forward, or fell, could not play, again, undo (Enter quits): "):
            try:
                if text == "again":
                    _ready()
                    played = _play(self, individual, file)
                elif text == "undo":
                    search.undo()
                    return True
                else:
                    answer = reading.read(text)
                    if not self._doubted(search, max(answer.values)):
                        trial = search.record(answer, played)
                        echo(_line(search, number, trial))
                        return True
            except GaitsimError as error:
                notice(str(error))
        return False

    def _doubted(self, search: RobotSearch, distance: float) -> bool:
        """Ask about a distance, m, above twice that of the first gait in simulation."""
        from gaitsim_adaptation.adaptation import DOUBTFUL

        limit = search.expected
        if not limit > 0 or distance <= DOUBTFUL * limit:
            return False
        times = f"{distance / limit:.3g} times that of the simulation, {limit:.3g} m"
        return not confirmed(f"{distance:.3g} m is {times}")

    def _report(self, search: RobotSearch) -> None:
        """Print the best gait, and write its code."""
        from gaitsim.plugin.commands import echo, notice, report_files
        from gaitsim.plugin.runs import command, write_bytes

        count, best = len(search.log.trials), search.best
        if count < self.trials:
            notice(f"{count} trials are saved. Repeat the command to continue.")
        if best is None:
            return
        file = search.path.with_name("best.txt")
        write_bytes(file, search.code(best).encode() + b"\n")
        echo(f"Best: {_line(search, search.log.trials.index(best) + 1, best)}")
        report_files(file)
        echo("  " + command("drive", file, "--port", self.port, "--calibration", self.calibration))


def _ready(*others: str) -> str:
    """Wait for Enter, when the robot is at its start; return '', or one of other answers.

    Raises:
        KeyboardInterrupt: the keyboard is closed, so that nobody watches the robot.
    """
    import termios

    from gaitsim.plugin.commands import echo

    while True:
        if sys.stdin.isatty():  # an Enter too many before must not start the robot
            termios.tcflush(sys.stdin, termios.TCIFLUSH)
        echo(READY, end="")
        line = sys.stdin.readline()
        if not line:
            raise KeyboardInterrupt
        if (text := line.strip()) in ("", *others):
            return text


def _play(wire: WireOptions, individual: Individual, file: Path) -> Played:
    """Let a robot play a gait, and print what its IMU measured."""
    from gaitsim.plugin.commands import echo
    from gaitsim_wire.trials import play

    played = play(wire, individual, file)
    if text := str(played):
        echo(text)
    return played


def _line(search: RobotSearch, number: int, trial: RobotTrial) -> str:
    """Return a line about a trial."""
    outcome = "" if trial.outcome == "walked" else f", {trial.outcome}"
    score = search.log.score(trial)
    return f"trial {number:>3}: {trial.distance:.3f} m{outcome}, score {score:.3f}"

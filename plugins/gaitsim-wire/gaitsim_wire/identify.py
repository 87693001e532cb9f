"""`gaitsim robots identify`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.plugin import GaitsimError, Names, option
from gaitsim.plugin.commands import JSON, SET, WORKERS, Action, argument

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Experiment
    from gaitsim_wire.identification import Identified


class Identify(Action):
    """Fit the simulation of a robot to recordings of 'gaitsim drive'.

    The recorded commands are replayed in MuJoCo. The command finds the error of each servo horn,
    the friction, and the torque, stiffness and latency of the servos with which joint angles,
    loads, tilt, rates and distances are closest to the measured ones. Ctrl-C ends it with the best
    values so far.

    [bold]Examples[/bold]

    gaitsim drive RUN --port PORT --calibration robot.toml --imu --excite

    gaitsim robots identify hexapod robot-1.npz --save my_hexapod.toml

    gaitsim robots identify hexapod a.npz b.npz --distance 62cm --distance 1.4m

    gaitsim run my_hexapod.toml
    """

    model: str = argument(
        "name of a preset with a robot, or path of a TOML file or a robot file such as URDF",
        "MODEL",
        completion="preset_names",
    )
    recordings: Names = argument(
        "telemetry of drives on a level floor, as 'gaitsim drive' wrote it; a minute in all",
        "RECORDING",
        allowed="paths of .npz files",
        completion="",
    )
    distance: Names | None = option(
        None,
        "distance from the start to the end of a recording, such as 62cm; once for each recording, "
        "in their order",
        placeholder="LENGTH",
    )
    save: Path | None = option(
        None,
        "write an experiment with the fitted robot, which 'gaitsim run' takes",
        placeholder="FILE.toml",
    )
    rounds: int = option(
        12, "rounds of simulations; a minute of recordings takes half a minute each", ge=1, le=100
    )
    workers: int | None = WORKERS
    set_: Names | None = SET
    json_lines: bool = JSON

    def do(self) -> None:
        """Read the recordings, fit the parameters, and print and save them."""
        import os

        from gaitsim.plugin.commands import (
            INTERRUPTED,
            Progress,
            interruptible,
            notice,
            report_files,
            status,
        )
        from gaitsim.plugin.gait import check_folder
        from gaitsim.plugin.runs import load_experiment, parse_assignments, write_bytes
        from gaitsim_wire.identification import (
            RecordingReplay,
            identify,
            read_recording,
            simulations,
        )
        from gaitsim_wire.robots import robot_of

        if self.save is not None:
            check_folder(self.save)
        with status("Preparing the robot …"):
            experiment = load_experiment(self.model, parse_assignments(self.set_ or ()))
            robot = robot_of(experiment)
            lengths = self._distances()
            recordings = [
                read_recording(Path(one), robot.joint_names(), length)
                for one, length in zip(self.recordings, lengths, strict=True)
            ]
            replay = RecordingReplay(robot, recordings, self.workers or os.cpu_count() or 1)
        if not all("orientation" in one.values for one in recordings):
            notice("Without an IMU, errors of horns hardly show: drive with --imu.")
        total = simulations(self.rounds, len(replay.names))
        log = f"Comparing {replay.seconds:.0f} s with {total} simulations …"
        with interruptible(), Progress("Fitting", "simulations", total, log=log) as progress:
            found, stopped = identify(replay, self.rounds, progress.advance)
        self._print(found)
        if self.save is not None:
            write_bytes(self.save, fitted(experiment, found).to_toml().encode())
            report_files(self.save)
        if stopped:
            sys.exit(INTERRUPTED)

    def _distances(self) -> list[float]:
        """Return the distance of each recording, m; NaN if unknown."""
        from gaitsim_adaptation.answers import AnswerReader

        texts = self.distance or ()
        if len(texts) not in (0, len(self.recordings)):
            raise GaitsimError(
                f"{len(texts)} distances for {len(self.recordings)} recordings",
                where="--distance",
                allowed="one for each recording, in their order, or none",
            )
        answers = [AnswerReader("m").read(text) for text in texts]
        for text, answer in zip(texts, answers, strict=True):
            if len(answer.values) != 1 or answer.outcome != "walked" or not answer.values[0] > 0:
                allowed = "one length above 0, such as 62cm"
                raise GaitsimError(
                    f"invalid distance: {text!r:.60}", where="--distance", allowed=allowed
                )
        return [answer.values[0] for answer in answers] or [float("nan")] * len(self.recordings)

    def _print(self, found: "Identified") -> None:
        """Print a table of the parameters."""
        from gaitsim.plugin.commands import echo, print_json, print_table
        from gaitsim_wire.identification import WORLD

        rows = []
        for number, name in enumerate(found.names):
            assumed, value, error = (
                float(one[number]) for one in (found.start, found.values, found.errors)
            )
            if self.json_lines:
                record = {"parameter": name, "assumed": assumed, "found": value}
                print_json({**record, "low": value - 2 * error, "high": value + 2 * error})
                continue
            scale, unit = (1000, " ms") if name == "latency" else (1, "" if name in WORLD else "°")
            digits = 0 if name == "latency" else 2
            texts = [f"{scale * one:.{digits}f}{unit}" for one in (assumed, value, 2 * error)]
            rows.append((name.replace("_", " "), texts[0], texts[1], f"± {texts[2]}"))
        if rows:
            print_table(
                ("parameter", "assumed", "found", "95 %"), rows, ("assumed", "found", "95 %")
            )
            before, after = found.misfit
            echo(f"The deviation from the measurements fell from {before:.1f} to {after:.1f}.")


def fitted(experiment: "Experiment", found: "Identified") -> "Experiment":
    """Return an experiment with the fitted robot as its world, and ranges for unseen worlds."""
    from gaitsim.plugin.runs import with_overrides

    robot = experiment.organism
    overrides = {
        "organism.world": {**getattr(robot, "world", {}), **found.world},
        "organism.horns": found.horns,
        "worlds.number": 0,
        "worlds.cases": [],
        "worlds.ranges": found.ranges,
    }
    return with_overrides(experiment, overrides, "the fitted robot")

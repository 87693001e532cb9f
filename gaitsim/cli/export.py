"""`gaitsim export`."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.choices import ExportFormat
from gaitsim.cli.options import BestOf, Damage, Engine, ExportFile, MemberOf, RunName, World
from gaitsim.console.interrupts import all_or_nothing
from gaitsim.console.printing import echo, notice, report_files, status
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError

_robot = partial(typer.Option, rich_help_panel="For robots")
_servo = partial(typer.Option, rich_help_panel="For --format servo")


def export(
    run: RunName,
    format: Annotated[
        ExportFormat | None,
        typer.Option(
            metavar="FORMAT",
            help="Joint angles: mat (MATLAB, Octave), csv, npz (NumPy).\n\n"
            "Files for robots: servo (CSV in degrees), arduino (sketch for PCA9685 boards), "
            "dynamixel and feetech (CSV with goal positions), ros2 (action goal as YAML), "
            "rosbag2.\n\n"
            "The body in motion: html (web page), glb (glTF for Blender and others).\n\n"
            "The whole run: atlas (web page with the archive as a map of animated gaits), "
            "tensorboard.\n\n"
            "Default: from the extension of --out, otherwise 'mat'.",
        ),
    ] = None,
    out: ExportFile = None,
    generation: BestOf = None,
    member: MemberOf = None,
    damage: Damage = None,
    world: World = None,
    engine: Engine = None,
    generations: Annotated[
        str | None,
        typer.Option(
            metavar="N,N,…",
            help="Show the best individuals of several generations side by side, such as 1,50,300.",
        ),
    ] = None,
    calibration: Annotated[
        Path | None,
        _robot(
            metavar="FILE",
            help="Calibration file (TOML), which assigns a servo to each joint. Default: all "
            "servos at their centre in the standing pose.",
        ),
    ] = None,
    calibration_template: Annotated[
        Path | None,
        _robot(
            metavar="FILE",
            help="Write a template of a calibration file, to be filled in, and export nothing.",
        ),
    ] = None,
    speed: Annotated[
        float | None,
        _robot(help="Playback speed; 0.5 is half as fast as simulated. Default: 1."),
    ] = None,
    keyframe_ms: Annotated[
        int | None,
        _robot(min=1, max=60_000, help="Milliseconds between keyframes. Default: every frame."),
    ] = None,
    clip: Annotated[
        bool,
        _robot(
            "--clip", help="Clip angles to the range of the servos instead of reporting an error."
        ),
    ] = False,
    centre: Annotated[
        float | None, _servo(help="Servo angle, in degrees, when the joint is at zero. Default: 0.")
    ] = None,
    low: Annotated[
        float | None,
        _servo("--min", help="Minimum servo angle in degrees. Default: centre − 90."),
    ] = None,
    high: Annotated[
        float | None,
        _servo("--max", help="Maximum servo angle in degrees. Default: centre + 90."),
    ] = None,
) -> None:
    """Export the champion: its joint angles, a file for a robot, or the body in motion.

    [bold]Examples[/bold]

    gaitsim export spider --format mat

    gaitsim export spider --out gait.csv

    gaitsim export spider --damage "R1 femur stuck 20"

    gaitsim export spider --format html --generations 1,50,300

    gaitsim export spider --format servo --centre 90 --keyframe-ms 100

    gaitsim export spider --format arduino --calibration-template robot.toml

    gaitsim export spider --format arduino --calibration robot.toml

    gaitsim export spider --format ros2 --out goal.yaml

    gaitsim export spider --format glb

    gaitsim export spider --format tensorboard

    gaitsim export spider-atlas --format atlas
    """
    with status("Reading the run …"):
        # These imports take most of the start-up time.
        from gaitsim.cli.parsing import parse_body_changes, parse_individual, parse_individuals
        from gaitsim.exporting import FORMATS, Subject, check_flags, default_name
        from gaitsim.gait.gait_files import check_folder
        from gaitsim.hardware.exporting import export_template
        from gaitsim.hardware.options import Options
        from gaitsim.runs.files.folder import exports_folder, find_run
        from gaitsim.runs.snapshot import RunSnapshot

        opened = RunSnapshot(find_run(run))
    options = Options(calibration, keyframe_ms, speed, clip, centre, low, high)
    if out is not None and format is None:
        check_folder(out)
        out = out if out.suffix else out.with_suffix(".mat")
    chosen = _format(format, out)
    choices = {
        "--generation": generation,
        "--member": member,
        "--damage": damage,
        "--world": world,
        "--engine": engine,
        "--generations": generations,
    }
    check_flags(chosen, [*(name for name, value in choices.items() if value), *options.flags()])
    individuals = parse_individuals(generation, generations, member)
    if calibration_template is not None:
        if format is None or out is not None or options.flags():
            raise GaitsimError(
                "--calibration-template needs --format, and cannot be combined with --out or "
                "options for robots",
                where="--calibration-template",
                allowed="--format arduino, dynamixel or feetech; also --generation or --member",
            )
        with status("Simulating the champion …"):
            champion = opened.individual(parse_individual(generation, member))
            export_template(champion, chosen, calibration_template)
        report_files(calibration_template)
        echo(f"{calibration_template}: fill in this calibration, then give it to --calibration")
        return
    if out is not None and FORMATS[chosen].ending:
        check_folder(out)
    changed = parse_body_changes(damage, world, engine)
    items = FORMATS[chosen].items
    progress = Progress(chosen, items)
    if FORMATS[chosen].input == "run":
        subject = Subject(opened, begin=progress.expect, advance=progress.advance)
    else:
        with status("Simulating the champion …"):
            shown = tuple(changed(opened.individual(one)) for one in individuals or (None,))
            subject = Subject(opened, shown)
    path = out or exports_folder(opened.path) / default_name(chosen, subject)
    with all_or_nothing(), progress if items else status(f"Writing {path.name} …"):
        done = FORMATS[chosen].write(subject, path, options)
    report_files(path)
    for text in done.notices:
        notice(text)
    echo(f"{path}: {done.summary}")


def _format(format: ExportFormat | None, out: Path | None) -> str:
    """Return the format given by `--format`, or by the extension of `--out`."""
    from gaitsim.cli.parsing import choose_format
    from gaitsim.exporting import BY_ENDING, FORMATS

    if format is None:
        return choose_format(format, out, BY_ENDING, "mat", "gaits")
    ending = FORMATS[format].ending.rpartition(".")[2]
    if ending:
        choose_format(ending, out, (*BY_ENDING, "yaml"), ending, "gaits")
    return format

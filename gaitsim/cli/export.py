"""`gaitsim export`."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal, get_args

import typer

from gaitsim.choices import GaitFormat
from gaitsim.cli.console import echo, notice, wrote
from gaitsim.cli.options import BestOf, Damage, ExportFile, MemberOf, RunName, World
from gaitsim.cli.parsing import asked_body, file_format, which
from gaitsim.errors import GaitsimError
from gaitsim.gait.files.servo import ServoRange, servo_table, write_servo
from gaitsim.gait.files.writer import Gait, check_folder, gait_of, write_gait
from gaitsim.runs.files.folder import exports_folder, find_run
from gaitsim.runs.snapshot import RunSnapshot

Format = Literal[GaitFormat, "servo"]
_servo = partial(typer.Option, rich_help_panel="Servo table")


def export(
    run: RunName,
    format: Annotated[
        Format | None,
        typer.Option(
            help="MATLAB/Octave, CSV, NumPy, or a CSV of keyframes for servos. Default: as --out "
            "ends, or mat."
        ),
    ] = None,
    out: ExportFile = None,
    generation: BestOf = None,
    member: MemberOf = None,
    damage: Damage = None,
    world: World = None,
    keyframe_ms: Annotated[
        int | None,
        _servo(min=1, max=60_000, help="Milliseconds between two rows. Default: every frame."),
    ] = None,
    centre: Annotated[float | None, _servo(help="Degrees of the pose at rest. Default: 0.")] = None,
    low: Annotated[
        float | None, _servo("--min", help="Minimum degrees of the servos. Default: centre − 90.")
    ] = None,
    high: Annotated[
        float | None, _servo("--max", help="Maximum degrees. Default: centre + 90.")
    ] = None,
    clip: Annotated[
        bool,
        _servo("--clip", help="Clip angles beyond that range; otherwise they are an error."),
    ] = False,
) -> None:
    """Write the champion's joint angles to a file, in radians or for servos.

    [bold]Examples[/bold]

    gaitsim export spider --format mat

    gaitsim export spider --out gait.csv

    gaitsim export spider --damage "R1 femur stuck 20"

    gaitsim export spider --format servo --centre 90 --keyframe-ms 100
    """
    opened = RunSnapshot(find_run(run))
    if out is not None:
        check_folder(out)
        if format is None and not out.suffix:
            out = out.with_suffix(".mat")
    table = format == "servo"
    chosen = file_format("csv" if table else format, out, get_args(GaitFormat), "mat", "gaits")
    servo = {
        "--keyframe-ms": keyframe_ms,
        "--centre": centre,
        "--min": low,
        "--max": high,
        "--clip": clip or None,
    }
    idle = [name for name, value in servo.items() if value is not None]
    if idle and not table:
        raise GaitsimError(
            f"a {chosen} file does not take {' and '.join(idle)}",
            where="--format",
            allowed="servo, with these options",
        )
    servos = ServoRange.around(centre or 0.0, low, high) if table else None
    individual = asked_body(damage, world)(opened.individual(which(generation, member)))
    gait = gait_of(individual)
    ends = "servo.csv" if servos else chosen
    path = out or exports_folder(opened.path) / f"gait-{individual.stem}.{ends}"
    if servos:
        _export_servo(gait, servos, keyframe_ms, clip, path)
        return
    write_gait(gait, path, chosen)
    wrote(path)
    frames, joints = gait.angles.shape
    echo(f"{path}: {frames} frames × {joints} joints at {gait.frame_rate:g} Hz, radians")


def _export_servo(
    gait: Gait, servos: ServoRange, keyframe_ms: int | None, clip: bool, path: Path
) -> None:
    table = servo_table(gait, servos, keyframe_ms, clip=clip)
    write_servo(table, path)
    wrote(path)
    keyframes, joints = table.degrees.shape
    if table.clipped:
        notice(
            f"{table.clipped:,} of {table.degrees.size:,} angles were beyond {servos.low:g}° to "
            f"{servos.high:g}° and were clipped: this is not the gait that was evolved"
        )
    echo(
        f"{path}: {keyframes} keyframes × {joints} joints in {table.milliseconds[-1] / 1000:g} s, "
        f"degrees; at most {table.off:.2f}° from the gait"
    )

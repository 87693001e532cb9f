"""`gaitsim robots check`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from gaitsim.cli.console import echo, errors, print_json, record, status, wrote
from gaitsim.cli.facts import print_facts
from gaitsim.cli.options import Json
from gaitsim.cli.streams import machine_readable
from gaitsim.contracts import BodyFile, Facts
from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment
from gaitsim.experiment.body_files import reader_of
from gaitsim.experiment.loading import read_body
from gaitsim.registry import plugin_errors
from gaitsim.runs.files.atomic import write_bytes
from gaitsim.runs.files.folder import command

UNUSABLE = 1


def check(
    file: Annotated[Path, typer.Argument(help="A robot's file, such as URDF or MJCF.")],
    root: Annotated[
        list[Path] | None,
        typer.Option(
            help="Another folder whose meshes and packages the file may use; may be repeated."
        ),
    ] = None,
    model_out: Annotated[
        Path | None,
        typer.Option(help="Write the robot as it is simulated, in one file without meshes beside."),
    ] = None,
    json: Json = False,
) -> None:
    """Check whether a robot's file can be used, and show what was found in it.

    Shows mass, joints, legs and their sides, feet, servos and the standing pose, and all that was
    repaired. The exit code is 1 where the robot cannot be used.

    [bold]Examples[/bold]

    gaitsim robots check my_robot.urdf

    gaitsim robots check my_robot.urdf --root ../meshes --model-out robot.xml
    """
    reader_of(file)
    for folder in root or ():
        if not folder.is_dir():
            raise GaitsimError(f"folder not found: {folder}", where="--root")
    try:
        with status(f"Reading {file} …"):
            found, experiment = read_body(file, root or ())
            facts = _described(experiment)
    except GaitsimError as error:
        if json:
            print_json({"file": str(file), "usable": False, "problem": error.to_dict()})
        elif machine_readable():
            record("error", **error.to_dict())
        else:
            errors().print(f"{file} cannot be used: {error}", style="red")
        sys.exit(UNUSABLE)
    written = []
    if model_out is not None:
        write_bytes(model_out, found.text.encode())
        written.append(model_out)
    wrote(*written)
    if json:
        print_json(
            {
                "file": str(file),
                "usable": True,
                "name": found.name,
                "facts": facts,
                "repairs": list(found.repairs),
                "files": list(map(str, written)),
            }
        )
        return
    _print(file, found, facts)
    for path in written:
        echo(path)
    echo(f"\nLet it walk: {command('run', file if model_out is None else model_out)}")


def _described(experiment: Experiment) -> Facts:
    with plugin_errors(experiment.entries["organism"], "describing itself"):
        return experiment.organism.describe()


def _print(file: Path, found: BodyFile, facts: Facts) -> None:
    echo(f"{file}: {found.name}\n")
    repaired = dict.fromkeys(found.repairs, "") or {"nothing": ""}
    print_facts({**facts, "Repaired": repaired})

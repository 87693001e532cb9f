"""Check and list robots, and work with real ones."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from gaitsim.plugin import (
    FILES,
    ExperimentError,
    GaitsimError,
    Names,
    entries,
    find,
    load_class,
    option,
    plugin_errors,
)
from gaitsim.plugin.commands import (
    JSON,
    SET,
    Action,
    argument,
    choose_format,
    echo,
    errors,
    machine_readable,
    output,
    print_facts,
    print_json,
    print_record,
    report_files,
    status,
)
from gaitsim.plugin.runs import command, write_bytes

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Overrides


UNUSABLE = 1  # exit code


class ListRobots(Action):
    """List the installed robots and servos.

    [bold]Examples[/bold]

    gaitsim robots list

    gaitsim run robot --set organism.model=hexapod
    """

    json_lines: bool = JSON

    def do(self) -> None:
        """Print the robots and servos of each body that reads files."""
        from gaitsim.plugin import Organism
        from gaitsim.plugin.runs import readers

        for body, formats in readers().items():
            model, entry = load_class("organism", body), find("organism", body)
            assert issubclass(model, Organism)
            with plugin_errors(entry, "listing its robots and servos"):
                facts = model.library()
            if self.json_lines:
                print_json({"body": body, "formats": formats, **facts})
                continue
            print_facts(facts)
            listed = ", ".join(f".{suffix}" for suffix in formats)
            output().print(f"\nFile types that the body {body} reads: {listed}", style="dim")


class CheckRobot(Action):
    """Check whether a robot file can be used, and show its contents.

    The command shows the robot's mass, joints, legs (and which side each is on), feet, servos and
    standing pose, and what gaitsim corrected in the file's contents. The file itself does not
    change. The exit code is 1 if the robot cannot be used.

    [bold]Examples[/bold]

    gaitsim robots check my_robot.urdf

    gaitsim robots check my_robot.urdf --picture my_robot.png

    gaitsim robots check my_robot.urdf --set organism.scale=0.001

    gaitsim robots check my_robot.urdf --root ../meshes --model-out robot.xml
    """

    file: Path = argument("robot file, such as URDF or MJCF", "FILE", completion="")
    set_: Names | None = SET
    root: Names | None = option(
        None,
        "additional folder from which meshes and ROS packages (package://) may be read",
        placeholder="FOLDER",
    )
    picture: Path | None = option(
        None, "draw the robot in its standing pose to this file", placeholder="FILE.png"
    )
    model_out: Path | None = option(
        None, "write the robot, as it is simulated, to one file that needs no mesh files"
    )
    json_lines: bool = JSON

    def do(self) -> None:
        """Read and describe the robot; write the files."""
        from gaitsim.plugin import BodyFile
        from gaitsim.plugin.gait import check_folder
        from gaitsim.plugin.pictures import write_still
        from gaitsim.plugin.runs import (
            load_experiment,
            parse_assignments,
            reader_of,
            standing_skeleton,
        )

        file, picture, model_out = self.file, self.picture, self.model_out
        roots = [Path(folder) for folder in self.root or ()]
        option, overrides = reader_of(file)[1], parse_assignments(self.set_ or ())
        for folder in roots:
            if not folder.is_dir():
                raise GaitsimError(f"folder not found: {folder}", where="--root")
        if picture is not None:
            choose_format(None, picture, ("png",), "png", "pictures")
            check_folder(picture)
        if model_out is not None:
            _check_model_out(model_out)
        for key in {f"organism.{option}", "organism.plugin"} & overrides.keys():
            raise GaitsimError(f"{key} cannot be set, as the command checks {file}", where="--set")
        try:
            with status(f"Reading {file} …"):
                experiment = load_experiment(str(file), overrides, roots=roots)
                with plugin_errors(experiment.entries["organism"], "describing itself"):
                    facts = experiment.organism.describe()
                warnings = experiment.warnings()
                skeleton = None if picture is None else standing_skeleton(experiment)
        except GaitsimError as error:
            self._exit(error, overrides)
        body = experiment.organism
        text = getattr(body, option)
        found = body.imported() or BodyFile(experiment.name, text)
        written = []
        if model_out is not None:
            write_bytes(model_out, text.encode())
            written.append(model_out)
        if picture is not None and skeleton is not None:
            write_still(skeleton, picture, found.name, str(file))
            written.append(picture)
        report_files(*written)
        if self.json_lines:
            print_json(
                {
                    "file": str(file),
                    "usable": True,
                    "name": found.name,
                    "facts": facts,
                    "repairs": list(found.repairs),
                    "warnings": list(warnings),
                    "files": list(map(str, written)),
                }
            )
            return
        echo(f"{file}: {found.name}\n")
        repaired = dict.fromkeys(found.repairs, "") or {"nothing": ""}
        wrong = {"Warnings": dict.fromkeys(warnings, "")} if warnings else {}
        print_facts({**facts, "Repaired": repaired, **wrong})
        for path in written:
            echo(path)
        if model_out is not None:  # it is already scaled, and `scale` has its default again
            defaults = {
                f"organism.{name}"
                for name, field in type(body).model_fields.items()
                if getattr(body, name) == field.default
            }
            overrides = {key: overrides[key] for key in overrides if key not in defaults}
        pairs = [part for key, value in overrides.items() for part in ("--set", f"{key}={value}")]
        echo(f"\nEvolve a gait: {command('run', model_out or file, *pairs)}")

    def _exit(self, caught: GaitsimError, overrides: Overrides) -> NoReturn:
        """Report why the robot cannot be used, and exit; raise errors of `--set`."""
        problems = caught.problems if isinstance(caught, ExperimentError) else ()
        if any(problem.key in overrides for problem in problems):
            raise caught
        error = problems[0] if len(problems) == 1 else caught
        if self.json_lines:
            print_json({"file": str(self.file), "usable": False, "problem": error.to_dict()})
        elif machine_readable():
            print_record("error", **error.to_dict())
        else:
            errors().print(f"{self.file} cannot be used: {error}", style="red")
        sys.exit(UNUSABLE)


def _check_model_out(path: Path) -> None:
    """Check that the robot can be written to a new file whose extension gaitsim reads."""
    from gaitsim.plugin.gait import check_folder

    if path.suffix[1:].lower() not in entries(FILES):
        raise GaitsimError(
            f"{path} does not have the extension of a robot file",
            where="--model-out",
            allowed=", ".join(f".{suffix}" for suffix in entries(FILES)),
        )
    if os.path.lexists(path):
        raise GaitsimError(
            f"{path} already exists",
            where="--model-out",
            remedy="choose a different name, or delete the file first",
        )
    check_folder(path)

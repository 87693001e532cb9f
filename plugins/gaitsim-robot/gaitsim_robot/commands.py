"""Check and list robots, and work with real ones."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from gaitsim.plugin import (
    FILES,
    BodyFile,
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
from gaitsim_robot.errors import shorten

if TYPE_CHECKING:
    from gaitsim.plugin import Organism, Skeleton
    from gaitsim.plugin.runs import Experiment, Overrides


UNUSABLE = 1  # exit code
LINE = 110  # characters of a question and the option that answers it in one line


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
    standing pose, what gaitsim corrected in the file's contents, and what it guessed, as questions
    with the options that answer them. The file itself does not change. The exit code is 1 if the
    robot cannot be used.

    [bold]Examples[/bold]

    gaitsim robots check my_robot.urdf

    gaitsim robots check my_robot.urdf --picture my_robot.png

    gaitsim robots check my_robot.urdf --set organism.facing=-x --save my_robot.toml

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
        None,
        "draw the robot in its standing pose to this file, with its front, the names of its legs "
        "and its passive joints",
        placeholder="FILE.png",
    )
    model_out: Path | None = option(
        None, "write the robot, as it is simulated, to one file that needs no mesh files"
    )
    save: Path | None = option(
        None,
        "write an experiment with the robot and the options of --set, which 'gaitsim run' takes",
        placeholder="FILE.toml",
    )
    json_lines: bool = JSON

    def do(self) -> None:
        """Read and describe the robot; write the files."""
        from gaitsim.plugin.runs import (
            load_experiment,
            parse_assignments,
            reader_of,
            standing_skeleton,
        )

        file, option = self.file, reader_of(self.file)[1]
        overrides = parse_assignments(self.set_ or ())
        roots = [Path(folder) for folder in self.root or ()]
        self._check_options(roots)
        for key in {f"organism.{option}", "organism.plugin"} & overrides.keys():
            raise GaitsimError(f"{key} cannot be set, as the command checks {file}", where="--set")
        try:
            with status(f"Reading {file} …"):
                experiment = load_experiment(str(file), overrides, roots=roots)
                with plugin_errors(experiment.entries["organism"], "describing itself"):
                    facts = experiment.organism.describe()
                warnings, questions = experiment.warnings(), experiment.questions()
                skeleton = standing_skeleton(experiment) if self.picture else None
        except GaitsimError as error:
            self._exit(error, overrides)
        body = experiment.organism
        found = body.imported() or BodyFile(experiment.name, getattr(body, option))
        written = self._write(experiment, getattr(body, option), skeleton, found.name)
        if self.json_lines:
            print_json(
                {
                    "file": str(file),
                    "usable": True,
                    "name": found.name,
                    "facts": facts,
                    "repairs": list(found.repairs),
                    "warnings": list(warnings),
                    "questions": [
                        {"text": one.text, "option": f"organism.{one.option}", "value": one.value}
                        for one in questions
                    ],
                    "files": list(map(str, written)),
                }
            )
            return
        echo(f"{file}: {found.name}\n")
        repaired = dict.fromkeys(found.repairs, "") or {"nothing": ""}
        wrong = {"Warnings": dict.fromkeys(warnings, "")} if warnings else {}
        print_facts({**facts, "Repaired": repaired, **wrong})
        if questions:
            heading = "\nUnsure: paste an option to confirm it, or change its value"
            output().print(heading, style="bold")
        for one in questions:
            setting = shlex.join(["--set", f"organism.{one.option}={one.value}"])
            gap = "  " if len(one.text + setting) < LINE else "\n    "
            echo(f"  {one.text}{gap}{setting}")
        for path in written:
            echo(path)
        echo(f"\nEvolve a gait: {self._next_command(body, overrides)}")

    def _check_options(self, roots: Sequence[Path]) -> None:
        """Check the folders and the names of new files."""
        from gaitsim.plugin.gait import check_folder

        for folder in roots:
            if not folder.is_dir():
                raise GaitsimError(f"folder not found: {folder}", where="--root")
        if self.picture is not None:
            choose_format(None, self.picture, ("png",), "png", "pictures")
            check_folder(self.picture)
        if self.model_out is not None:
            _check_new(self.model_out, "--model-out", entries(FILES), "a robot file")
        if self.save is not None:
            _check_new(self.save, "--save", ("toml",), "an experiment file")

    def _write(
        self, experiment: Experiment, text: str, skeleton: Skeleton | None, name: str
    ) -> list[Path]:
        """Write the files, and return and report their paths."""
        from gaitsim.plugin.pictures import write_still
        from gaitsim.plugin.runs import write_bytes
        from gaitsim_robot.organism import Robot

        body, written = experiment.organism, []
        if self.model_out is not None:
            write_bytes(self.model_out, text.encode())
            written.append(self.model_out)
        if self.picture is not None and skeleton is not None:
            passive = body.anatomy.passive if isinstance(body, Robot) else ()
            details = f"{self.file}" + f"   ○ no motor: {shorten(passive)}" * bool(passive)
            write_still(skeleton, self.picture, name, details, pins=body.passive_places())
            written.append(self.picture)
        if self.save is not None:
            write_bytes(self.save, experiment.to_toml().encode())
            written.append(self.save)
        report_files(*written)
        return written

    def _next_command(self, body: Organism, overrides: Overrides) -> str:
        """Return the command that evolves a gait of the robot."""
        from gaitsim.plugin.runs import command

        if self.save is not None:
            return command("run", self.save)
        if self.model_out is not None:  # it is already scaled, and `scale` has its default again
            defaults = {
                f"organism.{name}"
                for name, field in type(body).model_fields.items()
                if getattr(body, name) == field.default
            }
            overrides = {key: overrides[key] for key in overrides if key not in defaults}
        pairs = [part for key, value in overrides.items() for part in ("--set", f"{key}={value}")]
        return command("run", self.model_out or self.file, *pairs)

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


def _check_new(path: Path, where: str, suffixes: Iterable[str], kind: str) -> None:
    """Check that a new file with one of the extensions can be written."""
    from gaitsim.plugin.gait import check_folder

    if path.suffix[1:].lower() not in suffixes:
        raise GaitsimError(
            f"{path} does not have the extension of {kind}",
            where=where,
            allowed=", ".join(f".{suffix}" for suffix in suffixes),
        )
    if os.path.lexists(path):
        raise GaitsimError(
            f"{path} already exists",
            where=where,
            remedy="choose a different name, or delete the file first",
        )
    check_folder(path)

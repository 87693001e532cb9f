"""`gaitsim export`."""

from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from gaitsim.actions.action import RUN, Action, argument, not_combinable
from gaitsim.actions.products import read_product
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Exporter, Subject
from gaitsim.errors import GaitsimError
from gaitsim.registry.loading import call_product


class Export(Action):
    """Export the champion: its joint angles, a file for a robot, or the body in motion.

    [bold]Examples[/bold]

    gaitsim export spider --format mat

    gaitsim export spider --out gait.csv

    gaitsim export spider --damage "R1 femur stuck 20"

    gaitsim export spider --format html --generations 1,10,150

    gaitsim export spider --format servo --centre 90 --keyframe-ms 100

    gaitsim export spider --format arduino --calibration-template robot.toml

    gaitsim export spider --format arduino --calibration robot.toml

    gaitsim export spider --format ros2 --out goal.yaml

    gaitsim export spider --format glb

    gaitsim export fly --format motion --out flies.csv --population last

    gaitsim export spider --format tensorboard

    gaitsim export spider-atlas --format atlas
    """

    plugins: ClassVar[str] = "exporter"

    run: str = argument(RUN, "RUN")
    format: str | None = option(
        None,
        "format:\n\n{}\n\nDefault: from the extension of --out, otherwise 'mat'",
        placeholder="FORMAT",
        completion="export_formats",
    )
    out: Path | None = option(None, "file to write", unset="a file in the run's exports folder")
    options: dict[str, Any] = Field({}, description="options of the format, by name")

    def do(self) -> None:
        """Write the file or folder."""
        from gaitsim.console.interrupts import all_or_nothing
        from gaitsim.console.printing import echo, notice, report_files, status
        from gaitsim.console.progress_bar import Progress
        from gaitsim.gait.gait_files import check_folder
        from gaitsim.inspecting import DEFAULT, format_of, formats, write
        from gaitsim.storage.files.folder import exports_folder
        from gaitsim.storage.snapshot import RunSnapshot

        with status("Reading the run …"):
            out = self.out
            if out is not None and self.format is None:
                check_folder(out)
                out = out if out.suffix else out.with_suffix(f".{DEFAULT}")
            name = self.format
            if name is None:
                name = format_of(out, "add --format", "--out") if out else DEFAULT
            chosen, exporter = read_product("exporter", name, self.options)
            assert isinstance(exporter, Exporter)
            own = {Path(f"-{one}").suffix for one in (exporter.suffix, *exporter.other_suffixes)}
            others = {*formats(), ".yaml"} - own
            if out is not None and exporter.suffix and out.suffix.lower() in others:
                raise GaitsimError(
                    f"{out} ends with {out.suffix}, but --format is {self.format}",
                    allowed=", ".join(sorted(own)),
                    remedy="omit one of the two",
                )
            if out is not None and exporter.suffix:
                check_folder(out)
            if out is not None and exporter.other_file:
                raise not_combinable("--out", "--calibration-template")
            run = RunSnapshot.find(self.run)
        progress = Progress(name, exporter.items)
        subject = Subject(run, (), progress.expect, progress.advance)
        if exporter.input != "run":
            with status("Simulating the champion …"):
                subject = replace(subject, individuals=chosen.individuals(run))
        path = exporter.other_file or out
        if path is None:
            naming = "naming its file", str, exporter.file_name
            path = exports_folder(run.path) / call_product("exporter", name, *naming, subject)
        with all_or_nothing(), progress if exporter.items else status(f"Writing {path.name} …"):
            done = write(name, exporter, subject, path)
        report_files(path)
        for text in done.notices:
            notice(text)
        echo(f"{path}: {done.summary}")

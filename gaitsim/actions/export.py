"""`gaitsim export`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from gaitsim.actions.action import RUN, Action, argument, choose_format, not_combinable
from gaitsim.actions.products import read_product
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Exported, Exporter, Subject
from gaitsim.errors import GaitsimError
from gaitsim.registry.loading import call_product, load_product, products

if TYPE_CHECKING:
    from gaitsim.api import Run
    from gaitsim.individual import Individual

DEFAULT = "mat"


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
        from gaitsim.storage.files.folder import exports_folder
        from gaitsim.storage.snapshot import RunSnapshot

        with status("Reading the run …"):
            out = self.out
            if out is not None and self.format is None:
                check_folder(out)
                out = out if out.suffix else out.with_suffix(f".{DEFAULT}")
            name = format_of(out) if self.format is None else self.format
            chosen, exporter = read_product("exporter", name, self.options)
            assert isinstance(exporter, Exporter)
            ending = exporter.suffix.rpartition(".")[2]
            if out is not None and self.format is not None and ending:
                choose_format(ending, out, (*endings(), "yaml"), ending, "gaits")
            if out is not None and exporter.suffix:
                check_folder(out)
            if out is not None and exporter.other_file:
                raise not_combinable("--out", "--calibration-template")
            run = RunSnapshot.find(self.run)
        progress = Progress(name, exporter.items)
        subject = Subject(run, (), progress.expect, progress.advance)
        if exporter.input != "run":
            with status("Simulating the champion …"):
                subject = Subject(run, chosen.individuals(run))
        path = exporter.other_file or out
        if path is None:
            naming = "naming its file", str, exporter.file_name
            path = exports_folder(run.path) / call_product("exporter", name, *naming, subject)
        with all_or_nothing(), progress if exporter.items else status(f"Writing {path.name} …"):
            done = _write(name, exporter, subject, path)
        report_files(path)
        for text in done.notices:
            notice(text)
        echo(f"{path}: {done.summary}")


def endings() -> list[str]:
    """Return the formats that the extension of a file chooses."""
    return [name for name, one in products("exporter").items() if one.suffix == f".{name}"]  # type: ignore[attr-defined]


def format_of(path: Path | None) -> str:
    """Return the format that the extension of a file chooses.

    Raises:
        GaitsimError: the extension is unknown.
    """
    return choose_format(None, path, endings(), DEFAULT, "gaits")


def export(
    exported: "Individual | Run", path: str | Path, format: str | None = None, **options: Any
) -> Exported:
    """Write an individual or a run to a file, as `gaitsim export` does.

    Args:
        exported: an individual, such as a run's champion, `run.replay(12)` or
            `run.replay(world={...})`; or a run, for its champion or for a format that needs a
            whole run, such as 'atlas'.
        path: path of the file, or of a folder for some formats, such as 'arduino' and 'rosbag2'.
        format: a format listed by `gaitsim export --help`, such as 'mat', 'csv', 'arduino' or
            'ros2'; None takes the format from the file's extension, or else 'mat'.
        **options: options of the format, such as `calibration`, `keyframe_ms`, `speed`, `clip`,
            `centre`, `min` and `max`; `gaitsim plugins show FORMAT` lists them.

    Returns:
        A description of the file's content, and notices.

    Raises:
        GaitsimError: the format or an option is unknown, the body lacks something that the format
            needs (such as joint angles), the calibration is invalid, or the gait exceeds the
            limits of the servos.
        RunError: the file cannot be written.
    """
    from gaitsim.individual import Individual

    path = Path(path)
    ending = path.suffix[1:].lower()
    name = format or (ending if ending in endings() else DEFAULT)
    exporter = load_product("exporter", name, options)
    assert isinstance(exporter, Exporter)
    alone = isinstance(exported, Individual)
    if alone and exporter.input == "run":
        raise GaitsimError(
            f"the format {name!r} needs a whole run, not one individual",
            remedy="pass the run itself, from gaitsim.load()",
        )
    if isinstance(exported, Individual):
        subject = Subject(None, (exported,))
    else:
        run = exported.snapshot
        subject = Subject(run, () if exporter.input == "run" else (run.individual(),))
    return _write(name, exporter, subject, exporter.other_file or path)


def _write(name: str, exporter: Exporter, subject: Subject, path: Path) -> Exported:
    return call_product("exporter", name, "exporting", Exported, exporter.write, subject, path)

"""The formats of `gaitsim export`: the input, options and writer of each."""

import shlex
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, Literal

from gaitsim.errors import GaitsimError, unknown
from gaitsim.hardware.exporting import Exported, export_individual, file_name
from gaitsim.hardware.options import ACCEPTED_FLAGS, ENDINGS, Options, check_accepted_flags
from gaitsim.individual import Individual
from gaitsim.render.notebook import RunViews
from gaitsim.runs.snapshot import RunSnapshot

Input = Literal["individual", "individuals", "run"]
_ONE = ("--generation", "--member", "--damage", "--world", "--engine")
INPUT_FLAGS: Mapping[Input, tuple[str, ...]] = {
    "individual": _ONE,
    "individuals": (*_ONE, "--generations"),
    "run": (),
}
"""The flags that choose the individuals and change their body, for each kind of input."""


@dataclass(frozen=True)
class Subject:
    """The input of an export.

    Attributes:
        run: run on disk; None for an individual without a run.
        individuals: individuals to export; () for a format of a whole run.
        begin: function called with the total number of items, such as gaits or generations.
        advance: function called with the number of items finished since the last call.
    """

    run: RunSnapshot | None
    individuals: tuple[Individual, ...] = ()
    begin: Callable[[int], object] = lambda total: None
    advance: Callable[[int], object] = lambda done: None


Writer = Callable[[Subject, Path, Options], Exported]


@dataclass(frozen=True)
class Format:
    """A format of `gaitsim export`.

    Attributes:
        stem: beginning of a default file name.
        ending: extension of a default file name, with its dot; '' for a folder.
        input: kind of input: one individual, several individuals or a whole run.
        write: function that writes the file and returns a description of its content.
        options: flags that the format accepts besides those in `INPUT_FLAGS`.
        items: plural noun for the items in the progress bar; '' if writing is quick.
    """

    stem: str
    ending: str
    input: Input
    write: Writer
    options: tuple[str, ...] = ()
    items: str = ""

    @property
    def flags(self) -> tuple[str, ...]:
        """All flags that the format accepts."""
        return (*INPUT_FLAGS[self.input], *self.options)


def _write_gait(format: str, subject: Subject, path: Path, options: Options) -> Exported:
    return export_individual(subject.individuals[0], format, path, options)


def _write_page(subject: Subject, path: Path, options: Options) -> Exported:
    from gaitsim.render.page.player import write_page

    return Exported(write_page(subject.individuals, path, subject.run))


def _write_atlas(subject: Subject, path: Path, _: Options) -> Exported:
    from gaitsim.render.page.atlas import write_atlas

    assert subject.run is not None, "the input of this format is a run"
    return Exported(write_atlas(subject.run, path, begin=subject.begin, advance=subject.advance))


def _write_glb(subject: Subject, path: Path, _: Options) -> Exported:
    from gaitsim.render.glb import write_glb

    individual = subject.individuals[0]
    write_glb(individual, path)
    skeleton = individual.skeleton
    frames, rate = len(skeleton.segments), skeleton.frame_rate
    return Exported(f"animated glTF 2.0 of {frames:,} frames at {rate:g} Hz")


def _write_events(subject: Subject, path: Path, _: Options) -> Exported:
    from gaitsim.render.tensorboard import write_events

    assert subject.run is not None, "the input of this format is a run"
    subject.begin(subject.run.generation)
    notices = write_events(subject.run, path, subject.advance)
    show = f"tensorboard --logdir {shlex.quote(str(path))}"
    return Exported(f"{subject.run.generation:,} generations; to view them: {show}", notices)


FORMATS: Mapping[str, Format] = {
    **{
        name: Format("gait", ending, "individual", partial(_write_gait, name), ACCEPTED_FLAGS[name])
        for name, ending in ENDINGS.items()
    },
    "html": Format("page", ".html", "individuals", _write_page),
    "atlas": Format("atlas", ".html", "run", _write_atlas, items="gaits"),
    "glb": Format("body", ".glb", "individual", _write_glb),
    "tensorboard": Format("tensorboard", "", "run", _write_events, items="generations"),
}
"""All formats by name, in the order of `gaitsim.choices.ExportFormat`."""

BY_ENDING = tuple(name for name, format in FORMATS.items() if format.ending == f".{name}")
"""The formats that a file's extension can choose."""


def check_flags(format: str, given: Iterable[str]) -> None:
    """Raise an error for flags that a format does not accept.

    Raises:
        GaitsimError: a flag is not accepted by this format.
    """
    check_accepted_flags(format, given, {name: one.flags for name, one in FORMATS.items()})


def default_name(format: str, subject: Subject) -> str:
    """Return the default name of the exported file or folder."""
    chosen, shown = FORMATS[format], subject.individuals
    if format in ENDINGS:
        return file_name(shown[0], format)
    if not shown:
        return f"{chosen.stem}{chosen.ending}"
    if len(shown) == 1:
        return f"{chosen.stem}-{shown[0].stem}{chosen.ending}"
    first, last = shown[0].generation, shown[-1].generation
    return f"{chosen.stem}-generations-{first}-to-{last}{chosen.ending}"


def export(
    exported: Individual | RunViews, path: str | Path, format: str | None = None, **options: Any
) -> Exported:
    """Write an individual or a run to a file, as `gaitsim export` does.

    Args:
        exported: an individual, such as a run's champion, `run.replay(12)` or
            `run.replay(world={...})`; or a run, for its champion or for a format that needs a
            whole run, such as 'atlas'.
        path: path of the file, or of a folder for some formats, such as 'arduino' and 'rosbag2'.
        format: a format listed by `gaitsim export --help`, such as 'mat', 'csv', 'arduino' or
            'ros2'; None takes the format from the file's extension, or else 'mat'.
        **options: `calibration` (the path of a TOML file), `keyframe_ms`, `speed`, `clip`,
            `centre`, `low` and `high`, with the same meanings as the command's flags.

    Returns:
        A description of the file's content, and notices.

    Raises:
        GaitsimError: the format or an option is unknown, the body lacks something that the format
            needs (such as joint angles), the calibration is invalid, or the gait exceeds the
            limits of the servos.
        RunError: the file cannot be written.
    """
    path = Path(path)
    ending = path.suffix[1:].lower()
    format = format or (ending if ending in BY_ENDING else "mat")
    if format not in FORMATS:
        raise unknown("format", format, FORMATS)
    known = [field.name for field in fields(Options)]
    for name in options:
        if name not in known:
            raise unknown("option of export()", name, known)
    if options.get("calibration") is not None:
        options["calibration"] = Path(options["calibration"])
    given = Options(**options)
    check_flags(format, given.flags())
    return FORMATS[format].write(_subject(exported, format), path, given)


def _subject(exported: Individual | RunViews, format: str) -> Subject:
    """Return the input of an export; formats for individuals export a run's champion."""
    of_run = FORMATS[format].input == "run"
    if isinstance(exported, RunViews):
        run = exported.snapshot
        return Subject(run) if of_run else Subject(run, (run.individual(),))
    if of_run:
        raise GaitsimError(
            f"the format {format!r} needs a whole run, not one individual",
            remedy="pass the run itself, from gaitsim.load()",
        )
    return Subject(None, (exported,))

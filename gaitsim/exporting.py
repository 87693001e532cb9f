"""The formats of `gaitsim export`: what each is made of, the options it takes, and its writer."""

import shlex
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, Literal

from gaitsim.errors import GaitsimError, unknown
from gaitsim.hardware.exporting import Exported, export_individual, file_name
from gaitsim.hardware.options import ENDINGS, TAKES, Options, refuse_options
from gaitsim.individual import Individual
from gaitsim.render.notebook import RunViews
from gaitsim.runs.snapshot import RunSnapshot

Of = Literal["individual", "individuals", "run"]
_ONE = ("--generation", "--member", "--damage", "--world", "--engine")
CHOOSES: Mapping[Of, tuple[str, ...]] = {
    "individual": _ONE,
    "individuals": (*_ONE, "--generations"),
    "run": (),
}
"""The options that say which individuals, and on which body, by what a format is made of."""


@dataclass(frozen=True)
class Subject:
    """What is exported.

    Attributes:
        run: the run on disk; None for an individual on its own.
        individuals: one or more; () for a format of a whole run.
        begin: called with the number of what the format counts.
        advance: called with a number of these when they are done.
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
        stem: the beginning of a default file name.
        ending: the end of a default file name; '' for a folder.
        of: what it is made of.
        write: writes it to a path and says what the file holds.
        options: the flags that it takes, besides those of `CHOOSES`.
        counts: what its writer counts for its progress, in the plural; '' if it is quick.
    """

    stem: str
    ending: str
    of: Of
    write: Writer
    options: tuple[str, ...] = ()
    counts: str = ""

    @property
    def takes(self) -> tuple[str, ...]:
        """The flags that it takes."""
        return (*CHOOSES[self.of], *self.options)


def _write_gait(format: str, subject: Subject, path: Path, options: Options) -> Exported:
    return export_individual(subject.individuals[0], format, path, options)


def _write_page(subject: Subject, path: Path, options: Options) -> Exported:
    from gaitsim.render.page.player import write_page

    return Exported(write_page(subject.individuals, path, subject.run))


def _write_atlas(subject: Subject, path: Path, _: Options) -> Exported:
    from gaitsim.render.page.atlas import write_atlas

    assert subject.run is not None, "a format of a run has one"
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

    assert subject.run is not None  # as for every format of a whole run
    subject.begin(subject.run.generation)
    notices = write_events(subject.run, path, subject.advance)
    show = f"tensorboard --logdir {shlex.quote(str(path))}"
    return Exported(f"{subject.run.generation:,} generations; to see them: {show}", notices)


FORMATS: Mapping[str, Format] = {
    **{
        name: Format("gait", ending, "individual", partial(_write_gait, name), TAKES[name])
        for name, ending in ENDINGS.items()
    },
    "html": Format("page", ".html", "individuals", _write_page),
    "atlas": Format("atlas", ".html", "run", _write_atlas, counts="gaits"),
    "glb": Format("body", ".glb", "individual", _write_glb),
    "tensorboard": Format("tensorboard", "", "run", _write_events, counts="generations"),
}
"""All formats by name, in the order of `gaitsim.choices.ExportFormat`."""

BY_ENDING = tuple(name for name, format in FORMATS.items() if format.ending == f".{name}")
"""The formats that a file's ending names."""


def check_flags(format: str, given: Iterable[str]) -> None:
    """Refuse flags that a format does not take.

    Raises:
        GaitsimError: there are some.
    """
    refuse_options(format, given, {name: one.takes for name, one in FORMATS.items()})


def default_name(format: str, subject: Subject) -> str:
    """Return the default name of a file, or of a folder, of what is exported."""
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
        exported: such as a run's champion, `run.replay(12)` or `run.replay(world={...})`; a run
            for its champion, and for a format of whole runs.
        path: the file; a folder for 'arduino', 'rosbag2' and others.
        format: one of `gaitsim export --help`, such as 'mat', 'csv', 'arduino' or 'ros2'; None
            for the one that the file's ending names, or else 'mat'.
        **options: `calibration` (the path of a TOML file), `keyframe_ms`, `speed`, `clip`,
            `centre`, `low`, `high`, as the flags of the command.

    Returns:
        What the file holds, in words, and notices.

    Raises:
        GaitsimError: there is no such format or option, the body lacks what the format needs, such
            as joint angles, the calibration has problems, or the gait exceeds what the servos
            can do.
        RunError: it cannot be written.
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
    """Return what is exported: of a run its champion, where the format is of individuals."""
    of_run = FORMATS[format].of == "run"
    if isinstance(exported, RunViews):
        run = exported.snapshot
        return Subject(run) if of_run else Subject(run, (run.individual(),))
    if of_run:
        raise GaitsimError(
            f"the format {format} is of a whole run, not of an individual",
            remedy="give the run that gs.load() opens",
        )
    return Subject(None, (exported,))

"""Draw the figures of `gaitsim plot`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from gaitsim.choices import PlotFormat, PlotKind
from gaitsim.cli.parsing import BodyChange, choose_format
from gaitsim.console.printing import echo, notice, report_files, status
from gaitsim.console.progress_bar import Progress
from gaitsim.errors import GaitsimError, unsupported_flags
from gaitsim.individual import Choice
from gaitsim.render.plots.channel import KINDS_OF_CHANNELS, default_channel
from gaitsim.render.plots.kinds import ALL_OPTIONS, KINDS, file_stem
from gaitsim.render.plots.request import NothingToPlotError, Request
from gaitsim.render.plots.style import FORMATS, check_target, save
from gaitsim.runs.files.atomic import writing
from gaitsim.runs.files.folder import exports_folder


def plot_one(
    kind: PlotKind,
    request: Request,
    numbers: Sequence[Choice],
    changed: BodyChange,
    out: Path | None,
    format: PlotFormat | None,
) -> None:
    """Plot one kind."""
    if out is not None:
        choose_format(format, out, FORMATS, "png", "plots")
        check_target(out)
    if KINDS[kind].shows_motion:
        request = _with_individuals(request, numbers, changed)
    members = request.run.members if kind == "gaits" else None
    if members is None:
        with status("Plotting …"):
            figure = KINDS[kind].draw(request)
    else:
        with Progress("naming gaits", "members", len(members.scores)) as progress:
            figure = KINDS[kind].draw(replace(request, progress=progress.advance))
    path = out or exports_folder(request.run.path) / f"{file_stem(kind, request)}.{format or 'png'}"
    save(figure, path, request.theme)
    report_files(path)
    echo(path)


def plot_all(
    request: Request,
    numbers: Sequence[Choice],
    changed: BodyChange,
    out: Path | None,
    format: PlotFormat,
) -> None:
    """Plot every kind that applies; report why the others do not."""
    if out is not None and out.exists() and not out.is_dir():
        raise GaitsimError(
            f"--kind all writes several files, and {out} is a file",
            where="--out",
            allowed="a folder, created if missing",
        )
    request = _with_individuals(request, numbers, changed)
    folder = out or exports_folder(request.run.path)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with Progress("plots", "kinds", len(KINDS)) as progress:
        for kind in KINDS:
            try:
                if kind == "channel" and request.channel is None:
                    _check_channel(request)
                # --channel is only for the kind "channel" here.
                one = request if kind == "channel" else replace(request, channel=None)
                figure = KINDS[kind].draw(one)
            except NothingToPlotError as error:
                notice(f"No plot of kind {kind!r}: {error.what}")
            else:
                path = folder / f"{file_stem(kind, one)}.{format}"
                save(figure, path, request.theme)
                report_files(path)
                echo(path)
            progress.advance()


def _check_channel(request: Request) -> None:
    """Reject a default channel that a different kind of plot already draws."""
    name = default_channel(request.individual)
    if name in KINDS_OF_CHANNELS:
        raise NothingToPlotError(
            f"{KINDS_OF_CHANNELS[name]!r} draws the channel {name!r}; choose a different channel "
            "with --channel"
        )


def _with_individuals(request: Request, numbers: Sequence[Choice], changed: BodyChange) -> Request:
    """Return the request with its individuals, on their changed bodies."""
    with status("Simulating the champion …"):
        found = tuple(changed(request.run.individual(number)) for number in numbers or (None,))
    return replace(request, individuals=found)


def check_options(kind: Literal[PlotKind, "all"], given: Mapping[str, object]) -> None:
    """Check that the kind of plot uses all given options."""
    supported = ALL_OPTIONS if kind == "all" else KINDS[kind].options
    unused = [name for name, value in given.items() if value and name not in supported]
    if unused:
        kinds = [one for one, known in KINDS.items() if {*unused} <= {*known.options}]
        subject, allowed = f"a plot of kind {kind!r}", ", ".join(sorted(supported))
        raise unsupported_flags(subject, unused, "--kind", kinds, allowed=allowed)

"""`gaitsim lineage`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import option
from gaitsim.plugin.commands import JSON, WORKERS, ChosenIndividual, argument

if TYPE_CHECKING:
    from gaitsim_lineage.lineage import Lineage

NARROW = 24  # characters of a description, at least


class ShowLineage(ChosenIndividual):
    """Show the ancestors of the champion, and which change brought which gain.

    The search is repeated with the recorded scores, without moving bodies. Every ancestor is then
    re-evaluated beside its parent. For the largest rises, the changed genes are tried one by
    one: in the parent alone, and left out of the child.

    The table lists the ancestors that scored higher than all before them. Other commands take their
    numbers, such as 12:34 for individual 34 of generation 12.

    [bold]Examples[/bold]

    gaitsim lineage spider-genetic

    gaitsim lineage millipede --generation 2

    gaitsim lineage spider-atlas --member 12

    gaitsim lineage creature --all --json

    gaitsim play spider-genetic --generation 2:3

    gaitsim video spider-genetic --generations 1:4,2:3

    gaitsim lineage spider-genetic --video ancestors.mp4 --page ancestors.html

    gaitsim plot spider-genetic --kind lineage
    """

    title: ClassVar[str] = "Lineage"

    run: str = argument(
        "name of a run in runs/, or its folder", "RUN", completion="run_names", shown=True
    )
    every: bool = option(
        False, "list every ancestor, not only those that scored a new best", flag="--all"
    )
    explain: int = option(
        5, "number of the largest rises whose changes are tried one by one", ge=0, le=10_000
    )
    video: Path | None = option(
        None,
        "write a video, MP4 or GIF, in which the most important ancestors walk side by side",
        placeholder="FILE",
    )
    page: Path | None = option(
        None,
        "write a web page in which the most important ancestors walk side by side",
        placeholder="FILE.html",
    )
    workers: int | None = WORKERS
    json_lines: bool = JSON

    def do(self) -> None:
        """Trace the line and print it."""
        from gaitsim.plugin.commands import Progress, print_json
        from gaitsim.plugin.runs import RunSnapshot
        from gaitsim_lineage.lineage import lineage

        self._check()
        run = RunSnapshot.find(self.run)
        which = self.choice
        with Progress(f"breeding {run.path} again", "generations") as progress:
            found = lineage(
                run,
                which,
                explain=self.explain,
                workers=self.workers,
                begin=progress.expect,
                advance=progress.advance,
            )
        if self.json_lines:
            print_json(found.to_dict())
        else:
            _print(found, every=self.every)
        self._show(found)

    def _check(self) -> None:
        """Check that the video and the page can be written."""
        from gaitsim.plugin import GaitsimError
        from gaitsim.plugin.gait import check_folder
        from gaitsim.plugin.pictures import VIDEO_FORMATS

        if self.video is not None and self.video.suffix[1:].lower() not in VIDEO_FORMATS:
            allowed = ", ".join(f".{one}" for one in VIDEO_FORMATS)
            what = f"unknown extension for a video: {self.video}"
            raise GaitsimError(what, where="--video", allowed=allowed)
        for path in filter(None, (self.video, self.page)):
            check_folder(path)

    def _show(self, found: Lineage) -> None:
        """Write the video and the page."""
        from gaitsim.plugin import Exporter, Subject, load_class
        from gaitsim.plugin.commands import Progress, all_or_nothing, report_files
        from gaitsim.plugin.pictures import RenderSettings, Video

        written = []
        with all_or_nothing():
            if self.video is not None:
                chosen = self.video.suffix[1:].lower()
                notes = {one.member: one.note for one in found.shown()}
                film = Video(
                    found.run,
                    [place for place in notes if place is not None],
                    RenderSettings(chosen),
                    lambda one: replace(one, note=notes[one.member]),
                )
                with Progress(self.video.name, "pictures", len(film)) as progress:
                    film.write(self.video, progress.advance)
                written.append(self.video)
            if self.page is not None:
                exporter = load_class("exporter", "html")()
                assert isinstance(exporter, Exporter), "its contract"
                exporter.write(Subject(found.run, found.shown()), self.page)
                written.append(self.page)
        report_files(*written)


def _print(found: Lineage, *, every: bool) -> None:
    """Print the paragraph, the table, the reasons and what to do next."""
    from gaitsim.plugin import shortened
    from gaitsim.plugin.commands import output, print_table
    from gaitsim.plugin.pictures import number, visible
    from gaitsim.plugin.runs import command, mark_of
    from gaitsim_lineage.lineage import signed

    console, steps, path = output(), found.steps, found.run.path
    console.print(f"{path}: the ancestors of {found.individual.label}", style="bold")
    console.print(visible(found.paragraph()), markup=False, highlight=False)
    console.print()
    rows = []
    room = max(console.width - 48, NARROW)
    for index in range(len(steps)) if every else found.records:
        step = steps[index]
        what = shortened(visible(step.what), room)
        place = mark_of(step.place)[1:]
        rows.append([place, number(step.score), signed(step.gain), step.how, what])
    heads = ["individual", "score", "gain", "how", "what changed"]
    print_table(heads, rows, numbers=["score", "gain"])
    explained = [(step, step.why) for step in steps if step.why]
    if explained:
        console.print()
    for step, why in explained:
        text = f"{mark_of(step.place)[1:]}: {signed(step.gain)}, {visible(why)}"
        console.print(text, markup=False, highlight=False)
    known = [step for step in steps if step.place.number]
    same = sum(step.reproduced for step in known)
    console.print(
        f"\n{same:,} of {len(known):,} ancestors score as recorded, to the bit", style="dim"
    )
    if len(steps) == 1:
        return
    chosen = ",".join(mark_of(steps[one].place)[1:] for one in found.records[-3:])
    for purpose, line in {
        "watch the last ones side by side": command("video", path, "--generations", chosen),
        "show the line on a plot": command("plot", path, "--kind", "lineage"),
    }.items():
        console.print(f"  {line}  # {purpose}", style="dim", soft_wrap=True)

"""`gaitsim plot`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from gaitsim.actions.action import RUN, Action, SeveralIndividuals, argument, choose_format
from gaitsim.actions.products import ALL, read_all, read_product
from gaitsim.choices import PlotFormat
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Plot, Product, Subject
from gaitsim.errors import ContractError, GaitsimError, NothingToPlotError
from gaitsim.registry.loading import call_product

if TYPE_CHECKING:
    from gaitsim.storage.snapshot import RunSnapshot


class MakePlot(Action):
    """Plot a run, or the motion of its champion, at the width of a journal column.

    [bold]Examples[/bold]

    gaitsim plot spider --kind fitness --out fitness.pdf

    gaitsim plot spider --kind footfall --window 4:7

    gaitsim plot spider --kind footfall --damage "L2 lost"

    gaitsim plot walker --kind footfall --world "friction 0.4"

    gaitsim plot quadruped --kind joints --channel torque

    gaitsim plot spider-atlas --kind archive

    gaitsim plot spider-front --kind parallel --measure "duty factor"

    gaitsim plot spider-atlas --kind gaits

    gaitsim plot fly --kind channel --channel altitude --generations 1,50,200

    gaitsim plot spider --kind all --format svg --theme dark
    """

    plugins: ClassVar[str] = "plot"

    run: str = argument(RUN, "RUN")
    kind: str = option(
        "fitness",
        "kind of plot:\n\n{}\n\nall: every kind that the run has data for",
        placeholder="KIND",
        completion="plot_kinds",
    )
    format: PlotFormat | None = option(
        None, "format of the figure", unset="from the extension of --out, otherwise 'png'"
    )
    out: Path | None = option(
        None,
        "file to write; for --kind all, a folder, created if missing",
        unset="in the run's exports folder",
        placeholder="FILE|FOLDER",
    )
    options: dict[str, Any] = Field({}, description="options of the kind of plot, by name")

    def do(self) -> None:
        """Draw one plot, or every kind that applies."""
        from gaitsim.console.printing import status
        from gaitsim.storage.snapshot import RunSnapshot

        with status("Reading the run …"):
            if self.kind == ALL:
                chosen, kinds = read_all("plot", self.options)
            else:
                chosen, kind = read_product("plot", self.kind, self.options)
            run = RunSnapshot.find(self.run)
        if self.kind == ALL:
            self._plot_all(run, chosen, kinds)
        else:
            self._plot_one(run, chosen, kind)

    def _plot_one(self, run: "RunSnapshot", chosen: SeveralIndividuals, kind: Product) -> None:
        from gaitsim.console.printing import status
        from gaitsim.console.progress_bar import Progress
        from gaitsim.render.plots.style import FORMATS, check_target
        from gaitsim.storage.files.folder import exports_folder

        if self.out is not None:
            choose_format(self.format, self.out, FORMATS, "png", "plots")
            check_target(self.out)
        if kind.input == "run":
            subject = Subject(run)
        else:
            with status("Simulating the champion …"):
                subject = Subject(run, chosen.individuals(run))
        path = self.out or (
            exports_folder(run.path)
            / f"{file_stem(self.kind, kind, subject)}.{self.format or 'png'}"
        )
        progress = Progress(f"plotting {kind.items}", kind.items)
        subject = Subject(run, subject.individuals, progress.expect, progress.advance)
        with progress if kind.items else status("Plotting …"):
            _draw(self.kind, kind, subject, path)

    def _plot_all(
        self, run: "RunSnapshot", chosen: SeveralIndividuals, kinds: dict[str, Product]
    ) -> None:
        """Plot every kind that applies; report why the others do not."""
        from gaitsim.console.printing import notice, status
        from gaitsim.console.progress_bar import Progress
        from gaitsim.storage.files.atomic import writing
        from gaitsim.storage.files.folder import exports_folder

        if self.out is not None and self.out.exists() and not self.out.is_dir():
            raise GaitsimError(
                f"--kind all writes several files, and {self.out} is a file",
                where="--out",
                allowed="a folder, created if missing",
            )
        with status("Simulating the champion …"):
            subject = Subject(run, chosen.individuals(run))
        folder = self.out or exports_folder(run.path)
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        broken: ContractError | None = None
        with Progress("plots", "kinds", len(kinds)) as progress:
            for name, kind in kinds.items():
                try:
                    assert isinstance(kind, Plot)
                    call_product("plot", name, "checking", object, kind.check_among_all, subject)
                    stem = file_stem(name, kind, subject)
                    _draw(name, kind, subject, folder / f"{stem}.{self.format or 'png'}")
                except NothingToPlotError as error:
                    notice(f"No plot of kind {name!r}: {error.what}")
                except ContractError as error:  # of one package, after the plots of the others
                    broken = broken or error
                progress.advance()
        if broken is not None:
            raise broken


def _draw(name: str, kind: Product, subject: Subject, path: Path) -> None:
    from matplotlib.figure import Figure

    from gaitsim.console.printing import echo, report_files
    from gaitsim.render.plots.style import THEMES, save

    assert isinstance(kind, Plot)
    figure = call_product("plot", name, "drawing", Figure, kind.draw, subject)
    save(figure, path, THEMES[kind.theme])
    report_files(path)
    echo(path)


def file_stem(name: str, kind: Product, subject: Subject) -> str:
    """Return the name of a plot's file without extension: 'channel-margin-generation-138'."""
    words = call_product("plot", name, "naming its file", tuple, kind.words, subject)
    parts = [name, *map(str, words)]
    if kind.input != "run":
        numbers = [str(individual.generation) for individual in subject.individuals]
        shown = "-".join(numbers) if len(numbers) <= 4 else f"{numbers[0]}-to-{numbers[-1]}"
        several = kind.input == "individuals" and len(numbers) > 1
        parts.append(f"generation-{shown}" if several else subject.individual.stem)
    stem = "-".join(parts)
    return "".join(char if char.isalnum() or char in "-_" else "-" for char in stem)

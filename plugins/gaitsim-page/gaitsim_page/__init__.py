"""Web pages: individuals and archives in 3D, galleries of runs, and a playground."""

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from gaitsim.plugin import Exported, Exporter, Subject

if TYPE_CHECKING:
    from gaitsim.plugin import Input
    from gaitsim.plugin.runs import Individual


class Html(Exporter):
    """A web page that plays individuals in 3D, even offline."""

    title: ClassVar[str] = "Web page"
    group: ClassVar[str] = "The body in motion"
    note: ClassVar[str] = "web page"
    suffix: ClassVar[str] = ".html"
    stem: ClassVar[str] = "page"
    input: ClassVar["Input"] = "individuals"

    def check(self, individual: "Individual") -> None:
        """Check that the body can be drawn."""
        from gaitsim.plugin.pictures import clip_of

        clip_of(individual)

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the page."""
        from gaitsim_page.player import write_page

        return Exported(write_page(subject.individuals, path, subject.run))

    def embedded(self, subject: Subject) -> bytes:
        """Return the page, to be part of a notebook."""
        from gaitsim_page.player import page

        return page(subject.individuals, subject.run, embedded=True)


class AtlasPage(Exporter):
    """A web page with the archive as a map of animated gaits."""

    title: ClassVar[str] = "Archive as a web page"
    group: ClassVar[str] = "The whole run"
    note: ClassVar[str] = "web page with the archive as a map of animated gaits"
    suffix: ClassVar[str] = ".html"
    stem: ClassVar[str] = "atlas"
    input: ClassVar["Input"] = "run"
    items: ClassVar[str] = "gaits"

    def check(self, individual: "Individual") -> None:
        """Check that the search keeps an archive."""
        from gaitsim.plugin.pictures import require_archive

        require_archive(individual)

    def write(self, subject: Subject, path: Path) -> Exported:
        """Write the page."""
        from gaitsim_page.atlas import write_atlas

        run = subject.whole_run
        return Exported(write_atlas(run, path, begin=subject.begin, advance=subject.advance))

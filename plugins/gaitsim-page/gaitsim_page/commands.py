"""`gaitsim gallery` and `gaitsim playground`."""

import sys
from pathlib import Path

from gaitsim.plugin import option
from gaitsim.plugin.commands import Action, argument


class WriteGallery(Action):
    """Create a website from a folder of runs, with a page for each run that plays its champion.

    Within each body and fitness, the best run comes first. The site needs no server: open its
    index.html, or copy the folder to any web server.

    [bold]Examples[/bold]

    gaitsim gallery

    gaitsim gallery runs/ --out site/
    """

    root: Path = argument("folder that holds the runs", "FOLDER", Path("runs"), completion="")
    out: Path = option(
        Path("site"),
        "folder of the website; an existing website of runs is replaced",
        placeholder="FOLDER",
    )

    def do(self) -> None:
        """Write the website."""
        from gaitsim.plugin.commands import (
            INTERRUPTED,
            Progress,
            echo,
            interruptible,
            notice,
            report_files,
        )
        from gaitsim.plugin.runs import check_root
        from gaitsim_page.gallery import write_gallery

        check_root(self.root)
        try:
            with interruptible(), Progress("gallery", "runs") as progress:
                begin, advance = progress.expect, progress.advance
                site = write_gallery(self.root, self.out, begin=begin, advance=advance)
        except KeyboardInterrupt:
            notice(f"Stopped; {self.out} contains the runs that were finished.")
            sys.exit(INTERRUPTED)
        report_files(site.index)
        for name, reason in site.problems:
            notice(f"{name}: {reason}")
        echo(f"{site.index}: {site.shown} run{'s' * (site.shown != 1)}")


class WritePlayground(Action):
    """Write a web page (one file) on which visitors evolve a spider, even offline.

    Visitors watch the champion walk while it learns, remove a leg, change the weights of the
    score, and play and copy challenge codes. A run on the page has the bits of the run whose
    command the page shows.

    [bold]Examples[/bold]

    gaitsim playground

    gaitsim playground --seed 7 --out spider.html
    """

    out: Path = option(Path("playground.html"), "path of the page", placeholder="FILE.html")
    seed: int = option(0, "seed of the first run on the page", ge=0, le=2**31 - 1)

    def do(self) -> None:
        """Write the page."""
        from gaitsim.plugin.commands import echo, report_files, status
        from gaitsim_page.playground import write_page

        with status("Preparing the page …"):
            description = write_page(self.out, self.seed)
        report_files(self.out)
        echo(f"{self.out}: {description}")

"""`gaitsim gallery` and `gaitsim steer`."""

import sys
from pathlib import Path

from gaitsim.actions.action import SET, Action, argument
from gaitsim.choices import STEERING_PRESET
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError

ALLOWED = "COMMAND=RUN, COMMAND=RUN@GENERATION or COMMAND=FILE of a champion"


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
        from gaitsim.actions.runs import check_root
        from gaitsim.console import INTERRUPTED
        from gaitsim.console.interrupts import interruptible
        from gaitsim.console.printing import echo, notice, report_files
        from gaitsim.console.progress_bar import Progress
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


class Steer(Action):
    """Fly a body with the keyboard: each key puts another trained network in control.

    The keys select steering commands, such as climb or left. Each command has its own network.

    [bold]Examples[/bold]

    gaitsim steer

    gaitsim steer fly-steer-hover --controller climb=runs/fly-steer-climb

    gaitsim steer --out fly.html
    """

    experiment: str = argument(
        "name of a preset or path of an experiment file whose body can be steered",
        "NAME|FILE",
        STEERING_PRESET,
        completion="preset_names",
    )
    controller: Names | None = option(
        None,
        "while this steering command is active, control the body with the champion of a run, the "
        "best individual of its generation N, or a champion file",
        placeholder="COMMAND=RUN[@N]|FILE",
    )
    set_: Names | None = SET
    out: Path | None = option(
        None,
        "write a web page (one file) in which the body can be steered, instead of opening the "
        "terminal UI",
        placeholder="FILE.html",
    )

    def do(self) -> None:
        """Open the terminal UI, or write the page."""
        from gaitsim.cli.tui import check_terminal, run_app
        from gaitsim.experiment import load_experiment, parse_assignments
        from gaitsim.runs.files.folder import command
        from gaitsim.steering import Drive, controllers_of

        if self.out is None:
            check_terminal("write a web page instead: gaitsim steer --out fly.html")
        loaded = load_experiment(self.experiment, parse_assignments(self.set_ or ()))
        replaced = dict(map(_parse_controller, self.controller or ()))
        controllers = controllers_of(loaded, replaced)
        if self.out is not None:
            from gaitsim.console.printing import echo, report_files
            from gaitsim_page.steering import write_page

            description = write_page(loaded, controllers, self.out)
            report_files(self.out)
            echo(f"{self.out}: {description}")
            return
        from gaitsim.tui.app import GaitsimApp
        from gaitsim.tui.config import config_path, read_config
        from gaitsim.tui.screens.steering import Steering

        body = [] if self.experiment == STEERING_PRESET else [self.experiment]
        options = [part for text in self.controller or () for part in ("--controller", text)]
        options += [part for text in self.set_ or () for part in ("--set", text)]
        line = command("steer", *body, *options)
        drive = Drive(loaded, controllers)
        config = read_config(config_path())
        run_app(GaitsimApp(config=config, first=lambda: Steering(lambda: drive, line)))


def _parse_controller(text: str) -> tuple[str, str]:
    """Return the command and the individual in a value of `--controller`."""
    name, equals, reference = text.partition("=")
    if not (name and equals and reference):
        raise GaitsimError(f"invalid controller: {text!r}", where="--controller", allowed=ALLOWED)
    return name, reference

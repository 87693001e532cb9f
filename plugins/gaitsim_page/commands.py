"""`gaitsim gallery`, `gaitsim playground` and `gaitsim steer`."""

import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from gaitsim.actions.action import SET, Action, argument, not_combinable
from gaitsim.choices import STEERING_PRESETS
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.contracts import Genomes
    from gaitsim.experiment import Experiment

ALLOWED = "NAME=RUN, NAME=RUN@GENERATION or NAME=FILE of a champion"


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
        from gaitsim.console import INTERRUPTED
        from gaitsim.console.interrupts import interruptible
        from gaitsim.console.printing import echo, notice, report_files
        from gaitsim.console.progress_bar import Progress
        from gaitsim.storage.files.folder import check_root
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
        from gaitsim.console.printing import echo, report_files, status
        from gaitsim_page.playground import write_page

        with status("Preparing the page …"):
            description = write_page(self.out, self.seed)
        report_files(self.out)
        echo(f"{self.out}: {description}")


class Steer(Action):
    """Steer a body with the keyboard: drive a robot in physics, or fly a fly.

    With the name of a preset, a robot walks with the gait that its package made by hand; with a
    run or a challenge code, with the gait that evolved. A preset precedes a run of the same name:
    for the run, write runs/NAME. A drive can be saved as a run, which can be replayed, exported
    and filmed like any other. Gaits of the spider are played by spider-physics, its twin in
    physics, with the reflex heading; --set then changes options of the twin.

    Each key of the fly puts another trained network in control.

    [bold]Examples[/bold]

    gaitsim steer

    gaitsim steer hexapod

    gaitsim steer runs/hexapod --set organism.world.unevenness=0.01

    gaitsim steer quadruped --record runs/square

    gaitsim steer runs/spider

    gaitsim steer fly-steer-hover --controller climb=runs/fly-steer-climb

    gaitsim steer --out fly.html
    """

    body: str = argument(
        "name of a preset, path of an experiment file or a robot file, or individual whose body "
        "is steered: a run (its champion), RUN@N (the best individual of generation N), RUN#N "
        "(member N), a champion file or a challenge code",
        "NAME|FILE|RUN[@N|#N]|CODE",
        STEERING_PRESETS[0],
        completion="preset_or_run_names",
    )
    controller: Names | None = option(
        None,
        "use the champion of a run, the best individual of its generation N, or a champion file "
        "as this controller of the body",
        placeholder="NAME=RUN[@N]|FILE",
    )
    set_: Names | None = SET
    record: Path | None = option(
        None,
        "save each drive as a run in this folder, without asking; a number is added to an "
        "existing name",
        unset="the screen offers to save drives as runs/NAME-drive",
        placeholder="FOLDER",
    )
    out: Path | None = option(
        None,
        "write a web page (one file) in which the body can be steered, instead of opening the "
        "terminal UI",
        placeholder="FILE.html",
    )

    def do(self) -> None:
        """Open the terminal UI, or write the page."""
        from gaitsim.cli.tui import check_terminal, run_app
        from gaitsim.console.printing import echo, notice, status
        from gaitsim.steering import Drive
        from gaitsim.storage.files.folder import command

        if self.record is not None and self.out is not None:
            raise not_combinable("--record", "--out")
        if self.out is None:
            check_terminal("for the fly, write a web page instead: gaitsim steer --out fly.html")
        with status("Preparing the body …"):
            experiment, controllers, about = self._subject()
            drive = None if self.out is not None else Drive(experiment, controllers, about)
        if about:
            notice(about)
        if drive is None:
            self._write_page(experiment, controllers)
            return
        from gaitsim.tui.app import GaitsimApp
        from gaitsim.tui.config import config_path, read_config
        from gaitsim.tui.screens.steering import Steering

        if self.record is not None:
            drive.check_recordable()
        options = [part for text in self.controller or () for part in ("--controller", text)]
        options += [part for text in self.set_ or () for part in ("--set", text)]
        line = command(
            "steer", *([] if self.body == STEERING_PRESETS[0] else [self.body]), *options
        )
        config = read_config(config_path())
        screens: list[Steering] = []

        def first() -> Steering:
            screens.append(Steering(lambda: drive, line, record=self.record))
            return screens[0]

        run_app(GaitsimApp(config=config, first=first))
        for path in screens[0].saved if screens else ():
            echo(f"{path}: a recorded drive. Replay it: {command('play', path)}")

    def _subject(self) -> "tuple[Experiment, dict[str, Genomes], str]":
        """Return the experiment of the body, its controllers' genomes by name, and a notice."""
        from gaitsim.console.codes import read_challenge
        from gaitsim.experiment import load_experiment, parse_assignments, parse_experiment
        from gaitsim.steering import controllers_of, individual_subject, made_by_hand
        from gaitsim.storage.creation import find_individual

        overrides = parse_assignments(self.set_ or ())
        replaced = dict(map(_parse_controller, self.controller or ()))
        challenge = read_challenge(self.body)
        genome: Genomes | None
        if challenge is not None:
            load, genome = challenge.experiment_with, challenge.genome
        elif _names_individual(self.body):
            saved = find_individual(self.body)
            load, genome = partial(parse_experiment, saved.experiment, self.body), saved.genome
        else:
            load = partial(load_experiment, self.body)
            genome = made_by_hand(load(None))
        if genome is not None and not replaced:
            return individual_subject(load, genome, self.body, overrides)
        experiment = load(overrides)
        return experiment, controllers_of(experiment, replaced), ""

    def _write_page(self, experiment: "Experiment", controllers: "Mapping[str, Genomes]") -> None:
        from gaitsim.console.printing import echo, report_files
        from gaitsim_page.steering import write_page

        assert self.out is not None, "a page is written to this file"
        description = write_page(experiment, controllers, self.out)
        report_files(self.out)
        echo(f"{self.out}: {description}")


def _names_individual(reference: str) -> bool:
    """Return whether a reference is an individual rather than a preset or a file of a body."""
    from gaitsim.experiment.loading import is_body_file
    from gaitsim.registry import EXPERIMENTS, entries
    from gaitsim.storage.files.folder import RUNS, holds_run

    if reference in entries(EXPERIMENTS) or reference.endswith(".toml") or is_body_file(reference):
        return False
    run = reference.rstrip("0123456789").rstrip("@#")
    runs = (Path(one) for name in (reference, run) for one in (name, RUNS / name))
    return reference.endswith(".pickle") or any(map(holds_run, runs))


def _parse_controller(text: str) -> tuple[str, str]:
    """Return the controller and the individual in a value of `--controller`."""
    name, equals, reference = text.partition("=")
    if not (name and equals and reference):
        raise GaitsimError(f"invalid controller: {text!r}", where="--controller", allowed=ALLOWED)
    return name, reference

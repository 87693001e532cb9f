"""`gaitsim steer`."""

from pathlib import Path

from gaitsim.actions.steer import SteeredBody
from gaitsim.contracts.plugin import option


class Steer(SteeredBody):
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
    """

    record: Path | None = option(
        None,
        "save each drive as a run in this folder, without asking; a number is added to an "
        "existing name",
        unset="the screen offers to save drives as runs/NAME-drive",
        placeholder="FOLDER",
    )

    def do(self) -> None:
        """Open the terminal UI."""
        from gaitsim.cli.tui import check_terminal, run_app
        from gaitsim.console.printing import echo, notice, status
        from gaitsim.steering import SteeredDrive
        from gaitsim.storage.files.folder import command

        check_terminal("run it in a terminal")
        with status("Preparing the body …"):
            experiment, controllers, about = self.subject()
            drive = SteeredDrive(experiment, controllers, about)
        if about:
            notice(about)
        from gaitsim.tui.app import GaitsimApp
        from gaitsim.tui.config import config_path, read_config
        from gaitsim.tui.screens.steering import Steering

        if self.record is not None:
            drive.check_recordable()
        options = [part for text in self.controller or () for part in ("--controller", text)]
        options += [part for text in self.set_ or () for part in ("--set", text)]
        line = command("steer", *([] if self.body is None else [self.body]), *options)
        config = read_config(config_path())
        screens: list[Steering] = []

        def first() -> Steering:
            screens.append(Steering(lambda: drive, line, record=self.record))
            return screens[0]

        run_app(GaitsimApp(config=config, first=first))
        for path in screens[0].saved if screens else ():
            echo(f"{path}: a recorded drive. Replay it: {command('play', path)}")

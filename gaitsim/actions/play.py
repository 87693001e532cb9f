"""`gaitsim play`."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from gaitsim.actions.action import RUN_OR_CODE, OneIndividual, argument
from gaitsim.choices import TerminalView
from gaitsim.contracts.plugin import option
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from rich.console import Group

    from gaitsim.individual import Individual
    from gaitsim.render.scene.clip import Clip
    from gaitsim.render.terminal.body import Viewpoint

FPS = 20
SPEEDS = 0.01, 100.0
SIZE = 80, 24  # columns and rows of a still if the output is not a terminal


class Play(OneIndividual):
    """Play a champion in the terminal until Ctrl-C.

    [bold]Examples[/bold]

    gaitsim play spider

    gaitsim play spider --generation 10 --view side --speed 0.25

    gaitsim play fly --whole --at 2.5

    gaitsim play spider --damage "L2 lost" --damage "R1 femur stuck 20"

    gaitsim play walker --world "friction 0.4" --world "servo_torque 0.7"

    gaitsim play quadruped --engine bullet

    gaitsim play gaitsim1-AAAA-hNh…
    """

    run: str = argument(RUN_OR_CODE, "RUN|CODE")
    view: TerminalView = option("iso", "direction of the camera")
    speed: float = option(
        1.0, "playback speed, relative to real time", allowed="0.01 to 100; 1 is real time"
    )
    whole: bool = option(
        False, "show the whole path with a fixed camera, instead of following the body"
    )
    once: bool = option(False, "play the motion once instead of repeating it")
    at: float | None = option(
        None, "print a single picture of the motion at this time", ge=0, placeholder="SECONDS"
    )

    def do(self) -> None:
        """Play the motion, or print a picture."""
        from gaitsim.console.codes import read_individual
        from gaitsim.render.scene.clip import Clip
        from gaitsim.render.terminal.body import Viewpoint

        if not SPEEDS[0] <= self.speed <= SPEEDS[1]:
            raise GaitsimError(
                f"invalid speed: {self.speed:g}",
                where="--speed",
                allowed=f"{SPEEDS[0]:g} to {SPEEDS[1]:g}; 1 is real time",
            )
        found = self.changed(read_individual(self.run, self.choice))
        clip = Clip(found.skeleton)
        camera = Viewpoint(follow=not self.whole).named(self.view)
        if self.at is None:
            _loop(found, clip, camera, self.speed, self.once)
        else:
            _still(found, clip, camera, self.at)


def _still(found: Individual, clip: Clip, camera: Viewpoint, at: float) -> None:
    if not at <= clip.seconds:
        raise GaitsimError(
            f"{at:g} s is after the end of the motion",
            where="--at",
            allowed=f"0 to {clip.seconds:g}",
        )
    from gaitsim.console.printing import output

    console = output()
    columns, rows = (console.width, min(console.height, 40)) if console.is_terminal else SIZE
    console.print(_picture(found, clip, camera, at, columns, rows - 1))


def _loop(found: Individual, clip: Clip, camera: Viewpoint, speed: float, once: bool) -> None:
    from rich.live import Live

    from gaitsim.console.interrupts import interruptible
    from gaitsim.console.printing import output

    console = output()
    if not console.is_terminal:
        raise GaitsimError(
            "the output is not a terminal",
            remedy="print a still with --at SECONDS"
            + (f", or make a video: gaitsim video {found.source}" if found.source else ""),
        )
    duration = clip.seconds
    start = time.monotonic()
    try:
        with interruptible(), Live(console=console, screen=True, auto_refresh=False) as live:
            while True:
                seconds = (time.monotonic() - start) * speed
                if once and seconds >= duration:
                    break
                moment = seconds % duration if duration else 0.0
                columns, rows = console.size
                drawn = _picture(found, clip, camera, moment, columns, rows)
                live.update(drawn, refresh=True)
                time.sleep(1 / FPS)
    except KeyboardInterrupt:
        pass


def _picture(
    found: Individual, clip: Clip, camera: Viewpoint, seconds: float, columns: int, rows: int
) -> Group:
    """Return a title line and the body."""
    from rich.console import Group
    from rich.text import Text

    from gaitsim.console.characters import BODY, lines
    from gaitsim.render.terminal.body import picture
    from gaitsim.render.terminal.text import number, visible

    title = Text(no_wrap=True, overflow="ellipsis", end="")
    title.append(visible(found.name), "bold")
    title.append(f"  {found.label}  score {number(found.score)}{found.over_worlds}")
    title.append(f"  {seconds:.2f} s of {clip.seconds:.2f} s", "dim")
    drawn = lines(*picture(clip, seconds, camera, columns, rows - 1), BODY)
    return Group(Text("\n").join([title, *drawn]))

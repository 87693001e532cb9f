"""Make the pictures of the documentation anew: `python docs_build/pictures.py`, a few minutes.

Each is made by gaitsim itself, of runs that are evolved for it: the same pictures every time, but
for the times on the screens of the terminal UI.
"""

import asyncio
import os
import re
import tempfile
from collections.abc import Awaitable, Callable
from pathlib import Path

from PIL import Image

import gaitsim as gs
from gaitsim.export.encoder import encode
from gaitsim.export.plots import LIGHT, picture
from gaitsim.export.video import Look, Video
from gaitsim.runs.reader import Run
from gaitsim.tui.app import GaitsimApp

HERE = Path(__file__).parents[1] / "docs" / "pictures"
SCREEN = 190  # dots an inch: plots are 3.4 inches wide, so that letters are sharp on a page
COLOURS = 64
FONTS = re.compile(r"@font-face\s*\{[^}]*\}")


def evolve() -> None:
    """The runs that are shown, in the folder runs/."""
    for preset, seed in (("spider", 0), ("fly", 3), ("millipede", 1), ("walker", 0)):
        for _ in gs.evolve(preset, seed=seed, out=f"runs/{preset}", **SHORT.get(preset, {})):
            pass
    for _ in gs.evolve("spider", generations=300, set=BOLD, out="runs/spider-bold"):
        pass


SHORT: dict[str, dict[str, int]] = {"spider": {"generations": 300}}
BOLD = {"mutation.rate": 0.3}


def plots() -> None:
    """Plots as `gaitsim plot` makes them."""
    spider, fly = gs.load("spider"), gs.load("fly")
    for kind in ("fitness", "terms", "footfall", "joints", "stability"):
        _plot(spider.plot(kind), f"spider-{kind}")
    _plot(fly.plot("path"), "fly-path")
    last = fly.champion.generation
    _plot(fly.plot("channel", channel="altitude", generations=[1, 20, last]), "fly-altitude")


def _plot(figure: object, name: str) -> None:
    path = HERE / f"{name}.png"
    path.write_bytes(picture(figure, "png", LIGHT, SCREEN))  # type: ignore[arg-type]
    _smaller(Image.open(path), path)


def _smaller(image: Image.Image, path: Path) -> None:
    """Write a picture with few colours, which it hardly shows."""
    image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def bodies() -> None:
    """Stills and short films of the champions."""
    for name, seconds, view in (
        ("spider", 4.2, "iso"),
        ("millipede", 0.75, "iso"),
        ("fly", 1.4, "iso"),
        ("walker", 2.0, "side"),
    ):
        still = gs.load(name).champion.picture(seconds, view=view, size=(640, 360))
        _smaller(still, HERE / f"{name}.png")
    _film("spider", "spider.gif", Look("gif", (400, 240), 15, 1, "iso", "light", False), 40)
    _film("fly", "fly.gif", Look("gif", (400, 240), 15, 0.25, "iso", "light", False), 50)
    champion = gs.load("spider").champion.generation
    several = Video(Run(Path("runs/spider")), (1, 20, champion), Look(size=(960, 320), intro=False))
    _smaller(Image.fromarray(list(several.pictures())[-1]), HERE / "spider-generations.png")


def _film(run: str, name: str, look: Look, pictures: int) -> None:
    made = [
        one
        for _, one in zip(
            range(pictures), Video(Run(Path("runs") / run), (), look).pictures(), strict=False
        )
    ]
    encode(made, HERE / name, format="gif", size=look.pixels, fps=look.rate, samples=made[::12])


def screens() -> None:
    """Screens of the terminal UI."""

    async def home(app: GaitsimApp, press: Press) -> None:
        await press("down")
        _screen(app, "tui-home")

    async def new(app: GaitsimApp, press: Press) -> None:
        await press("n")
        await asyncio.sleep(3)
        _screen(app, "tui-new")

    async def replay(app: GaitsimApp, press: Press) -> None:
        await press(*["down"] * 2, "r")
        await asyncio.sleep(6)
        await press("space")
        _screen(app, "tui-replay")

    for visit in (home, new, replay):
        asyncio.run(_visit(visit))


Press = Callable[..., Awaitable[None]]


async def _visit(visit: Callable[[GaitsimApp, Press], Awaitable[None]]) -> None:
    app = GaitsimApp(Path("runs"))
    async with app.run_test(size=(120, 34)) as pilot:
        await asyncio.sleep(3)

        async def press(*keys: str) -> None:
            await pilot.press(*keys)
            await asyncio.sleep(0.5)

        await visit(app, press)


def _screen(app: GaitsimApp, name: str) -> None:
    """Write the screen as SVG, without the fonts that it would fetch from elsewhere."""
    drawn = FONTS.sub("", app.export_screenshot(title="gaitsim tui"))
    drawn = drawn.replace("Fira Code", "DejaVu Sans Mono")
    (HERE / f"{name}.svg").write_text(drawn)


def main() -> None:
    """Make all of them."""
    HERE.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        evolve()
        plots()
        bodies()
        screens()


if __name__ == "__main__":
    main()

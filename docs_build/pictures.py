"""Regenerate the pictures in the documentation: `python docs_build/pictures.py`.

The script takes a few minutes. It evolves the runs that it needs, with fixed seeds, and draws them
with gaitsim. The pictures are reproducible, except for the times on screens of the terminal UI.
"""

import asyncio
import os
import re
import tempfile
from collections.abc import Awaitable, Callable
from itertools import islice
from pathlib import Path

import numpy as np
from PIL import Image

import gaitsim as gs
from gaitsim.gait import with_damage
from gaitsim.render.encoder import cells, encode, palette
from gaitsim.render.film import RenderSettings, write_still
from gaitsim.render.plots.style import LIGHT, picture
from gaitsim.render.scene import THEMES
from gaitsim.render.video import Video
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens.live import Live
from gaitsim.tui.screens.replay import Replay

HERE = Path(__file__).parents[1] / "docs" / "pictures"
DPI = 190  # dots per inch, for sharp letters: plots are 3.4 inches wide
FONTS = re.compile(r"@font-face\s*\{[^}]*\}")


def evolve() -> None:
    """Evolve the runs in the folder runs/."""
    for name, preset, seed, more in RUNS:
        for _ in gs.evolve(preset, seed=seed, out=f"runs/{name}", set=more):
            pass
    # The live screen resumes this run.
    for generation in gs.evolve("spider", seed=1, out=LIVE):
        if generation.number == 20:
            break


STARTS: dict[str, dict[str, object]] = {
    "spider": {},
    "spider-random": {"search.start": "random"},
}
RUNS: tuple[tuple[str, str, int, dict[str, object]], ...] = (
    # The home screen shows the latest runs.
    ("spider", "spider", 0, {}),
    ("fly", "fly", 3, {}),
    ("millipede", "millipede", 1, {}),
    ("walker", "walker", 0, {}),
    ("spider-front", "spider-front", 0, {}),
    ("quadruped", "quadruped", 0, {"evolution.generations": 50}),
)
LIVE = Path("runs/spider-1")


def plots() -> None:
    """Draw the plots, as `gaitsim plot` does."""
    spider, fly = gs.load("spider"), gs.load("fly")
    kinds = (
        "fitness",
        "terms",
        "genome",
        "footfall",
        "joints",
        "stability",
    )
    for kind in kinds:
        _plot(spider.plot(kind), f"spider-{kind}")
    starts = [gs.load_experiment("spider", {"name": name, **more}) for name, more in STARTS.items()]
    _plot(gs.compare(starts, repeats=30, evaluations=12_000).plot("convergence"), "spider-runs")
    _plot(fly.plot("path"), "fly-path")
    last = fly.champion.generation
    _plot(fly.plot("channel", channel="altitude", generations=[1, 20, last]), "fly-altitude")
    _plot(gs.load("spider-front").plot("front"), "spider-front")
    searches = gs.compare(["spider", "spider-genetic"], repeats=30, evaluations=5000)
    _plot(searches.plot("ecdf"), "spider-ecdf")


def _plot(figure: object, name: str) -> None:
    path = HERE / f"{name}.png"
    path.write_bytes(picture(figure, "png", LIGHT, DPI))  # type: ignore[arg-type]
    _write_with_palette(Image.open(path), path)


def _write_with_palette(image: Image.Image, path: Path) -> None:
    """Write an image with a reduced palette that keeps the exact colours of marks."""
    pixels = np.asarray(image.convert("RGB"))
    white = np.full((1, 3), 255, dtype=np.uint8)
    colours, indices = palette([pixels], np.concatenate([THEMES["light"].exact, white]))
    few = Image.fromarray(indices[cells(pixels)])
    few.putpalette(colours.tobytes())
    few.save(path, optimize=True)


def bodies() -> None:
    """Draw stills and short animations of the champions."""
    for name, seconds in (("spider", 4.2), ("millipede", 0.75), ("quadruped", 2.2)):
        still = gs.picture(gs.load(name).champion, seconds, size=(640, 360))
        _write_with_palette(still, HERE / f"{name}.png")
    damaged = with_damage(gs.load("spider").champion, ["L1 lost", "R3 femur stuck 20"])
    _write_with_palette(gs.picture(damaged, 3.2, size=(640, 360)), HERE / "spider-damaged.png")
    standing = HERE / "robot-standing.png"
    skeleton = gs.load("quadruped").champion.skeleton
    write_still(skeleton, standing, "quadruped", size=(640, 360))
    _write_with_palette(Image.open(standing), standing)
    _animation("spider", RenderSettings("gif", (400, 240), 15, intro=False), 40)
    _animation("fly", RenderSettings("gif", (400, 240), 25, intro=False), 75)
    _animation("walker", RenderSettings("gif", (400, 240), 15, 0.5, "side", intro=False), 45)
    champion = gs.load("spider").champion.generation
    several = Video(
        RunSnapshot(Path("runs/spider")),
        (1, 10, champion),
        RenderSettings(size=(960, 480), intro=False),
    )
    _write_with_palette(
        Image.fromarray(list(several.pictures())[-1]), HERE / "spider-generations.png"
    )


def _animation(run: str, settings: RenderSettings, frames: int) -> None:
    """Write the first frames of a champion's video as a GIF."""
    video = Video(RunSnapshot(Path("runs") / run), (), settings)
    images = list(islice(video.pictures(), frames))
    encode(
        images,
        HERE / f"{run}.gif",
        format="gif",
        size=settings.pixels,
        fps=settings.rate,
        samples=images[::12],
        exact=THEMES[settings.theme].exact,
    )


def screens() -> None:
    """Write screenshots of the terminal UI."""

    async def home(app: GaitsimApp, press: Press) -> None:
        await press(*["down"] * 6)  # the spider
        await asyncio.sleep(6)  # until the preview shows the champion
        _screenshot(app, "tui-home")

    async def new(app: GaitsimApp, press: Press) -> None:
        await press("n")
        await asyncio.sleep(3)
        _screenshot(app, "tui-new")

    async def replay(app: GaitsimApp, press: Press) -> None:
        app.push_screen(Replay(Path("runs/spider")))
        await asyncio.sleep(6)
        await press("space")
        _screenshot(app, "tui-replay")

    async def live(app: GaitsimApp, press: Press) -> None:
        screen = Live(LIVE, resume=True)
        app.push_screen(screen)
        async with asyncio.timeout(120):
            while not screen.is_mounted or screen.snapshot.generation < 75:
                await asyncio.sleep(0.1)
        await press("space")
        await asyncio.sleep(2)  # until the panels show the last of these quick generations
        _screenshot(app, "tui-live")
        await press("s")
        async with asyncio.timeout(60):
            while screen.snapshot.state not in ("stopped", "finished"):
                await asyncio.sleep(0.1)

    for visit, lines in ((home, 34), (new, 34), (replay, 34), (live, 40)):
        asyncio.run(_visit(visit, lines))


Press = Callable[..., Awaitable[None]]


async def _visit(visit: Callable[[GaitsimApp, Press], Awaitable[None]], lines: int) -> None:
    app = GaitsimApp(Path("runs"))
    async with app.run_test(size=(120, lines)) as pilot:
        await asyncio.sleep(3)

        async def press(*keys: str) -> None:
            await pilot.press(*keys)
            await asyncio.sleep(0.5)

        await visit(app, press)


def _screenshot(app: GaitsimApp, name: str) -> None:
    """Write a screenshot as SVG, without web fonts."""
    drawn = FONTS.sub("", app.export_screenshot(title="gaitsim tui"))
    drawn = drawn.replace("Fira Code", "DejaVu Sans Mono")
    (HERE / f"{name}.svg").write_text(drawn)


def main() -> None:
    """Regenerate all pictures."""
    HERE.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        evolve()
        plots()
        bodies()
        screens()


if __name__ == "__main__":
    main()

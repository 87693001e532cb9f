"""Pages in Chromium without a graphics card: frames per second, and milliseconds per frame.

    python benchmarks/page.py                     # a spider, evolved for 20 generations
    python benchmarks/page.py spider.html fly.html

The processor draws at 1280 × 800, with the network blocked. The benchmark needs Chromium and
Playwright. Other programs lower the frame rate; the milliseconds are those of the fastest of 30
frames, drawn one at a time.
"""

import argparse
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import gaitsim as gs

FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking"]
SECONDS = 4.0
MEASURE = """async (seconds) => {
    const { stage } = gaitsimPage;
    gaitsimPage.play(true);
    const rate = () => new Promise((go) => {
        let drawn = 0;
        const since = performance.now();
        const count = () => {
            drawn++;
            const elapsed = (performance.now() - since) / 1000;
            if (elapsed < seconds) return;
            stage.listeners.splice(stage.listeners.indexOf(count), 1);
            go(drawn / elapsed);
        };
        stage.listeners.push(count);
    });
    await rate();
    const frames = await rate();
    const ratio = Math.min(stage.resolution.ratio, stage.resolution.finest(stage.orbit.size));
    gaitsimPage.play(false);
    await new Promise((go) => setTimeout(go, 2000));
    const gl = stage.renderer.getContext();
    let least = Infinity;
    for (let i = 0; i < 30; i++) {
        await new Promise((go) => setTimeout(go, 50));
        const since = performance.now();
        gaitsimPage._show();
        stage.draw();
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        least = Math.min(least, performance.now() - since);
    }
    return [frames, ratio, least];
}"""


def main() -> None:
    """Print a line for each page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "pages", nargs="*", type=Path, help="HTML pages; default: the page of a spider"
    )
    pages = parser.parse_args().pages
    with tempfile.TemporaryDirectory() as folder:
        print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
        for page in pages or [_spider(Path(folder))]:
            frames, ratio, milliseconds = _measure(page)
            print(
                f"{page.name}: {page.stat().st_size / 1e3:.0f} kB, {frames:.0f} frames/s at "
                f"{ratio:.2f} of the resolution, {milliseconds:.1f} ms/frame"
            )


def _spider(folder: Path) -> Path:
    for _ in gs.evolve("spider", generations=20, out=folder / "run"):
        pass
    return gs.load(folder / "run").page(folder / "spider.html")


def _measure(page: Path) -> list[Any]:
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=FLAGS)
        shown = browser.new_context(offline=True, viewport={"width": 1280, "height": 800})
        opened = shown.new_page()
        opened.goto(page.resolve().as_uri())
        opened.wait_for_selector(".player")
        return list(opened.evaluate(MEASURE, SECONDS))


if __name__ == "__main__":
    main()

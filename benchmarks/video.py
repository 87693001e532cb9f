"""The time to write a video of a spider, and the peak memory for two lengths."""

import resource
import subprocess
import sys
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

from timing import medians, milliseconds, print_figure, print_machine, stopwatch, times

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim.render.scene import Clip, Scene
from gaitsim.render.settings import RenderSettings
from gaitsim.render.video import Video
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.runs.writer import RunWriter

BUDGET = 6.0  # seconds for 300 frames of 1280 × 720 on two cores
STILLS = 5


def spider(path: Path) -> RunSnapshot:
    """Evolve a short run of a spider, and return its snapshot."""
    experiment = load_experiment("spider", {"evolution.generations": 30})
    with RunWriter.open(create_run(experiment, path)) as writer:
        for generation in evolve(experiment, partial(evaluate, experiment)):
            writer.record(generation)
    return RunSnapshot(path)


def matplotlib_3d(run: RunSnapshot) -> float:
    """Return the seconds per frame of the same segments on matplotlib's 3D axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    skeleton = run.individual().skeleton
    figure = Figure((12.8, 7.2), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot(projection="3d")
    lines = axes.add_collection3d(Line3DCollection(skeleton.segments[0], linewidths=4))

    def draw() -> None:
        lines.set_segments(skeleton.segments[9])
        canvas.draw()

    return medians(draw, repeats=STILLS)[0]


def peak(run: Path, seconds: float, folder: Path) -> float:
    """Return the peak memory of a process, MB, for a slow-motion video of `seconds`."""
    code = (
        "import sys; from pathlib import Path; from gaitsim.render.video import *;"
        "from gaitsim.runs.snapshot import RunSnapshot; speed = 10 / float(sys.argv[2]);"
        "Video(RunSnapshot(Path(sys.argv[1])), (), RenderSettings(speed=speed, intro=False))"
        ".write(Path(sys.argv[3]));"
        "import resource; print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    arguments = [sys.executable, "-c", code, str(run), str(seconds), str(folder / "long.mp4")]
    done = subprocess.run(arguments, check=True, capture_output=True, text=True)
    return float(done.stdout) / (1024 if sys.platform == "linux" else 1024**2)


def main() -> None:
    """Print the figures."""
    print_machine()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = spider(folder / "run")
        settings = RenderSettings(intro=False)
        video = Video(run, (), settings)
        before = resource.getrusage(resource.RUSAGE_SELF)
        whole = stopwatch(lambda: video.write(folder / "a.mp4"))
        after = resource.getrusage(resource.RUSAGE_SELF)
        worked = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        print_figure(
            f"an MP4 of {len(video)} frames, 1280 × 720",
            f"{whole:.1f} s",
            f"budget {BUDGET:.0f} s: {times(BUDGET / whole)}; {worked:.1f} s of processor time",
        )
        size = (folder / "a.mp4").stat().st_size / 1e6
        print_figure("- its file", f"{size:.1f} MB", f"{size / 10:.2f} MB per second")
        gif = Video(run, (), replace(settings, format="gif"))
        taken = stopwatch(lambda: gif.write(folder / "a.gif"))
        size = (folder / "a.gif").stat().st_size / 1e6
        print_figure(f"a GIF of {len(gif)} frames, 640 × 360", f"{taken:.1f} s", f"{size:.1f} MB")
        scene = Scene(
            [Clip(run.individual().skeleton)], settings.pixels, settings.view, settings.theme
        )
        (ours,) = medians(lambda: scene.draw(3.0), repeats=STILLS)
        print_figure("drawing one frame", milliseconds(ours))
        theirs = matplotlib_3d(run)
        print_figure(
            "- bare segments on matplotlib's 3D axes",
            milliseconds(theirs),
            f"{times(theirs / ours)} as long",
        )
        short, long = (peak(folder / "run", seconds, folder) for seconds in (5, 30))
        print_figure("peak memory, 5 s of video", f"{short:.0f} MB")
        print_figure("- 30 s of video", f"{long:.0f} MB", f"{times(long / short)}")


if __name__ == "__main__":
    main()

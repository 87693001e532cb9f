"""The time of `gaitsim video` for each bundled body, and the peak memory for two lengths."""

import resource
import subprocess
import sys
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

from timing import (
    medians,
    milliseconds,
    print_budget,
    print_figure,
    print_machine,
    stopwatch,
    times,
)

from gaitsim.evaluation import evaluate
from gaitsim.evolution import evolve
from gaitsim.experiment import load_experiment
from gaitsim.render.film import RenderSettings
from gaitsim.render.scene import Clip, Scene
from gaitsim.render.video import Video
from gaitsim.storage.creation import create_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter

BODIES = "spider", "millipede", "fly", "walker", "quadruped", "hexapod", "spider-physics"
FRAMES = 300
BUDGET = 8.0  # seconds for 300 frames of 1280 × 720 on two cores
STILLS = 5


def evolved(preset: str, path: Path) -> RunSnapshot:
    """Evolve two generations of a preset, and return the snapshot of the run."""
    experiment = load_experiment(preset, {"evolution.generations": 2})
    with RunWriter.open(create_run(experiment, path)) as writer:
        for generation in evolve(experiment, partial(evaluate, experiment)):
            writer.record(generation)
    return RunSnapshot(path)


def command(run: RunSnapshot, out: Path) -> tuple[float, float]:
    """Return the seconds and the processor time of a command that writes `FRAMES` pictures."""
    skeleton = run.individual().skeleton
    # Half a frame less than the last one, so that rounding cannot add a picture.
    speed = (len(skeleton.segments) - 1) / skeleton.frame_rate / ((FRAMES - 0.5) / 30)
    program = [sys.executable, "-m", "gaitsim", "video", str(run.path), "--no-intro"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = stopwatch(
        lambda: subprocess.run(
            [*program, "--out", str(out), "--speed", repr(speed)], check=True, capture_output=True
        )
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return whole, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


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
        "from gaitsim.storage.snapshot import RunSnapshot; speed = 10 / float(sys.argv[2]);"
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
        for preset in BODIES:
            run = evolved(preset, folder / preset)
            command(run, folder / "a.mp4")  # compiles the kernels
            whole, worked = command(run, folder / "a.mp4")
            size = (folder / "a.mp4").stat().st_size / 1e6
            label = f"{preset}: an MP4 of {FRAMES} frames, 1280 × 720"
            print_budget(label, whole, BUDGET, lambda seconds: f"{seconds:.1f} s")
            print_figure("- processor time", f"{worked:.1f} s", f"{size:.1f} MB")
        run = RunSnapshot(folder / BODIES[0])
        settings = RenderSettings(intro=False)
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
        short, long = (peak(run.path, seconds, folder) for seconds in (5, 30))
        print_figure("peak memory, 5 s of video", f"{short:.0f} MB")
        print_figure("- 30 s of video", f"{long:.0f} MB", f"{times(long / short)}")


if __name__ == "__main__":
    main()

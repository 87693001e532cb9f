"""Runs as event files, which TensorBoard shows.

The package tensorboardX (extra `tensorboard`) has the format: its records and messages. Its
`SummaryWriter` is not used: that one names files after the clock and the machine.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import GaitsimError, RunError, not_installed
from gaitsim.gait.files.writer import check_parent
from gaitsim.individual import Individual
from gaitsim.runs.files.atomic import replacing, writing
from gaitsim.runs.files.history import FIGURE, MEAN, SCORES, terms_of
from gaitsim.runs.snapshot import RunSnapshot
from gaitsim.toml import brief

FILE = "events.out.tfevents.gaitsim"
"""Name of the event file; TensorBoard reads files whose name holds 'tfevents'."""

CHAMPION = "champion"
"""Before the name of a value of the champion, after a slash."""

SIZE, RATE, PICTURES = (320, 180), 10, 60  # of the moving picture: pixels, 1/s, at most
_SLOWEST = 0.01


def write_events(
    run: RunSnapshot, folder: Path, advance: Callable[[int], object] = lambda done: None
) -> tuple[str, ...]:
    """Write a run for TensorBoard: its history, options, champion and a moving picture of it.

    Scalars are float32, one for each generation and column of the history; terms that a stage does
    not have are left out. A generation's time is the seconds that were computed until its end. The
    same run gives the same bytes.

    Args:
        run: with one generation or more.
        folder: is created where there is none; an earlier file of gaitsim in it is replaced.
        advance: called with 1 after each generation.

    Returns:
        What is left out, and why.

    Raises:
        GaitsimError: the package tensorboardX is not installed.
        RunError: no generation is finished yet, the run is damaged, or the file cannot be written.
    """
    check_installed()
    from tensorboardX.record_writer import RecordWriter

    check_parent(folder)
    if folder.is_symlink():  # in a run from others it may lead anywhere
        raise RunError(f"cannot write into {folder}: it is a link", allowed="a folder")
    _ = run.finished
    notices: list[str] = []
    with writing(folder):
        folder.mkdir(exist_ok=True)
    with replacing(folder / FILE, follow=False) as partial:
        records = RecordWriter(str(partial.resolve()))
        try:
            for event in _events(run, notices, advance):
                records.write(event.SerializeToString(deterministic=True))
        finally:
            records.close()
    return tuple(notices)


def check_installed() -> None:
    """Refuse to write event files without the package tensorboardX.

    Raises:
        GaitsimError: it is not installed.
    """
    try:
        import tensorboardX  # noqa: F401
    except ImportError as error:
        raise not_installed(
            "an event file", error.name, "tensorboard", where="--format tensorboard"
        ) from None


def tag(column: str) -> str:
    """Return the name of a column of the history in TensorBoard, which groups by the first part."""
    if column in SCORES:
        return f"score/{column}"
    for prefix, group in ((MEAN, "mean of terms"), (FIGURE, "search")):
        if column.startswith(prefix):
            return f"{group}/{column.removeprefix(prefix)}"
    return column


def _events(
    run: RunSnapshot, notices: list[str], advance: Callable[[int], object]
) -> Iterator[Any]:
    from tensorboardX.proto.event_pb2 import Event
    from tensorboardX.summary import hparams

    yield Event(wall_time=0.0, file_version="brain.Event:2")
    history, outline = run.history, run.outline
    times = np.cumsum(history["seconds"])
    champion = None if run.best_generation is None else run.individual()
    score = {} if champion is None else {f"{CHAMPION}/score": champion.score}
    options = {
        key: value if isinstance(value, bool | int | float) else brief(value)
        for key, value in outline.options().items()
    }
    begin, start, end = hparams(options, score)
    yield Event(wall_time=0.0, summary=begin)
    yield Event(wall_time=0.0, summary=start)
    for index, summary in enumerate(_rows(history)):
        yield Event(wall_time=times[index], step=index + 1, summary=summary)
        advance(1)
    last = float(times[-1])
    if champion is None:
        notices.append("no champion: every individual failed")
    else:
        yield Event(wall_time=last, step=champion.generation, summary=_summary(score))
        if picture := _moving_picture(champion, notices):
            yield Event(wall_time=last, step=champion.generation, summary=picture)
    yield Event(wall_time=last, summary=end)


def _rows(history: Mapping[str, NDArray[np.float64]]) -> Iterator[Any]:
    """Yield the summary of each generation."""
    terms = {*terms_of(history)}
    tags = [f"terms/{name}" if name in terms else tag(name) for name in history]
    columns = [*zip(tags, history.values(), strict=True)][1:]  # the first one is the generation
    for row in zip(*(values.tolist() for _, values in columns), strict=True):
        found = zip((name for name, _ in columns), row, strict=True)
        yield _summary({name: value for name, value in found if not math.isnan(value)})


def _summary(values: Mapping[str, float]) -> Any:
    from tensorboardX.proto.summary_pb2 import Summary

    return Summary(
        value=[Summary.Value(tag=name, simple_value=value) for name, value in values.items()]
    )


def _moving_picture(champion: Individual, notices: list[str]) -> Any:
    """Return the summary of an animated GIF; None where the body cannot be drawn."""
    from tensorboardX.proto.summary_pb2 import Summary

    from gaitsim.render.encoder import encode
    from gaitsim.render.plots.labels import score_words
    from gaitsim.render.scene import THEMES, Clip, Scene
    from gaitsim.render.tempo import rhythm, speed_words, usual_speed

    try:
        skeleton = champion.skeleton
        speed = usual_speed(rhythm(skeleton), RATE, _SLOWEST)
        details = score_words(champion) + (f"   {speed_words(speed)}" if speed != 1 else "")
        scene = Scene([Clip(skeleton, champion.label, details)], SIZE, "iso", "light")
        count = min(int(scene.seconds / speed * RATE) + 1, PICTURES)
        pictures = [scene.draw(number * speed / RATE) for number in range(count)]
    except GaitsimError as error:
        notices.append(f"no moving picture: {error.what}")
        return None
    with TemporaryDirectory() as folder:
        path = Path(folder, "champion.gif")
        encode(
            pictures,
            path,
            format="gif",
            size=SIZE,
            fps=Fraction(RATE),
            samples=pictures[:: max(count // 4, 1)],
            exact=THEMES["light"].exact,
        )
        data = path.read_bytes()
    width, height = SIZE
    image = Summary.Image(width=width, height=height, colorspace=3, encoded_image_string=data)
    return Summary(value=[Summary.Value(tag=f"{CHAMPION}/motion", image=image)])

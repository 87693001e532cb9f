"""Runs as event files for TensorBoard.

The package tensorboardX (extra `tensorboard`) provides the records and messages of the format.
Its `SummaryWriter` is not used, as it names files after the clock and the machine.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin import GaitsimError, RunError, brief, not_installed
from gaitsim.plugin.gait import check_parent
from gaitsim.plugin.runs import (
    FIGURE,
    MEAN,
    SCORES,
    Individual,
    RunSnapshot,
    replacing,
    terms_of,
    writing,
)

FILE = "events.out.tfevents.gaitsim"
"""Name of the event file; TensorBoard reads files whose name contains 'tfevents'."""

CHAMPION = "champion"
"""Prefix of the tags of the champion's values."""

SIZE, RATE, PICTURES = (320, 180), 10, 60  # animation: pixels, frames per second, maximum frames
_SLOWEST = 0.01


def write_events(
    run: RunSnapshot, folder: Path, advance: Callable[[int], object] = lambda done: None
) -> tuple[str, ...]:
    """Write a run for TensorBoard: its history, options, champion and the champion's animation.

    Scalars are float32, one for each generation and column of the history, except terms that a
    stage lacks. The time of a generation is the computing time until its end, in seconds. The same
    run gives the same bytes.

    Args:
        run: run with at least one generation.
        folder: folder, created if missing; an existing event file of gaitsim in it is replaced.
        advance: function called with 1 after each generation.

    Returns:
        Notices on omitted parts, with reasons.
    """
    check_installed()
    from tensorboardX.record_writer import RecordWriter

    check_parent(folder)
    if folder.is_symlink():  # in a run from someone else, the target may be anywhere
        raise RunError(f"cannot write to {folder}: it is a symbolic link", allowed="a folder")
    _ = run.finished  # raises a RunError if no generation is finished
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
    """Check that the package tensorboardX is installed."""
    try:
        import tensorboardX  # noqa: F401
    except ImportError as error:
        raise not_installed(
            "an event file", error.name, "tensorboard", where="--format tensorboard"
        ) from None


def tag(column: str) -> str:
    """Return TensorBoard's tag of a column of the history; the part before '/' is its group."""
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
        if picture := _animation(champion, notices):
            yield Event(wall_time=last, step=champion.generation, summary=picture)
    yield Event(wall_time=last, summary=end)


def _rows(history: Mapping[str, NDArray[np.float64]]) -> Iterator[Any]:
    """Yield the summary of each generation."""
    terms = {*terms_of(history)}
    tags = [f"terms/{name}" if name in terms else tag(name) for name in history]
    columns = [*zip(tags, history.values(), strict=True)][1:]  # without the generation
    for row in zip(*(values.tolist() for _, values in columns), strict=True):
        found = zip((name for name, _ in columns), row, strict=True)
        yield _summary({name: value for name, value in found if not math.isnan(value)})


def _summary(values: Mapping[str, float]) -> Any:
    from tensorboardX.proto.summary_pb2 import Summary

    return Summary(
        value=[Summary.Value(tag=name, simple_value=value) for name, value in values.items()]
    )


def _animation(champion: Individual, notices: list[str]) -> Any:
    """Return the summary of an animated GIF; None if the body cannot be drawn."""
    from tensorboardX.proto.summary_pb2 import Summary

    from gaitsim.plugin.pictures import (
        THEMES,
        Clip,
        Scene,
        default_speed,
        encode,
        format_score,
        format_speed,
        movement_frequency,
    )

    try:
        skeleton = champion.skeleton
        speed = default_speed(movement_frequency(skeleton), RATE, _SLOWEST)
        details = format_score(champion) + (f"   {format_speed(speed)}" if speed != 1 else "")
        scene = Scene([Clip(skeleton, champion.label, details)], SIZE, "iso", "light")
        count = min(int(scene.seconds / speed * RATE) + 1, PICTURES)
        pictures = [scene.draw(number * speed / RATE) for number in range(count)]
    except GaitsimError as error:
        notices.append(f"no animation: {error.what}")
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

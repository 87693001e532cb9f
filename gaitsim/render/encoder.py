"""Encode frames as a video, after choosing their tempo."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Skeleton
from gaitsim.storage.files.atomic import replacing

if TYPE_CHECKING:
    from av import VideoFrame


ALIASED = 2.0  # frames per cycle; with fewer, movement appears to run backwards
TOO_FEW = 6.0  # frames per cycle; with fewer, movement is jerky
ENOUGH = 8.0  # frames per cycle in slow motion
_FRACTIONS = {0.5: "½", 0.25: "¼", 0.125: "⅛"}


def movement_frequency(skeleton: Skeleton) -> float:
    """Return the frequency of a body's movement about its path, Hz; 0 if it does not move.

    It is the median of the power spectrum of the velocities of all points, such as the frequency
    of the wing beat or the stride.
    """
    segments = np.asarray(skeleton.segments, dtype=np.float64)
    about = segments - np.asarray(skeleton.path, dtype=np.float64)[:, None, None]
    about = about.reshape(len(about), -1)
    # The window removes the jump between the end and the start.
    window = np.hanning(len(about))[:, None]
    frequencies = np.fft.rfftfreq(len(about), 1 / skeleton.frame_rate)
    places = np.fft.rfft((about - about.mean(axis=0)) * window, axis=0)
    power = np.cumsum((np.abs(places) ** 2).sum(axis=1) * frequencies**2)
    if not power[-1] > (1e-9 * np.abs(about).max(initial=0.0)) ** 2:
        return 0.0
    return float(frequencies[np.searchsorted(power, power[-1] / 2)])


def fastest_movement(skeletons: Iterable[Skeleton], rate: float) -> float:
    """Return the highest frequency of movement of bodies, Hz.

    Bodies recorded with at most `rate` frames per second, which no video of that rate can alias,
    are ignored.
    """
    fast = [skeleton for skeleton in skeletons if skeleton.frame_rate > rate]
    return max(map(movement_frequency, fast), default=0.0)


def is_resolved(frequency: float, rate: float, speed: float, frames: float = TOO_FEW) -> bool:
    """Return whether each cycle of a movement has at least `frames` frames.

    Args:
        frequency: frequency of the movement, Hz.
        rate: frames per second of the video.
        speed: speed of the motion; 1 is real time.
        frames: minimum number of frames per cycle.
    """
    return frequency * speed * frames <= rate


def default_speed(frequency: float, rate: float, slowest: float) -> float:
    """Return 1, or the slow motion (½, ¼, ⅛ …) that a fast movement needs.

    Args:
        frequency: frequency of the movement, Hz.
        rate: frames per second of the video.
        slowest: lower limit of the speed.
    """
    if is_resolved(frequency, rate, 1.0):
        return 1.0
    halvings = math.ceil(math.log2(frequency * ENOUGH / rate))
    return float(2.0 ** -min(halvings, math.floor(-math.log2(slowest))))


def format_speed(speed: float) -> str:
    """Format a speed, such as '¼ speed' or '4 × speed'."""
    whole = round(1 / speed) if speed < 1 else 0
    if speed in _FRACTIONS:
        return f"{_FRACTIONS[speed]} speed"
    if whole and math.isclose(speed * whole, 1):
        return f"1/{whole} speed"
    return f"{speed:g} × speed"


Picture = NDArray[np.uint8]

COLOURS = 256  # colours of a GIF; one palette for the whole video avoids flicker
CELLS = 64  # cells along each axis of the colour space; a cell's colours are replaced by one
# Constant quality. For lines on a plain background, 'ultrafast' with these tools takes half of the
# time of 'veryfast' at crf 22, for a file two fifths larger at the same error. Without aq-mode,
# the faintest lines of the grid would break into dashes.
_H264 = {
    "crf": "24",
    "preset": "ultrafast",
    "x264-params": "cabac=1:deblock=0,0:8x8dct=1:bframes=3:aq-mode=1",
}
_AHEAD = 2  # pictures that may wait for the encoder
_BT709 = 1  # the default of players for high definition
_STUDIO_RANGE = 1


def encode(
    pictures: Iterable[Picture],
    path: Path,
    *,
    format: str,
    size: tuple[int, int],
    fps: Fraction,
    samples: Sequence[Picture] = (),
    exact: NDArray[np.uint8] | None = None,
) -> None:
    """Write a video atomically, with few pictures at a time in memory.

    Args:
        pictures: pictures, (height, width, 4) each.
        path: path of the file.
        format: 'mp4', which browsers play while loading it, or 'gif', which repeats forever.
        size: width and height, pixels; even numbers for an MP4.
        fps: frames per second; a GIF shows each frame for a whole number of centiseconds.
        samples: some of the pictures, from which the colours of a GIF are chosen.
        exact: colours that a GIF preserves exactly, (colours, 3).
    """
    import av

    settings = {"mp4": {"movflags": "+faststart"}, "gif": {"loop": "0"}}[format]
    with (
        replacing(path) as partial,
        av.open(str(partial), "w", format=format, options=settings) as container,
    ):
        if format == "mp4":
            stream = container.add_stream("libx264", rate=fps, options=_H264)
            stream.pix_fmt = "yuv420p"
            stream.codec_context.thread_type = "FRAME"
            stream.codec_context.color_range = _STUDIO_RANGE
            stream.codec_context.colorspace = _BT709
            stream.codec_context.color_primaries = _BT709
            stream.codec_context.color_trc = _BT709
            convert = _to_yuv()
        else:
            stream = container.add_stream("gif", rate=fps)
            stream.pix_fmt = "pal8"
            convert = _to_palette(samples, np.empty((0, 3), np.uint8) if exact is None else exact)
        stream.width, stream.height = size

        def write(number: int, picture: Picture) -> None:
            frame = convert(picture)
            frame.pts, frame.time_base = number, 1 / fps
            container.mux(stream.encode(frame))

        # Encode pictures while the next ones are drawn.
        waiting: deque[Future[None]] = deque()
        with ThreadPoolExecutor(1) as thread:
            for number, picture in enumerate(pictures):
                waiting.append(thread.submit(write, number, picture))
                if len(waiting) > _AHEAD:
                    waiting.popleft().result()
            for last in waiting:
                last.result()
        container.mux(stream.encode(None))


def _to_yuv() -> "Callable[[Picture], VideoFrame]":
    """Return a function that converts pictures to the colours of H.264."""
    from av import VideoFrame
    from av.video.reformatter import ColorRange, Colorspace, VideoReformatter

    converter = VideoReformatter()  # shared by all pictures: creating it takes 1 ms
    return lambda picture: converter.reformat(
        VideoFrame.from_numpy_buffer(picture, format="rgba"),
        format="yuv420p",
        dst_colorspace=Colorspace.ITU709,
        dst_color_range=ColorRange.MPEG,
    )


def _to_palette(
    samples: Sequence[Picture], exact: NDArray[np.uint8]
) -> "Callable[[Picture], VideoFrame]":
    """Return a function that reduces pictures to the exact colours and some near the samples'."""
    from av import VideoFrame

    colours, indices = palette(samples, exact)
    table = np.full((COLOURS, 4), 255, dtype=np.uint8)
    table[: len(colours), 1:] = colours  # opacity comes first

    def convert(picture: Picture) -> "VideoFrame":
        # The type stubs allow only one array, but with a palette PyAV requires two.
        both: Any = (indices[cells(picture)], table)
        return VideoFrame.from_ndarray(both, format="pal8")

    return convert


def palette(
    samples: Sequence[Picture], exact: NDArray[np.uint8]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Choose the colours of a GIF.

    Args:
        samples: pictures with all colours of the video.
        exact: colours to preserve exactly, (colours, 3).

    Returns:
        The colours, (at most `COLOURS`, 3), and the index of the nearest colour for each cell of
        the colour space, (`CELLS`³,).
    """
    from PIL import Image
    from scipy.spatial import KDTree

    exact = np.unique(exact, axis=0)
    packed = np.concatenate([_packed(sample).ravel() for sample in samples])
    distinct, count = np.unique(packed, return_counts=True)
    # Weighting by the square root of counts favours the few pixels of the feet's marks.
    weighted = np.repeat(distinct, np.ceil(np.sqrt(count)).astype(np.intp))
    weighted = (weighted[:, None] >> np.array([16, 8, 0])).astype(np.uint8)
    room = COLOURS - len(exact)
    octree = Image.fromarray(weighted[None]).quantize(room, method=Image.Quantize.FASTOCTREE)
    rest = np.array(octree.getpalette(), dtype=np.uint8).reshape(-1, 3)[:room]
    colours = np.concatenate([exact, rest])
    middles = (np.indices((CELLS,) * 3).reshape(3, -1).T + 0.5) * (256 // CELLS) - 0.5
    indices = np.asarray(KDTree(colours.astype(np.float64)).query(middles)[1], dtype=np.uint8)
    indices[cells(exact)] = np.arange(len(exact))
    return colours, indices


def _packed(colours: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Return colours of shape (…, 3 or 4) as integers, whose distinct values are found fast."""
    red, green, blue = np.moveaxis(colours[..., :3].astype(np.uint32), -1, 0)
    return np.asarray(red << 16 | green << 8 | blue)


def cells(colours: NDArray[np.uint8]) -> NDArray[np.intp]:
    """Return the cell of the colour space of each colour, for colours of shape (…, 3 or 4)."""
    red, green, blue = np.moveaxis(colours[..., :3] // (256 // CELLS), -1, 0).astype(np.intp)
    return np.asarray((red * CELLS + green) * CELLS + blue)

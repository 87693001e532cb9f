"""Encoding of pictures as video files: MP4 (H.264) or GIF."""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.runs.files.atomic import replacing

if TYPE_CHECKING:
    from av import VideoFrame

Picture = NDArray[np.uint8]

COLOURS = 256  # colours of a GIF; one palette for the whole video avoids flicker
CELLS = 64  # cells along each axis of the colour space; a cell's colours are replaced by one
# Constant quality. 'veryfast' takes half the time of 'medium' for lines on a plain background.
# mbtree would make files an eighth smaller, but not reproducible: one file in twenty differs.
# Fixed B-frames and few partitions save a quarter of the time and cost 1 dB.
_H264 = {
    "crf": "22",
    "preset": "veryfast",
    "x264-params": "mbtree=0:b-adapt=0:partitions=i8x8,i4x4",
}
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
    """Write a video atomically, with one picture at a time in memory.

    Args:
        pictures: pictures, (height, width, 4) each.
        path: path of the file.
        format: 'mp4', which browsers play while loading it, or 'gif', which repeats forever.
        size: width and height, pixels; even numbers for an MP4.
        fps: frames per second; a GIF shows each frame for a whole number of centiseconds.
        samples: some of the pictures, from which the colours of a GIF are chosen.
        exact: colours that a GIF preserves exactly, (colours, 3).

    Raises:
        RunError: the file cannot be written; an existing file remains unchanged.
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
            # Encode one picture while the next one is drawn.
            stream.codec_context.thread_type = "FRAME"
            stream.codec_context.color_range = _STUDIO_RANGE
            stream.codec_context.colorspace = _BT709
            stream.codec_context.color_primaries = _BT709
            stream.codec_context.color_trc = _BT709
            frames = _yuv_frames(pictures)
        else:
            stream = container.add_stream("gif", rate=fps)
            stream.pix_fmt = "pal8"
            frames = _palette_frames(
                pictures, samples, np.empty((0, 3), np.uint8) if exact is None else exact
            )
        stream.width, stream.height = size
        for number, frame in enumerate(frames):
            frame.pts, frame.time_base = number, 1 / fps
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def _yuv_frames(pictures: Iterable[Picture]) -> "Iterator[VideoFrame]":
    from av import VideoFrame
    from av.video.reformatter import ColorRange, Colorspace, VideoReformatter

    converter = VideoReformatter()  # shared by all pictures: creating it takes 1 ms
    for picture in pictures:
        yield converter.reformat(
            VideoFrame.from_numpy_buffer(picture, format="rgba"),
            format="yuv420p",
            dst_colorspace=Colorspace.ITU709,
            dst_color_range=ColorRange.MPEG,
        )


def _palette_frames(
    pictures: Iterable[Picture], samples: Sequence[Picture], exact: NDArray[np.uint8]
) -> "Iterator[VideoFrame]":
    """Reduce pictures to a palette of the exact colours and colours close to the samples'."""
    from av import VideoFrame

    colours, indices = palette(samples, exact)
    table = np.full((COLOURS, 4), 255, dtype=np.uint8)
    table[: len(colours), 1:] = colours  # opacity comes first
    for picture in pictures:
        # The type stubs allow only one array, but with a palette PyAV requires two.
        both: Any = (indices[cells(picture)], table)
        yield VideoFrame.from_ndarray(both, format="pal8")


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

"""Encode pictures as a video file: MP4 (H.264) or GIF."""

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

COLOURS = 128  # of a GIF: its palette is the whole video's, so that nothing flickers
# Constant quality; 'veryfast' halves the time of 'medium' for lines on a plain ground. With
# x264's mbtree a file is an eighth smaller, but one in twenty differs from the others. Without
# its choice of B-frames and partitions between pictures it takes a quarter less, for 1 dB.
_H264 = {
    "crf": "22",
    "preset": "veryfast",
    "x264-params": "mbtree=0:b-adapt=0:partitions=i8x8,i4x4",
}
_BT709 = 1  # what players take for granted in high definition
_STUDIO_RANGE = 1


def encode(
    pictures: Iterable[Picture],
    path: Path,
    *,
    format: str,
    size: tuple[int, int],
    fps: Fraction,
    samples: Sequence[Picture] = (),
) -> None:
    """Write a video atomically; hold one picture at a time in memory.

    Args:
        pictures: (height, width, 4) each.
        path: the file.
        format: 'mp4', which plays in browsers while it is still loading, or 'gif', which
            repeats for ever.
        size: width and height; even for an MP4.
        fps: pictures a second; a GIF shows each for a whole number of centiseconds.
        samples: some of the pictures, from which the colours of a GIF are chosen.

    Raises:
        RunError: the file cannot be written; a file of that name stays as it was.
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
            # Encode while the next picture is drawn.
            stream.codec_context.thread_type = "FRAME"
            stream.codec_context.color_range = _STUDIO_RANGE
            stream.codec_context.colorspace = _BT709
            stream.codec_context.color_primaries = _BT709
            stream.codec_context.color_trc = _BT709
            frames = _yuv(pictures)
        else:
            stream = container.add_stream("gif", rate=fps)
            stream.pix_fmt = "pal8"
            frames = _indexed(pictures, samples)
        stream.width, stream.height = size
        for number, frame in enumerate(frames):
            frame.pts, frame.time_base = number, 1 / fps
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def _yuv(pictures: Iterable[Picture]) -> "Iterator[VideoFrame]":
    from av import VideoFrame
    from av.video.reformatter import ColorRange, Colorspace, VideoReformatter

    converter = VideoReformatter()  # one for all: setting it up takes a millisecond
    for picture in pictures:
        yield converter.reformat(
            VideoFrame.from_numpy_buffer(picture, format="rgba"),
            format="yuv420p",
            dst_colorspace=Colorspace.ITU709,
            dst_color_range=ColorRange.MPEG,
        )


def _indexed(pictures: Iterable[Picture], samples: Sequence[Picture]) -> "Iterator[VideoFrame]":
    """Reduce pictures to the most frequent colours of the samples."""
    from av import VideoFrame
    from PIL import Image

    def image(picture: Picture) -> Any:
        return Image.fromarray(np.ascontiguousarray(picture[..., :3]))

    chosen = image(np.concatenate(samples)).quantize(COLOURS)
    colours = np.array(chosen.getpalette(), dtype=np.uint8).reshape(-1, 3)
    palette = np.full((256, 4), 255, dtype=np.uint8)
    palette[: len(colours), 1:] = colours  # opacity comes first
    for picture in pictures:
        indices = image(picture).quantize(palette=chosen, dither=Image.Dither.NONE)
        # The stubs know one array alone; with a palette it takes two.
        both: Any = (np.asarray(indices), palette)
        yield VideoFrame.from_ndarray(both, format="pal8")

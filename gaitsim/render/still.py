"""A still of a body, with its feet named."""

from dataclasses import replace
from io import BytesIO
from pathlib import Path

from gaitsim.contracts import Skeleton
from gaitsim.gait.files.writer import check_folder
from gaitsim.render.scene import Clip, Scene
from gaitsim.runs.files.atomic import write_bytes

SIZE = 1280, 720


def write_still(
    skeleton: Skeleton,
    path: Path,
    title: str = "",
    details: str = "",
    *,
    frame: int = 0,
    size: tuple[int, int] = SIZE,
    view: str = "iso",
    theme: str = "light",
) -> None:
    """Write one frame of a body as a PNG, with the names of its feet.

    Args:
        skeleton: its motion.
        path: the file.
        title: the first line in it.
        details: the second one.
        frame: which one.
        size: width and height, pixels.
        view: one of `gaitsim.render.scene.VIEWS`.
        theme: one of `gaitsim.render.scene.THEMES`.

    Raises:
        RunError: the file cannot be written.
    """
    from PIL import Image

    check_folder(path)
    clip = Clip(_frozen(skeleton, frame), title, details, named=True)
    picture = Scene([clip], size, view, theme).draw(0.0)
    data = BytesIO()
    Image.fromarray(picture[..., :3]).save(data, format="PNG")
    write_bytes(path, data.getvalue())


def _frozen(skeleton: Skeleton, frame: int) -> Skeleton:
    over_time = ("segments", "contacts", "touching", "centre", "poses")
    kept = {name: getattr(skeleton, name) for name in over_time}
    return replace(
        skeleton,
        **{name: array[frame : frame + 1] for name, array in kept.items() if array is not None},
    )

"""Stills of a body, with the names of its feet."""

from dataclasses import replace
from io import BytesIO
from pathlib import Path

from gaitsim.contracts import Skeleton
from gaitsim.gait.gait_files import check_folder
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
        skeleton: motion of the body.
        path: path of the file.
        title: first line of text.
        details: second line of text.
        frame: index of the frame.
        size: width and height, pixels.
        view: name of a view in `gaitsim.render.scene.VIEWS`.
        theme: name of a theme in `gaitsim.render.scene.THEMES`.
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

"""Find and read the files to which a robot's file refers, within the folders that it may use."""

from collections.abc import Iterator, Sequence
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote

from gaitsim.opening import read_regular
from gaitsim_robot.errors import RobotError

MODEL_BYTES = 16 * 2**20
MESH_BYTES = 64 * 2**20
ALL_BYTES = 512 * 2**20

# Folders for robots within a package; the meshes are in folders next to them.
_INNER = frozenset({"urdf", "robots", "mjcf", "xml"})


class RobotFiles:
    """The files that a robot's file may use.

    After resolving links, a file must be in the base or in one of the roots. The base is the
    nearest folder above the robot's file that contains a `package.xml`. Otherwise it is the robot's
    own folder, or the parent of a folder called `urdf`, `robots`, `mjcf` or `xml`. A name
    `package://NAME/…` also allows the nearest parent folder called NAME.
    """

    def __init__(self, model: Path, roots: Sequence[Path]) -> None:
        self.folder = model.parent.resolve()
        self._above = (self.folder, *self.folder.parents)
        inner = self.folder.name.lower() in _INNER
        base = self.folder.parent if inner else self.folder
        package = next((one for one in self._above if (one / "package.xml").is_file()), base)
        self._roots = [root.resolve() for root in roots]
        self._allowed = [base, package, *self._roots]
        self._left = ALL_BYTES

    def find(self, name: str, folders: Sequence[str] = ("",)) -> Path | None:
        """Return the path of a file to which the robot refers, or None if there is no such file.

        Args:
            name: a path, or a URI `package://`, `model://` or `file://`.
            folders: bases of relative paths, relative to the robot's file.
        """
        if "\0" in name or len(name) > 4096:
            return None
        outside = None
        for candidate in self._candidates(name, folders):
            try:
                path = candidate.resolve()
                if not path.is_file():
                    continue
            except (OSError, RuntimeError, ValueError):  # too long a name, or a loop of links
                continue
            if any(path.is_relative_to(root) for root in self._allowed):
                return path
            outside = outside or path
        if outside is None:
            return None
        raise RobotError(
            f"the robot refers to a file outside its folder: {name!r}",
            where=str(outside),
            allowed=f"files within {', '.join(map(str, dict.fromkeys(self._allowed)))}",
            remedy="copy the file there, or allow its folder and save the robot as one file: "
            f"gaitsim robots check FILE --root {outside.parent} --model-out robot.xml",
        )

    def read(self, path: Path, largest: int = MESH_BYTES) -> bytes:
        """Return the content of a file."""
        data = read(path, min(largest, self._left))
        self._left -= len(data)
        return data

    def _candidates(self, name: str, folders: Sequence[str]) -> Iterator[Path]:
        scheme, separator, rest = name.partition("://")
        if not separator:
            scheme, rest = "", name
        rest = unquote(rest) if scheme else rest
        if "\\" in rest or rest[1:2] == ":":
            rest = PureWindowsPath(rest).as_posix()
        if scheme in ("package", "model"):
            package, _, rest = rest.lstrip("/").partition("/")
            for root in self._roots:
                yield root / package / rest
                if root.name == package:
                    yield root / rest
            for above in self._above:
                if above.name == package:
                    self._allowed.append(above)
                    yield above / rest
                    break
            yield from (one / rest for one in self._allowed[:2])
        elif scheme not in ("", "file"):
            return
        for folder in folders:
            yield self.folder / folder / rest


def read(path: Path, largest: int = MODEL_BYTES) -> bytes:
    """Return the content of a regular file."""
    try:
        return read_regular(path, largest, follow=True)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise RobotError(
            f"the file cannot be read: {reason}",
            where=str(path),
            allowed=f"a regular file of at most {largest // 2**20} MiB",
        ) from None

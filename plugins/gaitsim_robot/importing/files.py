"""Find and read the files to which a robot's file refers, within the folders that it may use."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote

from gaitsim.opening import read_regular
from gaitsim_robot.errors import RobotError
from gaitsim_robot.markup import parse

MODEL_BYTES = 16 * 2**20
MESH_BYTES = 64 * 2**20
ALL_BYTES = 512 * 2**20

# Folders for robots within a package; the meshes are in folders next to them.
_INNER = frozenset({"urdf", "robots", "mjcf", "xml"})


class RobotFiles:
    """The files that a robot's file may use.

    After resolving links, a file must be in the base or in one of the roots. The base is the
    nearest folder above the robot's file that is a package: it contains a `package.xml` with a
    name. Otherwise it is the robot's own folder, or the parent of a folder called `urdf`, `robots`,
    `mjcf` or `xml`. The user's home and the root of the file system are never the base in place of
    a folder within them. A name `package://NAME/…` may also refer to a file in a package NAME
    farther above, which allows no other file there.
    """

    def __init__(self, model: Path, roots: Sequence[Path]) -> None:
        self.folder = model.parent.resolve()
        self._above = (self.folder, *self.folder.parents)
        # A stray package.xml or folder `urdf` must not allow all files of the user or the computer.
        wide = {Path(self.folder.anchor), Path(os.path.expanduser("~")).resolve()}  # noqa: PTH111
        above = [one for one in self._above if one not in wide]
        self._packages = {one: name for one in above if (name := _package_name(one))}
        inner = self.folder.name.lower() in _INNER and self.folder.parent in above
        self._base = next(iter(self._packages), self.folder.parent if inner else self.folder)
        self._roots = {root.resolve(): _package_name(root) for root in roots}
        self._left = ALL_BYTES
        self._unknown: set[str] = set()

    def find(self, name: str, folders: Sequence[str] = ("",)) -> Path | None:
        """Return the path of a file to which the robot refers, or None if there is no such file.

        Args:
            name: a path, or a URI `package://`, `model://` or `file://`.
            folders: bases of relative paths, relative to the robot's file.
        """
        if "\0" in name or len(name) > 4096:
            return None
        package, outside = _package_of(name), None
        for folder, rest in self._candidates(name, folders):
            try:
                path = (folder / rest).resolve()
                if not path.is_file():
                    continue
            except (OSError, RuntimeError, ValueError):  # too long a name, or a loop of links
                continue
            allowed = [self._base, *self._roots]
            if package and self._packages.get(folder) == package:
                allowed.append(folder)
            if any(path.is_relative_to(one) for one in allowed):
                return path
            outside = outside or (path, folder)
        if outside is None:
            return None
        path, folder = outside
        root, why = path.parent, ""
        if package and folder in self._above and self._packages.get(folder) != package:
            root = folder
            why = f"; {folder} is not that package, as it has no package.xml with its name"
        raise RobotError(
            f"the robot refers to a file outside its folder: {name!r}{why}",
            where=str(path),
            allowed=f"files within {', '.join(map(str, {self._base: '', **self._roots}))}",
            remedy="copy the file there, or allow its folder and save the robot as one file: "
            f"gaitsim robots check FILE --root {root} --model-out robot.xml",
        )

    def explain_missing(self) -> list[str]:
        """Return a hint if files are missing because their packages are not known."""
        if not self._unknown:
            return []
        names = ", ".join(map(repr, sorted(self._unknown)[:4]))
        return [
            f"packages not found: {names}; no folder above the robot's file contains a package.xml "
            "with the name; name the folder with --root"
        ]

    def read(self, path: Path, largest: int = MESH_BYTES) -> bytes:
        """Return the content of a file."""
        data = read(path, min(largest, self._left), follow=False)  # `find` resolved the links
        self._left -= len(data)
        return data

    def _candidates(self, name: str, folders: Sequence[str]) -> Iterator[tuple[Path, str]]:
        """Yield pairs of a folder and a path relative to it."""
        scheme, separator, rest = name.partition("://")
        if not separator:
            scheme, rest = "", name
        rest = unquote(rest) if scheme else rest
        if "\\" in rest or rest[1:2] == ":":
            rest = PureWindowsPath(rest).as_posix()
        if scheme in ("package", "model"):
            package, _, rest = rest.lstrip("/").partition("/")
            if not package.strip("."):
                return
            for root, root_name in self._roots.items():
                yield root / package, rest
                if package in (root.name, root_name):
                    yield root, rest
            for above in self._above:
                if package in (above.name, self._packages.get(above)):
                    yield above, rest
            yield self._base, rest
            found = {self._base.name, *self._packages.values(), *self._roots.values()}
            if package not in found | {root.name for root in self._roots}:
                self._unknown.add(package[:60])
        elif scheme not in ("", "file"):
            return
        for folder in folders:
            yield self.folder / folder, rest


def _package_of(name: str) -> str:
    """Return the package of a URI `package://` or `model://`, or ''."""
    scheme, _, rest = name.partition("://")
    return unquote(rest).lstrip("/").partition("/")[0] if scheme in ("package", "model") else ""


def _package_name(folder: Path) -> str:
    """Return the name in the `package.xml` of a folder, or '' if it is not a ROS package."""
    try:
        root = parse(read(folder / "package.xml", 2**20), "package.xml")
    except RobotError:
        return ""
    return (root.findtext("name") or "").strip() if root.tag == "package" else ""


def read(path: Path, largest: int = MODEL_BYTES, *, follow: bool = True) -> bytes:
    """Return the content of a regular file.

    Args:
        path: path of the file.
        largest: largest size, bytes.
        follow: whether the path may be a link.
    """
    try:
        return read_regular(path, largest, follow=follow)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise RobotError(
            f"the file cannot be read: {reason}",
            where=str(path),
            allowed=f"a regular file of at most {largest // 2**20} MiB",
        ) from None

"""Find and read the files to which a robot's file refers, within the folders that it may use."""

import os
import re
from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cached_property
from itertools import islice
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import TypeVar
from urllib.parse import unquote

from gaitsim.plugin import read_regular
from gaitsim_robot.errors import RobotError, format_names, shorten
from gaitsim_robot.markup import mistaken_file, parse

T = TypeVar("T")

MODEL_BYTES = 16 * 2**20
MESH_BYTES = 64 * 2**20
ALL_BYTES = 512 * 2**20
ENTRIES = 20_000  # of all folders searched for meshes, which takes at most 1 s
CROWD = 4000  # entries of one folder, above which it is not searched
DEPTH = 8  # nested folders that are searched, and last parts of a path that are compared

# Folders for robots within a package; the meshes are in folders next to them.
_INNER = frozenset({"urdf", "robots", "mjcf", "xml"})


class MeshError(ValueError):
    """A mesh cannot be decoded, for the reason in the message."""


class RobotFiles:
    """The files that a robot's file may use.

    After resolving links, a file must be in the base or in one of the roots. The base is the
    nearest folder above the robot's file that is a package: it contains a `package.xml` with a
    name. Otherwise it is the robot's own folder, or the parent of a folder called `urdf`, `robots`,
    `mjcf` or `xml`. The user's home and the folders that contain it are never the base in place of
    a folder within them. A name `package://NAME/…` may also refer to a file in a package NAME
    farther above, which allows no other file there.

    A mesh that is not where its name says is the file in the base or the roots whose path has the
    longest end in common with the name, whatever the case of letters. It is not used if several
    files fit equally well, or if the common end also fits another mesh of the robot.

    Attributes:
        names: names of all meshes in the robot's file.
        missing: reasons why meshes cannot be used, by the names of their files.
    """

    def __init__(self, model: Path, roots: Sequence[Path]) -> None:
        self.folder = model.parent.resolve()
        self._above = (self.folder, *self.folder.parents)
        # A stray package.xml or folder `urdf` must not allow all files of the user or the computer.
        home = Path(os.path.expanduser("~")).resolve()  # noqa: PTH111
        wide = {home, *home.parents, Path(self.folder.anchor)}
        above = [one for one in self._above if one not in wide]
        self._packages = {one: name for one in above if (name := _package_name(one))}
        inner = self.folder.name.lower() in _INNER and self.folder.parent in above
        self._base = next(iter(self._packages), self.folder.parent if inner else self.folder)
        self._roots = {root.resolve(): _package_name(root) for root in roots}
        self._left = ALL_BYTES
        self._unknown: set[str] = set()
        self._found: dict[str, Path] = {}
        self._hints: set[str] = set()
        self.names: Collection[str] = ()
        self.missing: dict[str, str] = {}

    def find(self, name: str, folders: Sequence[str] = ("",)) -> Path | None:
        """Return the path of a file to which the robot refers, or None if there is no such file.

        Args:
            name: a path, or a URI `package://`, `model://` or `file://`.
            folders: bases of relative paths, relative to the robot's file.
        """
        parts = _split(name) if len(name) <= 4096 else None
        if parts is None:
            return None
        (package, rest), outside = parts, None
        relative = [self.folder / _posix(folder) for folder in folders]
        for folder in self._of_package(package) if package else relative:
            try:
                path = (folder / rest).resolve()
                if not path.is_file():
                    continue
            except (OSError, RuntimeError, ValueError):  # an invalid name, or a loop of links
                continue
            if self._allows(path) or (
                self._packages.get(folder) == package and path.is_relative_to(folder)
            ):
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

    def load_mesh(
        self, name: str, folders: Sequence[str], decode: Callable[[bytes, str], T]
    ) -> T | None:
        """Return a decoded mesh, or None after recording in `missing` why it cannot be used.

        Args:
            name: name of the file, and `folders` for it, as in `find`.
            folders: bases of relative paths, relative to the robot's file.
            decode: function of the file's content and suffix in lower case.
        """
        try:
            path = self.find(name, folders) or self._find_by_end(name)
            data = self.read(path)
            if other := mistaken_file(data):
                raise MeshError(f"it is {other[0]}: {other[1]}")
            return decode(data, path.suffix.lower())
        except MeshError as error:
            self.missing[PurePosixPath(_posix(name)).name[:60]] = str(error)
            return None

    def describe_missing(self) -> list[str]:
        """Return repairs: meshes found elsewhere, missing meshes, and unknown packages."""
        lines = []
        if self._found:
            name, path = next(iter(self._found.items()))
            lines.append(
                f"meshes found by the end of their paths: {len(self._found)}, such as "
                f"{name[-80:]!r} at {self._short(path)}"
            )
        reasons = defaultdict(list)
        for name, reason in sorted(self.missing.items()):
            reasons[reason].append(name)
        if reasons:
            groups = [f"{shorten(names, 8)} ({reason})" for reason, names in reasons.items()]
            lines.append("; ".join([f"meshes not used: {shorten(groups)}", *sorted(self._hints)]))
        if self._unknown:
            lines.append(
                f"packages not found: {format_names(sorted(self._unknown))}; no folder above the "
                "robot's file contains a package.xml with the name; name the folder with --root"
            )
        return lines

    def read(self, path: Path, largest: int = MESH_BYTES) -> bytes:
        """Return the content of a file."""
        data = read(path, min(largest, self._left), follow=False)  # `find` resolved the links
        self._left -= len(data)
        return data

    def _of_package(self, package: str) -> Iterator[Path]:
        """Yield the folders that could be a package."""
        for root, name in self._roots.items():
            yield root / package
            if package in (root.name, name):
                yield root
        for above in self._above:
            if package in (above.name, self._packages.get(above)):
                yield above
        yield self._base

    def _note_package(self, name: str) -> None:
        """Record the package of a missing mesh if there is no folder for it."""
        package, rest = _split(name) or ("", "")
        found = {self._base.name, *self._packages.values(), *self._roots.values()}
        if package and rest and package not in found | {root.name for root in self._roots}:
            self._unknown.add(package[:60])

    def _allows(self, path: Path) -> bool:
        return any(path.is_relative_to(one) for one in (self._base, *self._roots))

    def _short(self, path: Path) -> str:
        return os.path.relpath(path, self.folder) if path.is_relative_to(self._base) else str(path)

    def _find_by_end(self, name: str) -> Path:
        """Return the file whose path ends like a name; raise an error if there is not just one."""
        parts, written = _parts(name), unquote(name.replace("\\", "/"))
        for length in range(len(parts), 0, -1):
            end = parts[-length:]
            if length < len(parts) and self._folders_before.get(end) == "":
                break
            ranks = {
                path: (
                    path.parents[length - 1] in (self.folder, self._base),
                    written.endswith("/".join(path.parts[-length:])),
                )
                for path in self._ends.get(end, ())
            }
            best = [path for path, rank in ranks.items() if rank == max(ranks.values())]
            if len(best) > 1:
                self._hints.add("to decide, write the path from the robot's file, or remove files")
                both = shorten([self._short(path) for path in best], 2)
                raise MeshError(f"{both} fit equally well")
            if best and self._allows(best[0].resolve()):
                self._found[name] = best[0]
                return best[0].resolve()
        self._note_package(name)
        raise MeshError("not found")

    @cached_property
    def _folders_before(self) -> dict[tuple[str, ...], str]:
        """The folder before each end of the robot's names; '' where they have several."""
        folders: dict[tuple[str, ...], str] = {}
        for parts in map(_parts, self.names):
            for length in range(1, len(parts)):
                end, folder = parts[-length:], parts[-length - 1]
                if folders.setdefault(end, folder) != folder:
                    folders[end] = ""
        return folders

    @cached_property
    def _ends(self) -> dict[tuple[str, ...], list[Path]]:
        """Files with the names of meshes in the base and the roots, by each end of their paths.

        Links are not followed. Nearer folders come first, each wholly or not at all, so that the
        limits do not make the result depend on the order in the file system.
        """
        ends = defaultdict(list)
        wanted = {_parts(name)[-1:] for name in self.names}
        pending = deque((str(folder), 0) for folder in (self._base, *self._roots))
        left = ENTRIES
        while pending:
            folder, depth = pending.popleft()
            try:
                with os.scandir(folder) as listing:
                    found = sorted(islice(listing, CROWD + 1), key=lambda entry: entry.name)
                left -= len(found)
                if len(found) > CROWD or left < 0:
                    self._hints.add("folders with too many files were not searched")
                    found, pending = [], pending if left > 0 else deque()
                for entry in found:
                    if entry.is_dir(follow_symlinks=False):
                        if depth < DEPTH and not entry.name.startswith("."):
                            pending.append((entry.path, depth + 1))
                    elif entry.is_file(follow_symlinks=False) and _parts(entry.name) in wanted:
                        parts = _parts(entry.path)
                        for length in range(1, len(parts) + 1):
                            ends[parts[-length:]].append(Path(entry.path))
            except OSError:
                continue
        return ends


def _split(name: str) -> tuple[str, str] | None:
    """Return the package of a name, '' for a path, and the path in it; None for other URIs."""
    scheme, separator, rest = name.partition("://")
    if not separator:
        return "", _posix(name)
    rest = _posix(unquote(rest))
    if scheme == "file":
        return "", rest
    package, _, rest = rest.lstrip("/").partition("/")
    found = package, _posix(rest)
    return found if scheme in ("package", "model") and package.strip(".") else None


def _parts(name: str) -> tuple[str, ...]:
    """Return the last parts of a path or URI, to compare: decoded, and in lower case."""
    path = re.sub(r"^\s*\w+:", "", name[-4096:])
    parts = (unquote(part).strip().casefold() for part in re.split(r"[\\/]", path))
    return tuple(part for part in parts if part.strip("."))[-DEPTH:]


def _posix(path: str) -> str:
    """Return a path with slashes, whose server Windows would not contact and log in to."""
    if "\\" in path or path[1:2] == ":":
        path = PureWindowsPath(path).as_posix()
    return re.sub("^/+", "/", path)


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

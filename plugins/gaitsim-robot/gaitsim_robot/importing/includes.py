"""Make an MJCF document self-contained: convert dialects, inline includes, load meshes."""

from collections.abc import Callable, Mapping
from pathlib import PurePosixPath
from xml.etree.ElementTree import Element, SubElement

from gaitsim_robot.errors import RobotError, check_count
from gaitsim_robot.importing.files import MODEL_BYTES, RobotFiles
from gaitsim_robot.importing.meshes import check_vertices, count_vertices
from gaitsim_robot.importing.tree import SWAPPED, report
from gaitsim_robot.markup import check_elements, number, numbers, parse


def modernise(root: Element, repairs: list[str]) -> None:
    """Convert a document in place.

    Bullet's examples have inertias without a position and joints of type `fixed`. MuJoCo before
    2.3.4 had an option `collision`.
    """
    for option in root.iter("option"):
        for old in ("collision", "apirate"):
            option.attrib.pop(old, None)
    for inertial in root.iter("inertial"):
        inertial.set("pos", inertial.get("pos", "0 0 0"))
    for body in root.iter("body"):
        body[:] = [one for one in body if one.tag != "joint" or one.get("type") != "fixed"]
    report(repairs, SWAPPED, _exchange_swapped_limits(root))


def _exchange_swapped_limits(root: Element) -> list[str]:
    """Put limits in ascending order, as MuJoCo ignores swapped ones; return their joints."""
    swapped = []
    for joint in root.iter("joint"):
        try:
            low, high = map(float, joint.get("range", "").split())
        except ValueError:  # no limits, or an error that MuJoCo reports
            continue
        if low > high:
            name = joint.get("name") or joint.get("class") or "without a name"
            swapped.append(f"{name} ({low:.4g} to {high:.4g})")
            joint.set("range", f"{high} {low}")
    return swapped


# Elements that do not affect a robot's mechanics, or that need files or plugins.
_DROPPED = {
    "texture": "", "material": "", "layer": "", "skin": "", "sensor": "", "visual": "",
    "size": "", "statistic": "", "custom": "", "hfield": "height fields", "extension": "plugins",
    "lengthrange": "", "plugin": "plugins", "flex": "soft bodies", "flexcomp": "soft bodies",
    "deformable": "soft bodies", "composite": "composites",
}  # fmt: skip


def inline_includes(root: Element, files: RobotFiles, where: str) -> None:
    """Replace every <include> with the content of its file."""
    seen: set[str] = set()
    count = 0
    pending = [(root, 1)]
    while pending:
        parent, depth = pending.pop()
        check_elements(count, depth, where)
        inlined: list[Element] = []
        for child in parent:
            if child.tag != "include":
                inlined.append(child)
                continue
            name = child.get("file", "")
            path = files.find(name)
            if path is None:
                raise RobotError(
                    f"included file not found: {name!r}",
                    where=where,
                    allowed="a path relative to the robot's file",
                )
            if str(path) in seen:
                raise RobotError(
                    f"the file {name!r} is included twice", where=where, allowed="each file once"
                )
            seen.add(str(path))
            part = parse(files.read(path, MODEL_BYTES), str(path))
            count += sum(1 for _ in part.iter())
            check_elements(count, depth, where)
            # An included file may include others, so its elements are checked, too.
            inlined += part
        if any(child.tag == "include" for child in parent):
            parent[:] = inlined
            pending.append((parent, depth))
        else:
            pending += [(child, depth + 1) for child in inlined]


def resolve_files(
    root: Element, files: RobotFiles, where: str, repairs: list[str]
) -> tuple[dict[str, bytes], set[str]]:
    """Load the meshes, and drop elements that need other files.

    Returns:
        The meshes by new names, the only files to which the document then refers; and the names of
        the bodies with missing meshes.
    """
    _drop_unsupported(root, where, repairs)
    strip, folder = _compiler(root)
    files.names = {mesh.get("file", "") for mesh in root.iter("mesh")}
    loaded: dict[str, bytes] = {}
    missing: set[str] = set()
    for mesh in root.iter("mesh"):
        name = mesh.get("file")
        if name is None:
            continue
        short = PurePosixPath(name.replace("\\", "/")).name
        mesh.set("name", mesh.get("name") or short.rpartition(".")[0] or short)
        found = files.load_mesh(short if strip else name, (folder, ""), lambda *read: read)
        if found is None:
            missing.add(mesh.get("name", ""))
            continue
        key = f"{len(loaded)}{found[1]}"
        loaded[key] = found[0]
        mesh.set("file", key)
        mesh.attrib.pop("content_type", None)
    repairs += files.describe_missing()
    incomplete = {
        body.get("name", "")
        for body in root.iter("body")
        if any(geom.get("mesh") in missing for geom in body.iterfind("geom"))
    }
    _remove(root, lambda one: one.get("name" if one.tag == "mesh" else "mesh") in missing)
    for element in root.iter():
        loads = element.tag == "mesh" and element.get("file") in loaded
        if any("file" in key for key in element.attrib) and not loads:
            raise RobotError(
                f"<{element.tag}> refers to a file",
                where=where,
                allowed="references to mesh files only",
                remedy=f"remove <{element.tag}>",
            )
    return loaded, incomplete


def _compiler(root: Element) -> tuple[bool, str]:
    """Return whether paths are stripped, and the folder of meshes; remove both settings."""
    strip, folder = False, ""
    for compiler in root.iter("compiler"):
        strip = compiler.attrib.pop("strippath", "false") == "true" or strip
        keys = "meshdir", "assetdir", "texturedir"
        meshes, assets, _ = (compiler.attrib.pop(key, "") for key in keys)
        folder = meshes or assets or folder
    return strip, folder


def _drop_unsupported(root: Element, where: str, repairs: list[str]) -> None:
    for element in root.iter():
        if (element.tag == "model" and element.get("file")) or element.tag == "attach":
            raise RobotError(
                "the file attaches a separate model, which gaitsim does not support",
                where=where,
                remedy="save the compiled model with MuJoCo (`mj_saveLastXML`), and use that file",
            )
        element.attrib.pop("material", None)
    lost = {_DROPPED.get(element.tag, "") for element in root.iter()}
    _remove(root, lambda one: one.tag in _DROPPED or one.get("type") in ("hfield", "sdf"))
    repairs += [f"dropped {noun}" for noun in sorted(lost) if noun]
    # MuJoCo simulates muscles to find the ranges of their lengths, for as long as the file says.
    SubElement(SubElement(root, "compiler"), "lengthrange", mode="none")


def _remove(root: Element, unwanted: Callable[[Element], bool]) -> None:
    for parent in list(root.iter()):
        kept = [child for child in parent if not unwanted(child)]
        if len(kept) < len(parent):
            parent[:] = kept


BODIES = 2000  # MuJoCo compiles 2,000 in 4 s, and five times as many in 50 s
COPIES = 10_000  # elements after replication
FINEST = 100.0  # parameter of a built-in mesh, such as its resolution


def check_size(root: Element, assets: Mapping[str, bytes], where: str) -> None:
    """Check that MuJoCo can compile a document within seconds."""
    bodies = total = largest = 1
    pending = [(root, 1)]
    while pending:
        element, copies = pending.pop()
        if element.tag == "replicate":
            count = number(element.get("count"), 1.0, f"{where}, <replicate>")
            copies *= max(int(count), 1)
            largest = max(largest, copies)
        bodies += copies * (element.tag == "body")
        total += copies
        pending += [(child, copies) for child in element]
    # Every copy of a body also copies the actuators, constraints and contacts that refer to it.
    others = sum(1 for tag in _REFERRING for section in root.iter(tag) for _ in section)
    total += others * (largest - 1)
    replicated = " after replication" if largest > 1 else ""
    remedy = "remove everything that is not part of the robot, such as terrain"
    check_count(bodies, BODIES, f"bodies{replicated}", where, remedy)
    check_count(total, COPIES, f"elements{replicated}", where, remedy)
    vertices = sum(_mesh_size(mesh, assets, where) for mesh in root.iter("mesh"))
    check_vertices(vertices, where)


_REFERRING = ("actuator", "contact", "equality", "tendon")


def _mesh_size(mesh: Element, assets: Mapping[str, bytes], where: str) -> int:
    """Return the number of vertices of a mesh, or an upper bound for it."""
    file = mesh.get("file")
    if file is not None:
        return count_vertices(assets[file], PurePosixPath(file).suffix)
    if "builtin" not in mesh.attrib:
        return len(mesh.get("vertex", "").split()) // 3
    params = mesh.get("params") or "0"
    place = f"{where}, params of the mesh {mesh.get('name', '')!r}"
    return int(numbers(params, len(params.split()), "", place, FINEST).max()) ** 2

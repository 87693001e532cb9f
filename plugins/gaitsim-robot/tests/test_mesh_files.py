"""Meshes that are not where a robot's file says, as exporters write their paths."""

import pytest
from test_importing import BOX, MESH, TWO, links, mesh_robot, write_obj, write_package

from gaitsim_robot.errors import RobotError
from gaitsim_robot.importing import files
from gaitsim_robot.importing.convert import convert


def repairs_of(path, roots=()):
    return convert(str(path), [str(root) for root in roots])["repairs"]


@pytest.mark.parametrize(
    "name",
    [
        "package://foot pad.obj",
        "package://foot%20pad.obj",
        "package:///foot pad.obj",
        "package://meshes/foot pad.obj",
        "package://Dog_Description/Meshes/FOOT pad.OBJ",
        "package://dog/meshes/visual/foot pad.obj",
        "file:///home/someone/dog/meshes/foot%20pad.obj",
        "file://$(find dog)/meshes/foot pad.obj",
        "/home/someone/dog/meshes/foot pad.obj",
        r"C:\Users\Someone\dog\meshes\foot pad.obj",
        "file:///C:/Users/Someone/dog/foot pad.obj",
        "../../elsewhere/meshes/foot pad.obj",
        " MESHES\\foot%20pad.obj ",
    ],
)
@pytest.mark.parametrize("place", ["", "meshes", "assets/meshes"])
def test_a_mesh_is_found_by_the_end_of_its_path(tmp_path, name, place):
    mesh = tmp_path / "mine" / place / "foot pad.obj"
    write_obj(mesh)
    path = mesh_robot(tmp_path / "mine", name)
    found = [line for line in repairs_of(path) if "found" in line]
    # As the package `meshes` is not known, it may be the robot's own folder.
    exact = name.endswith("//meshes/foot pad.obj") and not place
    where = mesh.relative_to(path.parent)
    assert found == [f"meshes found by the end of their paths: 1, such as {name!r} at {where}"] or (
        exact and not found
    )


def test_meshes_of_mjcf_files_are_found_alike(tmp_path):
    write_obj(tmp_path / "assets" / "Foot.obj")
    path = tmp_path / "robot.xml"
    asset = r"<asset><mesh file='D:\dog\foot.obj'/></asset><worldbody>"
    path.write_text(TWO.replace("<worldbody>", asset))
    assert " at assets/Foot.obj" in " ".join(repairs_of(path))


def test_an_exact_path_wins_and_is_not_reported(tmp_path):
    write_obj(tmp_path / "foot.obj")
    write_obj(tmp_path / "meshes" / "foot.obj")
    for name in ("foot.obj", "meshes/foot.obj", "package://any/foot.obj"):
        assert "found" not in " ".join(repairs_of(mesh_robot(tmp_path, name)))


FOOT = "/home/me/meshes/foot.obj"


@pytest.mark.parametrize(
    ("places", "repair"),
    [
        (["old/foot.obj", "x/meshes/foot.obj"], " at x/meshes/foot.obj"),
        (["old/meshes/foot.obj", "meshes/foot.obj"], " at meshes/foot.obj"),
        (["a/FOOT.obj", "b/foot.obj"], " at b/foot.obj"),
        (["a/foot.obj", "b/foot.obj"], "foot.obj (a/foot.obj, b/foot.obj fit equally well); to"),
        ([".git/foot.obj"], "foot.obj (not found)"),
        (["1/2/3/4/5/6/7/8/9/foot.obj"], "foot.obj (not found)"),
    ],
)
def test_the_longest_end_wins_and_nothing_is_guessed(tmp_path, places, repair):
    for place in places:
        write_obj(tmp_path / place)
    assert repair in " ".join(repairs_of(mesh_robot(tmp_path, FOOT)))


def test_the_mesh_of_another_link_is_not_used(tmp_path):
    write_obj(tmp_path / "b" / "mesh.obj")
    path = mesh_robot(tmp_path, "package://dog/b/mesh.obj")
    path.write_text(path.read_text().replace(BOX, MESH.format("package://dog/a/mesh.obj"), 1))
    assert "meshes not used: mesh.obj (not found)" in repairs_of(path)


def test_no_file_outside_the_folders_is_found(tmp_path):
    write_obj(tmp_path / "secret.obj")
    write_obj(tmp_path / "other" / "secret.obj")
    path = mesh_robot(tmp_path / "mine", "package://secret.obj")
    (tmp_path / "mine" / "link").symlink_to(tmp_path / "other")
    (tmp_path / "mine" / "SECRET.obj").symlink_to(tmp_path / "secret.obj")
    assert "meshes not used: secret.obj (not found)" in repairs_of(path)
    assert "meshes not used" not in " ".join(repairs_of(path, [tmp_path / "other"]))
    for name in (
        "../secret.obj",
        str(tmp_path / "secret.obj"),
        "/etc/passwd",
        "file:///etc/passwd",
    ):
        with pytest.raises(RobotError, match="outside its folder"):
            repairs_of(mesh_robot(tmp_path / "mine", name))


def test_the_search_is_limited_and_says_so(tmp_path, monkeypatch):
    write_package(tmp_path, "dog")
    for index in range(9):
        write_obj(tmp_path / "many" / f"{index}.obj")
    write_obj(tmp_path / "meshes" / "foot.obj")
    path = mesh_robot(tmp_path, "/home/me/foot.obj")
    monkeypatch.setattr(files, "CROWD", 5)
    assert "at meshes/foot.obj" in " ".join(repairs_of(path))
    monkeypatch.setattr(files, "ENTRIES", 4)
    assert "(not found); folders with too many files were not searched" in " ".join(
        repairs_of(path)
    )


def test_long_lists_are_folded(tmp_path):
    path = mesh_robot(tmp_path, "0.obj")
    many = "".join(MESH.format(f"package://p{n}/{n}.obj") for n in range(1, 40))
    path.write_text(links(b=MESH.format("0.obj") + many))
    lines = repairs_of(path)
    assert any("15.obj and 32 more (not found)" in line for line in lines), lines
    part = (
        '<link name="{0}"><collision><geometry><box size="1 1 0"/></geometry></collision></link>'
        '<joint name="{0}" type="fixed"><parent link="a"/><child link="{0}"/></joint>'
    )
    extra = "".join(part.format(n) for n in "123456789")
    path.write_text(links(extra=extra))
    assert "dropped a flat box: link '1'; and 8 more like this" in repairs_of(path)


def test_unused_properties_of_xacro_are_ignored(tmp_path):
    path = tmp_path / "robot.urdf"
    width = '<xacro:property name="width" value="0.1"/>'
    path.write_text(links(a=BOX + width, extra=width.replace("width", "mass")))
    assert "unused properties of xacro ignored: 'width', 'mass'" in repairs_of(path)
    for text in (links(extra=width).replace("0 1 0", "0 ${width} 0"), links(extra="<xacro:leg/>")):
        path.write_text(text)
        with pytest.raises(RobotError, match="xacro file, not URDF"):
            repairs_of(path)

"""Import of URDF and MJCF files: conversion, repairs, and errors for invalid or hostile files."""

import os
import shutil
import struct
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from gaitsim_robot import child
from gaitsim_robot.errors import RobotError
from gaitsim_robot.importing import import_robot
from gaitsim_robot.importing.convert import convert
from gaitsim_robot.importing.files import RobotFiles
from gaitsim_robot.importing.meshes import MeshError, count_vertices, decode, hull
from gaitsim_robot.loading import bundled_text

FIXTURES = Path(__file__).parent / "fixtures" / "robots"
DOG = FIXTURES / "dog_description" / "urdf" / "dog.urdf"


def read(path, roots=()):
    """Import a file in this process instead of a child process."""
    result = convert(str(path), [str(root) for root in roots])
    model = mujoco.MjModel.from_xml_string(result["text"])
    return model, " | ".join(result["repairs"]), result["text"]


def body(model, name):
    return model.body(name).id


def test_a_urdf_of_a_package_keeps_mass_joints_and_feet():
    model, repairs, _ = read(DOG)
    # Sum of the file's masses: 2 + 0.5 of the trunk and its sensor, 4 × (0.3 + 0.1).
    assert model.body_mass.sum() == pytest.approx(4.1, rel=1e-6)
    assert model.body_mass[body(model, "trunk")] == pytest.approx(2.5, rel=1e-6)
    # The centre of the two masses.
    assert model.body_ipos[body(model, "trunk")] == pytest.approx([0.04, 0, 0.01], abs=1e-6)
    joints = [model.joint(index).name for index in range(1, model.njnt)]
    assert joints == [
        f"{leg}_{part}" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "knee")
    ]
    knee = model.joint("FL_knee")
    assert knee.range == pytest.approx([-2, -0.5])
    assert model.jnt_actfrcrange[knee.id] == pytest.approx([-7, 7])
    assert model.jnt_user[knee.id] == pytest.approx([12])
    assert "without limits, ±90° assumed: 'RR_hip'" in repairs
    assert "meshes not used: gone.stl (not found)" in repairs
    assert model.eq_type.tolist() == [mujoco.mjtEq.mjEQ_JOINT]
    assert model.eq_data[0, :2] == pytest.approx([0.1, -1.0])


def test_duplicate_joint_names_are_made_unique(tmp_path):
    package = shutil.copytree(DOG.parents[1], tmp_path / "dog_description")
    file = package / "urdf" / "dog.urdf"
    file.write_text(file.read_text().replace('"FR_hip"', '"FL_hip"'))
    _, repairs, _ = read(file)
    assert "joint 'FL_hip' renamed to 'FL_hip 2'" in repairs


def test_a_footprint_does_not_change_the_frame_of_the_trunk(tmp_path):
    package = shutil.copytree(DOG.parents[1], tmp_path / "dog_description")
    file = package / "urdf" / "dog.urdf"
    floating = '<joint name="floating" type="floating">'
    on_ground = '<joint name="floating" type="fixed"><origin xyz="0.1 0 0.3"/>'
    file.write_text(file.read_text().replace(floating, on_ground))
    expected, found = read(DOG)[0], read(file)[0]
    assert found.body_pos[1] == pytest.approx([0.1, 0, 0.3])
    for name in ("body_pos", "body_ipos", "geom_pos"):
        skip = 2 if name == "body_pos" else 0
        assert getattr(found, name)[skip:] == pytest.approx(getattr(expected, name)[skip:])


@pytest.mark.parametrize("turned", [False, True])
def test_meshes_become_hulls_of_few_vertices(tmp_path, turned):
    """The file declares y up; its meshes are rotated only if that fits the centres of mass."""
    package = shutil.copytree(DOG.parents[1], tmp_path / "dog_description")
    if turned:
        mesh = package / "meshes" / "shank.dae"
        text = mesh.read_text().replace("0 0 -100", "0 -100 0").replace("10 10 100", "10 100 10")
        mesh.write_text(text)
    model, repairs, _ = read(package / "urdf" / "dog.urdf")
    assert ("from y up to z up" in repairs) == turned
    shank = model.body("FL_shank")
    kinds = model.geom_type[shank.geomadr[0] :][: shank.geomnum[0]]
    assert kinds.tolist() == [mujoco.mjtGeom.mjGEOM_MESH]
    # A box of 20 × 20 × 200 mm; COLLADA's file is in millimetres, and its nodes move the box.
    vertices = model.mesh_vert[: model.mesh_vertnum[0]]
    assert np.sort(np.ptp(vertices, axis=0)) == pytest.approx([0.02, 0.02, 0.2], abs=1e-5)
    assert model.mesh_vertnum.max() <= 64
    assert model.geom_pos[shank.geomadr[0]] == pytest.approx([0, 0, -0.1], abs=1e-5)


def test_dynamics_agree_with_mujocos_urdf_reader(tmp_path):
    """Compare the mass matrix and gravity of the legs; MuJoCo's reader fixes the trunk."""
    document = ElementTree.parse(DOG).getroot()
    for link in document.iter("link"):
        for seen in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(seen)
    # MuJoCo's reader does not support floating joints with a range.
    for joint in document.iter("joint"):
        joint.set("type", joint.get("type").replace("floating", "fixed"))
    theirs = mujoco.MjModel.from_xml_string(ElementTree.tostring(document, "unicode"))
    ours, _, _ = read(DOG)
    angles = np.random.default_rng(5).uniform(-1, 1, 8)
    found = []
    for model, first in ((theirs, 0), (ours, 6)):
        data = mujoco.MjData(model)
        data.qpos[-8:] = angles
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        found.append((mass[first:, first:], data.qfrc_bias[first:]))
    assert found[1][0] == pytest.approx(found[0][0], rel=1e-5, abs=1e-9)
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-5, abs=1e-9)


CRAB = """<mujoco model="crab">
  <compiler meshdir="meshes" angle="degree"/>
  <default><default class="leg"><joint axis="0 1 0" damping="0.3"/></default></default>
  <asset><mesh file="shell.stl"/><mesh name="eye" file="eye.obj"/></asset>
  <include file="parts/floor.xml"/>
  <worldbody>
    <body name="ball" pos="3 0 1"><freejoint/><geom size="0.1"/></body>
    <body name="crab" pos="0 0 0.4">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="pitch" axis="0 1 0"/>
      <geom type="mesh" mesh="shell" mass="1"/>
      <geom type="mesh" mesh="eye" contype="0" conaffinity="0" mass="0.01"/>
      <body name="leg" pos="0.1 0 0" childclass="leg">
        <joint name="hip" type="hinge" range="-60 60"/><joint name="knob" type="slide"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.2" contype="2"/>
        <site name="tip" pos="0 0 -0.3"/><site name="top"/>
        <body pos="0 0 -0.3"><joint name="ankle" type="ball"/><geom size="0.03" mass="0.1"/></body>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="crab" body2="leg"/></contact>
  <tendon><spatial><site site="tip"/><site site="top"/></spatial></tendon>
  <actuator><motor joint="hip" gear="20" ctrlrange="-0.5 0.5"/></actuator>
  <sensor><jointpos joint="hip"/></sensor>
  <keyframe><key name="home" qpos="3 0 1 1 0 0 0  0 0 0.5 0 1 0 0 0"/></keyframe>
</mujoco>"""
FLOOR = '<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/></worldbody></mujoco>'


@pytest.fixture
def crab(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "floor.xml").write_text(FLOOR)
    corners = [(x, y, z) for x in (-0.2, 0.2) for y in (-0.1, 0.1) for z in (0, 0.05)]
    faces = ConvexHull(np.array(corners)).simplices
    triangles = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(v for corner in face for v in corners[corner]), 0)
        for face in faces
    )
    stl = bytes(80) + struct.pack("<I", len(faces)) + triangles
    (tmp_path / "meshes" / "shell.stl").write_bytes(stl)
    path = tmp_path / "crab.xml"
    path.write_text(CRAB)
    return path


def test_only_the_robot_of_an_mjcf_file_is_kept(crab):
    model, repairs, text = read(crab)
    names = [model.joint(index).name for index in range(model.njnt)]
    assert names == ["crab", "hip", "knob", "ankle x", "ankle y", "ankle z"]
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert [model.joint(one).name for one in model.actuator_trnid[:, 0]] == ["hip"]
    # The eye's mesh is missing.
    assert model.body_mass[1:] == pytest.approx([1.0, 0.2, 0.1], rel=1e-5)
    hip = model.joint("hip")
    assert hip.range == pytest.approx(np.radians([-60, 60]), rel=1e-5)
    assert model.jnt_actfrcrange[hip.id] == pytest.approx([-10, 10])
    assert model.dof_damping[6] == pytest.approx(0.3)
    assert model.key("stand").qpos[7:] == pytest.approx([0.5, 0, 0, 0, 0])
    assert model.nexclude == 1
    assert "floor" not in text
    for lost in (
        "eye.obj",
        "'ball'",
        "three passive hinges each: 'ankle'",
        "now free: 'x', 'pitch'",
    ):
        assert lost in repairs
    # All shapes touch the ground (contact bit 1); they collide with each other as in the file.
    ground, bits = 1, list(zip(model.geom_contype, model.geom_conaffinity, strict=True))
    assert all(contype & ground for contype, _ in bits)
    assert all(not conaffinity & ground for _, conaffinity in bits)


ACTUATORS = """<actuator>
<position joint="kp" kp="30"/>
<position joint="geared" kp="20" kv="0.5" gear="-3" forcerange="-2 2"/>
<position joint="pair" kp="10"/><velocity joint="pair" kv="0.7"/>
<motor joint="motor" gear="4" ctrlrange="-1 1"/><velocity name="v" joint="speed" kv="2"/>
<muscle name="m" joint="speed"/></actuator></mujoco>"""


def test_the_stiffness_and_damping_of_position_actuators_are_kept(tmp_path):
    names = ("kp", "geared", "pair", "motor", "speed")
    arms = "".join(f"<body><joint name='{name}'/><geom size='1'/></body>" for name in names)
    path = tmp_path / "robot.xml"
    text = TWO.replace("<body><joint/><geom size='1'/></body>", arms)
    path.write_text(text.replace("</mujoco>", ACTUATORS))
    model, repairs, _ = read(path)
    users = {name: model.jnt_user[model.joint(name).id].tolist() for name in names}
    # Speed, stiffness and damping at the joint; the gear multiplies angles and torques.
    assert users["kp"] == [0, 30, 0]
    assert users["geared"] == pytest.approx([0, 180, 4.5])
    assert users["pair"] == [0, 10, 0.7]
    assert users["motor"] == users["speed"] == [0, 0, 0]
    assert model.jnt_actfrcrange[model.joint("geared").id].tolist() == [-6, 6]
    assert model.jnt_actfrcrange[model.joint("motor").id].tolist() == [-4, 4]
    dropped = "dropped actuators other than motors and position servos of joints: 'v', 'm'"
    assert dropped in repairs


def test_a_closed_linkage_is_kept(tmp_path):
    path = tmp_path / "loop.xml"
    path.write_text("""<mujoco><worldbody><body name="a"><freejoint/><geom size="0.1"/>
      <body name="b" pos="1 0 0"><joint axis="0 1 0"/><geom size="0.1" pos="0 0 -1"/></body>
      <body name="c"><joint axis="0 1 0"/><geom size="0.1" pos="0 0 -1"/></body>
      </body></worldbody>
      <equality><connect body1="b" body2="c" anchor="0 0 -1"/></equality></mujoco>""")
    model, _, _ = read(path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    first, second = (data.site_xpos[model.eq_obj1id[0]], data.site_xpos[model.eq_obj2id[0]])
    assert first == pytest.approx([1, 0, -1])
    assert second == pytest.approx(first)


LINKS = """<link name="a">{a}</link><link name="b">{b}</link>
<joint name="j" type="{kind}"><parent link="a"/><child link="b"/><origin xyz="0 0 -0.2"/>
<axis xyz="0 1 0"/></joint>"""
BOX = '<collision><geometry><box size="0.1 0.1 0.2"/></geometry></collision>'

MESH = '<collision><geometry><mesh filename="{}"/></geometry></collision>'


def links(a=BOX, b=BOX, kind="continuous", extra=""):
    return f'<robot name="arm">{LINKS.format(a=a, b=b, kind=kind)}{extra}</robot>'


def arm(tmp_path, *parts, **more):
    path = tmp_path / "arm.urdf"
    path.write_text(links(*parts, **more))
    return path


def inertial(mass, *diagonal):
    parts = " ".join(f'i{k}="{v}"' for k, v in zip(("xx", "yy", "zz"), diagonal, strict=False))
    return f'<inertial><mass value="{mass}"/><inertia {parts} ixy="0" ixz="0" iyz="0"/></inertial>'


def test_without_masses_the_geometry_has_the_density_of_water(tmp_path):
    model, repairs, _ = read(arm(tmp_path))
    assert model.body_mass[1:] == pytest.approx([2.0, 2.0], rel=1e-5)  # 0.002 m³ each
    assert model.body_inertia[1] == pytest.approx([1 / 120, 1 / 120, 1 / 300], rel=1e-3)
    assert "1000 kg/m³" in repairs
    assert "limited to ±180°: 'j'" in repairs


def test_impossible_inertias_and_missing_masses_are_repaired_and_reported(tmp_path):
    a = inertial(3, 0.01, 0.01, 0.9) + BOX
    model, repairs, _ = read(arm(tmp_path, a=a, b=""))
    assert model.body_mass.sum() == pytest.approx(3, rel=0.01)
    assert "replaced by their mean: 'a'" in repairs
    assert "links without mass, 0.003 kg each assumed: 'b'" in repairs
    assert "a capsule assumed: 'b'" in repairs


def test_a_chain_of_many_links_is_refused(tmp_path):
    path = tmp_path / "chain.urdf"
    names = "".join(f'<link name="{index}">{inertial(1, 1, 1, 1)}</link>' for index in range(3000))
    joint = '<joint name="{0}" type="continuous"><parent link="{0}"/><child link="{1}"/></joint>'
    joints = "".join(joint.format(index, index + 1) for index in range(2999))
    path.write_text(f"<robot>{names}{joints}</robot>")
    with pytest.raises(RobotError, match="3,000 moving links"):
        read(path)


def test_a_massless_link_between_two_joints_becomes_a_universal_joint(tmp_path):
    more = '<link name="c">{}</link><joint name="k" type="continuous"><parent link="b"/>'
    more += '<child link="c"/><origin xyz="0 0 0" rpy="0 0 1"/><axis xyz="1 0 0"/></joint>'
    path = arm(
        tmp_path,
        inertial(1, 0.01, 0.01, 0.01) + BOX,
        "",
        extra=more.format(inertial(1, 0.01, 0.01, 0.01) + BOX),
    )
    model, _, _ = read(path)
    assert model.body_jntnum.tolist() == [0, 1, 2]
    assert model.jnt_axis[1] == pytest.approx([np.sin(1), np.cos(1), 0], abs=1e-6)


TWO = """<mujoco><worldbody><body><geom size='1' density='9'/>
<body><joint/><geom size='1'/></body></body></worldbody></mujoco>"""
BUILTIN = TWO.replace(
    "<worldbody>",
    """<asset><mesh name="m" builtin="supersphere"
params="{}"/></asset><worldbody>""",
)
REPLICATED = TWO.replace(
    "<joint/>",
    """<joint/><replicate count="{}"><replicate count="{}"><geom
size="1"/></replicate></replicate>""",
)
BILLION = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "not XML"),
        ("\x7fELF\0\0", "not XML"),
        ("<robot><link name='a'>", "not XML"),
        ("<robot xmlns:xacro='x'><xacro:leg/></robot>", "xacro file, not URDF.*<xacro:leg>"),
        (links().replace("0 1 0", "${axis}"), "xacro file, not URDF.*formula"),
        ("<!DOCTYPE html>\n<html><head><meta></head></html>", "this is a web page"),
        ("<!-- saved -->\n<html><p></html>", "this is a web page"),
        ("<html/>", "the document is a web page"),
        ("version https://git-lfs.github.com/spec/v1\noid sha256:0", "a Git LFS pointer"),
        ("404: Not Found", "a failed download"),
        ("PK\x03\x04", "a ZIP archive"),
        (BILLION, "document type"),
        ("<a>" * 400 + "</a>" * 400, "too many elements"),
        ("<sdf version='1.6'/>", "an SDF file of Gazebo"),
        ("<package><name>dog</name></package>", "the package.xml of a ROS package"),
        ("<svg/>", "the document is a <svg>"),
        ("<robot/>", "no links"),
        (links(kind="fixed"), "no joint"),
        (links("", ""), "no mass"),
        (links(inertial(-1)), "negative"),
        (links(inertial("1e400")), "invalid"),
        (links(*2 * ['<collision><geometry><sphere radius="1e-110"/></geometry></collision>']),
            "cannot be simulated"),
        (links(inertial("nan")), "invalid"),
        (links().replace("0 1 0", "0 0 0"), "axis"),
        (links(kind="magic"), "unknown type"),
        (links().replace('parent link="a', 'parent link="b'), "loop"),
        (links().replace('child link="b', 'child link="z'), "does not exist"),
        ("<mujoco/>", "no bodies"),
        ("<mujoco><worldbody><body><geom/></body></worldbody></mujoco>", "cannot compile"),
        ("<mujoco><worldbody><body><nonsense/></body></worldbody></mujoco>", "cannot compile"),
        (TWO.replace("density='9'", "pos='nan 0 0'"), "invalid pos of the geom 0"),
        (TWO.replace("density='9'", "name='g' quat='1e300 0 0 0'"), "invalid quat of the geom 'g'"),
        (TWO.replace("<body>", "<body name='b' quat='1e300 0 0 0'>", 1), "quat of the body 'b'"),
        (TWO.replace("<joint/>", "<joint damping='1e9'/>"), "invalid damping of the joint 0"),
        (BUILTIN.format("100000 1 1"), "(?s)invalid value '100000 1 1'.*params of the mesh 'm'"),
        (BUILTIN.format("9 nan 1"), "invalid value"),
        (BUILTIN.format("9 1e9 -1"), "invalid value"),
        (REPLICATED.format(100_000, 1), "300,0.* elements after replication"),
        (REPLICATED.format(100, 1000), "200,1.* elements after replication"),
        (REPLICATED.format(80, 80), "12,.* elements after replication"),
        (REPLICATED.format("1e9", 1), "(?s)invalid value '1e9'.*<replicate>"),

        ("<mujoco><include file='../secret.xml'/></mujoco>", "outside its folder"),
        ("<mujoco><include file='gone.xml'/></mujoco>", "not found"),
        ("<mujoco><include file='robot.xml'/></mujoco>", "included twice"),
        (BUILTIN.replace("builtin", "file='robot.xml' a").replace(
            "<worldbody>", "<Include file='0.xml'/><worldbody>"), "<Include> refers to a file"),
        ("<mujoco><asset><mesh file='/etc/passwd'/></asset></mujoco>", "outside its folder"),
        ("<mujoco><asset><model file='other.xml'/></asset></mujoco>", "attaches a separate model"),
    ],
)  # fmt: skip
def test_invalid_files_are_refused_with_a_reason(tmp_path, text, what):
    folder = tmp_path / "mine"
    folder.mkdir()
    (tmp_path / "secret.xml").write_text(FLOOR)
    path = folder / "robot.xml"
    path.write_text(text)
    with pytest.raises(RobotError, match=what):
        read(path)


def test_files_outside_the_folder_are_refused_unless_allowed(tmp_path):
    folder, other = tmp_path / "mine", tmp_path / "other"
    folder.mkdir()
    other.mkdir()
    (other / "floor.xml").write_text(FLOOR)
    (folder / "link.xml").symlink_to(other / "floor.xml")
    path = folder / "robot.xml"
    for name in ("../other/floor.xml", "link.xml", str(other / "floor.xml")):
        path.write_text(CRAB.replace("parts/floor.xml", name))
        with pytest.raises(RobotError, match="outside its folder"):
            read(path)
        assert "missing" not in read(path, [other])[1]


def test_includes_within_includes_are_as_shallow_as_one_file(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(TWO.replace("<joint/>", "<joint/><include file='1.xml'/>"))
    nested = f"<mujoco>{200 * '<frame>'}<include file='2.xml'/>{200 * '</frame>'}</mujoco>"
    (tmp_path / "1.xml").write_text(nested)
    (tmp_path / "2.xml").write_text(nested.replace("<include file='2.xml'/>", ""))
    with pytest.raises(RobotError, match="too many elements"):
        read(path)


def mesh_robot(folder, name):
    """Write a URDF whose second link has the mesh `name`."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "robot.urdf"
    path.write_text(links(b=MESH.format(name)))
    return path


def write_obj(path, size=0.1):
    path.parent.mkdir(parents=True, exist_ok=True)
    corners = [(x, y, z) for x in (0, size) for y in (0, size) for z in (0, 2 * size)]
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners))


def write_package(folder, name):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name> {name} </name></package>")


@pytest.mark.parametrize("package", ["", "/", ".", "..", "%2e%2e", "%2F"])
def test_a_uri_without_a_package_name_refers_to_no_file(tmp_path, package):
    write_obj(tmp_path / "secret.obj")
    path = mesh_robot(tmp_path / "mine", f"package://{package}/secret.obj")
    assert "secret.obj (not found)" in read(path)[1]
    # It does not allow files by later names, either.
    path.write_text(path.read_text().replace(BOX, BOX + MESH.format(tmp_path / "secret.obj"), 1))
    with pytest.raises(RobotError, match="outside its folder"):
        read(path)


def test_a_package_needs_a_package_xml_with_its_name(tmp_path):
    """Neither the name of a folder nor a URI extends the set of files that may be read."""
    outer = tmp_path / "outer"
    write_obj(outer / "meshes" / "secret.obj")
    path = mesh_robot(outer / "deep" / "mine", "package://outer/meshes/secret.obj")
    with pytest.raises(RobotError, match="is not that package") as caught:
        read(path)
    assert f"--root {outer} " in caught.value.remedy
    assert "meshes not used" not in read(path, [outer])[1]
    write_package(outer, "another")
    write_package(outer / "deep", "deep")
    with pytest.raises(RobotError, match="is not that package"):
        read(path)
    write_package(outer, "outer")
    assert "meshes not used" not in read(path)[1]
    # The name of the outer package does not allow its files by other names.
    path.write_text(path.read_text().replace(BOX, BOX + MESH.format("../../meshes/secret.obj"), 1))
    with pytest.raises(RobotError, match="outside its folder"):
        read(path)


def test_a_copied_package_is_found_by_its_name_or_its_layout(tmp_path):
    write_obj(tmp_path / "copy" / "meshes" / "foot.obj")
    for named in (False, True):
        path = mesh_robot(tmp_path / "copy" / "urdf", "package://dog/meshes/foot.obj")
        if named:
            write_package(tmp_path / "copy", "dog")
        assert "meshes not used" not in read(path)[1]
    path = mesh_robot(tmp_path / "copy" / "urdf", "package://cat/meshes/tail.obj")
    repairs = read(path)[1]
    assert "tail.obj (not found)" in repairs
    assert "packages not found: 'cat'" in repairs
    assert "--root" in repairs


@pytest.mark.parametrize("folder", ["mine", "urdf"])
def test_a_robot_in_the_home_folder_cannot_read_all_files_there(tmp_path, monkeypatch, folder):
    write_obj(tmp_path / "secret.obj")
    path = mesh_robot(tmp_path / folder, "../secret.obj")
    write_package(tmp_path, "home")
    assert "meshes not used" not in read(path)[1]
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    with pytest.raises(RobotError, match="outside its folder"):
        read(path)


def test_a_package_does_not_reach_files_through_links(tmp_path):
    write_obj(tmp_path / "secret.obj")
    write_package(tmp_path / "mine", "mine")
    (tmp_path / "mine" / "link.obj").symlink_to(tmp_path / "secret.obj")
    (tmp_path / "mine" / "up").symlink_to(tmp_path)
    for name in ("link.obj", "up/secret.obj", "../secret.obj", f"/{tmp_path}/secret.obj"):
        path = mesh_robot(tmp_path / "mine", f"package://mine/{name}")
        with pytest.raises(RobotError, match="outside its folder"):
            read(path)


def test_no_name_makes_windows_log_in_to_a_server(tmp_path, monkeypatch):
    files, opened = RobotFiles(tmp_path / "robot.xml", []), []
    monkeypatch.setattr(Path, "resolve", lambda path: opened.append(str(path)) or path)
    server = r"\\server\share"
    for name in (server, "file:////server/share", "package://dog///server/share", "foot.obj"):
        assert files.find(name, ("", server)) is None
    assert len(opened) >= 7
    assert not any(path.startswith("//") for path in opened)


def test_special_and_huge_files_are_refused(tmp_path):
    huge = tmp_path / "huge.urdf"
    with huge.open("wb") as file:
        file.truncate(100 * 2**20)
    pipe = tmp_path / "pipe.urdf"
    os.mkfifo(pipe)
    for path in (huge, pipe, tmp_path, tmp_path / "missing.urdf"):
        with pytest.raises(RobotError, match="cannot be read"):
            read(path)


@pytest.mark.parametrize(
    ("declared", "encoding"),
    [
        ("utf-8", "utf-16"),  # as written by PowerShell
        ("utf-16", "utf-16"),
        ("utf-16", "utf-16-le"),
        ("utf-16", "utf-16-be"),
        ("utf-8", "utf-8-sig"),
        ("windows-1252", "cp1252"),
        ("GB2312", "gb2312"),
    ],
)
def test_files_may_have_any_common_encoding(tmp_path, declared, encoding):
    name = "躯干" if declared == "GB2312" else "Körper" if "1252" in declared else "тело"
    robot = TWO.replace("<joint", f"<joint name={name!r}")
    text = f'<?xml version="1.0" encoding="{declared}"?>\n{robot}'
    path = tmp_path / "robot.xml"
    path.write_bytes(text.encode(encoding))
    model, _, _ = read(path)
    assert model.joint(1).name == name


def test_swapped_limits_are_exchanged_and_named(tmp_path):
    path = arm(tmp_path, kind="revolute")
    limits = '<axis xyz="0 1 0"/><limit lower="1" upper="-0.5"/>'
    path.write_text(path.read_text().replace('<axis xyz="0 1 0"/>', limits))
    model, repairs, _ = read(path)
    assert model.joint("j").range == pytest.approx([-0.5, 1])
    assert "swapped limits of joints exchanged: 'j (1 to -0.5)'" in repairs
    assert "without limits" not in repairs
    path = tmp_path / "robot.xml"
    path.write_text(TWO.replace("<joint/>", "<joint name='k' range='60 -30'/>"))
    model, repairs, _ = read(path)
    assert model.joint("k").range == pytest.approx(np.radians([-30, 60]), rel=1e-5)
    assert "swapped limits of joints exchanged: 'k (60 to -30)'" in repairs


LIDAR = """<link name="lidar"><inertial><mass value="0.2"/></inertial><collision><geometry><cylinder
radius="0.04" length="0.03"/></geometry></collision></link><joint name="mount" type="fixed"><parent
link="a"/><child link="lidar"/></joint>"""


def test_a_missing_mesh_of_the_trunk_is_a_warning(tmp_path):
    """The trunk does not get the name of the sensor on it, either."""
    path = arm(tmp_path, a=MESH.format("trunk.stl"), extra=LIDAR)
    result = convert(str(path), [])
    assert "meshes of the trunk 'a' are missing" in " ".join(result["warnings"])
    path.write_text(links(extra=LIDAR))
    assert not convert(str(path), [])["warnings"]
    path = tmp_path / "robot.xml"
    text = TWO.replace("<worldbody>", "<asset><mesh file='trunk.stl'/></asset><worldbody>")
    text = text.replace("<body>", "<body name='a'>", 1)
    path.write_text(text.replace("<geom", "<geom type='mesh' mesh='trunk'/><geom", 1))
    assert "meshes of the trunk 'a' are missing" in " ".join(convert(str(path), [])["warnings"])


@pytest.mark.parametrize("suffix", ["stl", "obj", "dae"])
def test_a_mesh_that_is_a_pointer_or_a_web_page_is_named(tmp_path, suffix):
    mesh = tmp_path / f"foot.{suffix}"
    path = arm(tmp_path, b=MESH.format(mesh.name))
    for content, kind in (("version https://git-lfs", "Git LFS"), ("<!DOCTYPE HTML>", "web page")):
        mesh.write_text(content)
        assert f"foot.{suffix} (it is a {kind}" in read(path)[1]
    robot = tmp_path / "robot.xml"
    robot.write_text(
        TWO.replace("<worldbody>", f"<asset><mesh file='{mesh.name}'/></asset><worldbody>")
    )
    assert f"foot.{suffix} (it is a web page" in read(robot)[1]


def test_muscles_are_not_simulated_during_the_import(tmp_path):
    """The file may ask for a simulation of years."""
    path = tmp_path / "robot.xml"
    endless = "<compiler><lengthrange mode='all' inttotal='1e9' timestep='1e-9'/></compiler>"
    text = TWO.replace("<worldbody>", f"{endless}<worldbody>").replace(
        "<joint/>", "<joint name='j'/>"
    )
    muscle = "<actuator><muscle name='m' joint='j'/></actuator></mujoco>"
    path.write_text(text.replace("</mujoco>", muscle))
    assert "dropped actuators other than motors and position servos of joints: 'm'" in read(path)[1]


def test_a_model_of_many_bodies_is_refused(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(TWO.replace("<joint/>", "<joint/>" + "<body><geom size='1'/></body>" * 2499))
    with pytest.raises(RobotError, match="2,502 bodies"):
        read(path)
    # Each of 900 bodies would have its own copies of 10 actuators.
    text = TWO.replace("<body><joint/>", "<replicate count='900'><body><joint name='j'/>")
    text = text.replace("</body></body></worldbody>", "</body></replicate></body></worldbody>")
    motors = "<motor joint='j'/>" * 10
    path.write_text(text.replace("</mujoco>", f"<actuator>{motors}</actuator></mujoco>"))
    with pytest.raises(RobotError, match=r"12,6.. elements after replication"):
        read(path)


def stl(corners):
    """Return a binary STL file with these triangles, (n, 3, 3)."""
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles = np.zeros(len(corners), kind)
    triangles["corners"] = corners
    return bytes(80) + struct.pack("<I", len(corners)) + triangles.tobytes()


@pytest.mark.sampled
@pytest.mark.parametrize("suffix", ["stl", "obj", "msh"])
def test_meshes_with_too_many_vertices_are_refused_before_mujoco_reads_them(tmp_path, suffix):
    corners = np.random.default_rng(1).normal(size=(100_001, 3, 3)).astype(np.float32)
    rows = corners.reshape(-1, 3)
    path = tmp_path / f"shell.{suffix}"
    if suffix == "stl":
        path.write_bytes(stl(corners))
    elif suffix == "obj":
        path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in rows.tolist()))
    else:
        path.write_bytes(struct.pack("<4i", len(rows), 0, 0, 0) + rows.tobytes())
    robot = tmp_path / "robot.xml"
    mesh = f"<asset><mesh file='{path.name}'/></asset><worldbody>"
    robot.write_text(TWO.replace("<worldbody>", mesh))
    with pytest.raises(RobotError, match="300,003 vertices"):
        read(robot)
    if suffix != "msh":
        text = links(b=4 * MESH.format(path.name))
        (tmp_path / "robot.urdf").write_text(text)
        with pytest.raises(RobotError, match="1,200,012 vertices"):
            read(tmp_path / "robot.urdf")


@pytest.mark.parametrize("line", ["v 0 0 0", "v x y z", " \tv 1 2"])
@pytest.mark.parametrize("end", ["\n", "\r", "\n\n"])
def test_vertices_of_an_obj_file_are_counted_as_mujoco_does(line, end):
    data = end.join([*(f"v {x} 0 {x * x}" for x in range(9)), line, line, "f 1 2 3", ""])
    assert count_vertices(data.encode(), ".obj") == (9 if line == "v 0 0 0" else 11)


@pytest.mark.slow
def test_a_hull_of_many_vertices_is_thinned():
    """A robot may use the mesh of a ball, whose vertices are all vertices of the hull."""
    ball = np.random.default_rng(2).normal(size=(20_000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    spike = np.array([[0.0, 0.0, -3.0]])
    found = hull(np.vstack([ball, spike]), 64)
    assert len(found) == 64
    assert found[:, 2].min() == -3
    thorough = hull(ball[:4000], 64)
    volume = ConvexHull(hull(ball, 64)).volume
    assert volume == pytest.approx(ConvexHull(thorough).volume, rel=0.02)


def test_nodes_of_a_collada_file_that_refer_to_one_another_are_refused():
    loop = (
        '<COLLADA><library_visual_scenes><visual_scene><node><instance_node url="#a"/></node>'
        '</visual_scene></library_visual_scenes><library_nodes><node id="a"><instance_node '
        'url="#a"/></node></library_nodes></COLLADA>'
    )
    with pytest.raises(MeshError, match="too many nodes"):
        decode(loop.encode(), ".dae")


def test_the_child_process_returns_the_robot_or_its_error(crab, tmp_path):
    imported = import_robot(crab)
    assert imported.name == "crab"
    assert imported.text == read(crab)[2]
    with pytest.raises(RobotError, match="cannot be read") as caught:
        import_robot(tmp_path / "missing.urdf")
    assert "missing.urdf" in caught.value.where


@pytest.mark.parametrize(
    ("task", "argument", "what"),
    [
        ("os:abort", {}, "crashed"),
        ("builtins:bytearray", {"source": 2**45}, "too much memory"),
        pytest.param("signal:pause", {}, "took more than", marks=pytest.mark.slow),
    ],
)
def test_crashes_hangs_and_memory_bombs_are_reported_as_errors(monkeypatch, task, argument, what):
    monkeypatch.setattr(child, "SECONDS", 2 if what.startswith("took") else 60)
    with pytest.raises(RobotError, match=what):
        child.run_in_child(task, argument, where="a file")


def test_a_file_with_a_robots_text_is_read_as_it_is(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(bundled_text("hexapod"))
    assert import_robot(path).text == bundled_text("hexapod")

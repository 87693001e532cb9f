"""ROS 2 packages: files that parse, a URDF that gaitsim reads, and a node compiled with stubs."""

import ast
import shutil
import subprocess
from pathlib import Path
from xml.etree.ElementTree import fromstring, parse

import numpy as np
import pytest
import yaml
from c_gait import COMPILER, robot
from test_controller_sketch import walked

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.experiment import with_overrides
from gaitsim.individual import Individual
from gaitsim_hardware.ros2_package import ros_names, ros_urdf
from gaitsim_robot.organism import Robot

STUBS = Path(__file__).parent / "ros_stubs"
CXX = shutil.which("g++") or shutil.which("clang++")
STILL = "imu 1 0 0 0"


def individual(preset, **options):
    """Return an individual with reflexes, made by hand."""
    told = {"organism.reflexes": {"heading": {}}, **options}
    experiment = with_overrides(gs.load_experiment(preset), told)
    return Individual(experiment, 0.0, {}, 1, next(iter(experiment.organism.starts().values())))


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """Return a package of the hexapod."""
    folder = tmp_path_factory.mktemp("ros") / "my_hexapod"
    gs.export(individual("hexapod"), folder, "ros2-package")
    return folder


def test_files_parse_and_agree(package):
    about = parse(package / "package.xml").getroot()
    assert about.findtext("name") == "my_hexapod"
    assert "project(my_hexapod C CXX)" in (package / "CMakeLists.txt").read_text()
    ast.parse((package / "launch/gait.launch.py").read_text())
    controllers = yaml.safe_load((package / "config/controllers.yaml").read_text())
    joints = controllers["gait_controller"]["ros__parameters"]["joints"]
    assert joints == [name.replace(" ", "_") for name in Robot(model="hexapod").joint_names()]
    urdf = parse(package / "urdf/robot.urdf").getroot()
    assert [one.get("name") for one in urdf.iterfind("ros2_control/joint")] == joints
    moving = {one.get("name") for one in urdf.iterfind("joint") if one.get("type") == "revolute"}
    assert moving == {*joints}
    written = {str(one.relative_to(package)) for one in package.rglob("*") if one.is_file()}
    texts = [(package / one).read_text() for one in written]
    assert not any("@" in text.replace("nobody@example.com", "") for text in texts)


@pytest.mark.slow
@pytest.mark.sampled
@pytest.mark.parametrize("name", ["quadruped", "hexapod", "spider-physics"])
def test_the_urdf_is_the_same_robot(tmp_path, name):
    own = Robot(model=name)
    joints = ros_names(own.joint_names())
    path = tmp_path / "robot.urdf"
    path.write_text(ros_urdf(own.urdf(), joints, dict.fromkeys(joints.values(), 0.0)))
    again = Robot(model=str(path))
    assert again.joint_names() == tuple(joints.values())
    assert again.anatomy.mass == pytest.approx(own.anatomy.mass, rel=0.01)
    walk = again.move(next(iter(again.starts().values()))[None])
    assert walk["torso"][0, -1, 0] > 0.5
    assert walk["lasted"][0] == again.duration


def test_names_are_plain_and_different():
    names = ros_names(["a b", "a_b", "1", "é", "", "no\n- x", '"<&'])
    assert len({*names.values()}) == 7
    assert all(one.isascii() and one.replace("_", "").isalnum() for one in names.values())
    assert all(one[0].isalpha() for one in names.values())
    text = ros_urdf('<robot><link name="a &lt; b"/><joint name="&quot;x"/></robot>', {}, {})
    assert [one.get("name") for one in fromstring(text)][:2] == ["a_b", "x"]


def test_invalid_names_of_packages_are_refused(tmp_path):
    with pytest.raises(GaitsimError, match="invalid name for a ROS 2 package: 'My gait'"):
        gs.export(individual("hexapod"), tmp_path / "My gait", "ros2-package")


@pytest.fixture(scope="module")
def play(package, tmp_path_factory):
    """Play events to the node; return the published positions, (messages, joints) rad."""
    if CXX is None or COMPILER is None:
        pytest.skip("no C++ compiler")
    folder, source = tmp_path_factory.mktemp("node"), package / "src"
    gait, program = str(folder / "gait.o"), str(folder / "node")
    strict = ["-Wall", "-Wextra", "-Werror", f"-I{source}"]
    c = [COMPILER, "-std=c99", *strict, "-c", str(source / "gait.c"), "-o", gait]
    subprocess.run(c, check=True)
    node = [str(source / "gait_node.cpp"), gait, "-o", program]
    subprocess.run([CXX, "-std=c++17", *strict, f"-I{STUBS}", *node], check=True)

    def played(*events):
        text = "\n".join(events) + "\n"
        done = subprocess.run([program], input=text, check=True, capture_output=True, text=True)
        rows = [[float(word) for word in line.split()] for line in done.stdout.splitlines()]
        return np.array(rows)

    return played


def joint_states(angle):
    """Return an event with the same angle of all joints of the hexapod."""
    names = ros_names(Robot(model="hexapod").joint_names()).values()
    return f"joints {' '.join(f'{name} {angle}' for name in names)}"


@pytest.mark.slow
def test_the_node_rises_from_the_reported_pose_and_follows_commands(play):
    assert not len(play("step", "step"))  # it does not know where the joints are
    drive = ["twist 0.2 0 0.3", STILL, "step"] * 200
    found = play(joint_states(0.2), *["step"] * 150, *drive)
    rise = found[:150]
    assert rise[0] == pytest.approx(0.2, abs=0.001)
    assert rise[-1] == pytest.approx(Robot(model="hexapod").standing_pose(), abs=1e-9)
    assert np.abs(np.diff(rise, axis=0)).max() < 0.003
    expected = walked(*robot("hexapod", ("heading",)), np.zeros(200), (0, [0.2, 0.3, 0, 0]))
    assert np.abs(found[150:] - expected).max() < 1e-5


@pytest.mark.slow
def test_the_node_turns_by_the_imu(play):
    yaw = np.full(100, 0.2)
    yaw[0] = 0
    turned = [f"imu {np.cos(one / 2 + 0.4)} 0 0 {np.sin(one / 2 + 0.4)}" for one in yaw]
    events = [event for one in turned for event in ("twist 0.2 0 0", one, "step")]
    found = play(joint_states(0.0), *["step"] * 150, *events)
    expected = walked(*robot("hexapod", ("heading",)), yaw, (0, [0.2, 0, 0, 0]))
    assert np.abs(found[150:] - expected).max() < 1e-5


@pytest.mark.parametrize("silent", ["twist", "imu"])
def test_the_node_stops_without_commands_or_measurements(play, silent):
    drive = ["twist 0.2 0 0", STILL, "step"] * 100
    rest = [STILL if silent == "twist" else "twist 0.2 0 0", "step"] * 100
    found = play(joint_states(0.0), *["step"] * 150, *drive, *rest)
    assert np.ptp(found[200:250], axis=0).max() > 0.2
    assert np.ptp(found[-10:], axis=0).max() < 1e-9
    assert found[-1] == pytest.approx(Robot(model="hexapod").standing_pose(), abs=1e-3)

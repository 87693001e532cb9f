"""Robot files with hostile values: each gives a robot or one message, never a crash or a hang."""

import random
from pathlib import Path
from xml.etree import ElementTree

import pytest
from small_robots import QUADRUPED

from gaitsim.errors import GaitsimError
from gaitsim_robot import child
from gaitsim_robot.importing import import_robot
from gaitsim_robot.organism import Robot

DOG = Path(__file__).parents[1] / "fixtures/robots/dog_description/urdf/dog.urdf"
MORE = """<equality><joint joint1="FR_knee" joint2="FL_knee" polycoef="0 1 0 0 0"/>
<connect body1="FR_shank" body2="trunk" anchor="0 0 0" active="false"/></equality>
<actuator><position joint="FL_knee" kp="30" kv="1" gear="1" forcerange="-5 5"/></actuator>"""
TEXTS = {
    ".xml": QUADRUPED.replace("</worldbody>", f"</worldbody>{MORE}"),
    ".urdf": DOG.read_text().replace("package://dog_description/meshes/shank.dae", "foot.obj"),
}
VALUES = (
    "nan", "inf", "-1e308", "1e308", "1e-308", "1e30", "1e6", "0", "-1", "", "1e300 0 0 0",
    "1e-300 0 0 0", "nan nan nan", "0 0 0", "1e6 1e6 1e6", "1e-9 1e-9 1e-9", "2147483648",
    "1 2 3 4 5 6 7 8 9", "9" * 400, "x" * 5000, "../../../etc/passwd",
)  # fmt: skip


def changed(text, random_state):
    """Return a document in which one to four attributes have hostile values."""
    root = ElementTree.fromstring(text)
    elements = [element for element in root.iter() if element.attrib]
    for _ in range(random_state.randint(1, 4)):
        element = random_state.choice(elements)
        element.set(random_state.choice(list(element.attrib)), random_state.choice(VALUES))
    return ElementTree.tostring(root, "unicode")


@pytest.mark.slow
@pytest.mark.parametrize("suffix", TEXTS)
def test_hostile_values_give_a_robot_or_one_message(tmp_path, monkeypatch, suffix):
    monkeypatch.setattr(child, "SECONDS", 30)
    (tmp_path / "foot.obj").write_text("v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nv .1 .1 .1\n")
    random_state = random.Random(37)
    path = tmp_path / f"robot{suffix}"
    outcomes = []
    for _ in range(25):
        text = changed(TEXTS[suffix], random_state)
        path.write_text(text)
        try:
            Robot.model_validate({"model": import_robot(path).text}).describe()
            outcomes.append("robot")
        except GaitsimError as error:
            outcomes.append(error.what)
        except ValueError as error:  # of pydantic
            causes = [problem["ctx"]["error"] for problem in error.errors()]
            assert all(isinstance(cause, GaitsimError) for cause in causes), text
            outcomes.append(causes[0].what)
        assert "took more than" not in outcomes[-1], text
        assert "crashed" not in outcomes[-1], text
    assert 0 < outcomes.count("robot") < len(outcomes)

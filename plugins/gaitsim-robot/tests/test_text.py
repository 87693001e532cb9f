"""Validation of the robot's text, which allows only listed elements, attributes and values."""

from importlib.resources import files

import pytest

from gaitsim_robot.errors import RobotError
from gaitsim_robot.text import check_text, compile_model

TEXT = """<mujoco model="one">
 <compiler angle="radian"/>
 <worldbody>
  <body name="trunk"><freejoint name="trunk"/>
   <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom type="sphere" size="0.1"/>
   <body name="leg">
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <joint name="hip" axis="0 1 0" range="-1 1"/>
   </body>
  </body>
 </worldbody>
</mujoco>
"""


# MuJoCo reads the document after the PI, unlike a parser that skips text before the declaration.
HIDDEN = f"""<!-- <?xml version="1.0"?>{TEXT}<?p -->
{TEXT.replace(" <worldbody>", "<option/><worldbody>")}<!-- ?><!-- -->"""


def test_robots_texts_pass_and_compile():
    assert compile_model(TEXT).nq == 8
    assert compile_model(TEXT) is compile_model(TEXT)
    # gaitsim ignores the declared encoding, as MuJoCo does.
    check_text(f'<?xml version="1.0" encoding="cp037"?>{TEXT}')
    for name in ("quadruped", "hexapod", "spider-physics"):
        check_text((files("gaitsim_robot") / "models" / f"{name}.xml").read_text("utf-8"))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("</worldbody>", "</worldbody><include file='/etc/passwd'/>"),
        ("</worldbody>", "</worldbody><asset><mesh name='m' file='/etc/passwd'/></asset>"),
        ("</worldbody>", "</worldbody><asset><texture name='t' file='x.png'/></asset>"),
        ("</worldbody>", "</worldbody><extension><plugin plugin='mujoco.pid'/></extension>"),
        ("</worldbody>", "</worldbody><option timestep='1'/>"),
        ("</worldbody>", "</worldbody><actuator><motor joint='hip' gear='2'/></actuator>"),
        ("</worldbody>", "</worldbody><actuator><motor tendon='hip'/></actuator>"),
        ("</worldbody>", "</worldbody><actuator><motor tendon='t' gear='2'/></actuator>"),
        ("</worldbody>", "</worldbody><size memory='1T'/>"),
        ("<mujoco model", "<!DOCTYPE r [<!ENTITY a 'x'>]><mujoco model"),
        ('angle="radian"', 'angle="radian" meshdir="/etc"'),
        ('range="-1 1"', 'range="-1 nan"'),
        ('range="-1 1"', 'range="-1 1" user="-5"'),
        ('range="-1 1"', 'range="-1 1" user="5 10 -1"'),
        ('range="-1 1"', 'range="-1 1" user="5 10 1 1"'),
        ('range="-1 1"', 'range="-1 1e9"'),
        ('range="-1 1"', 'range="-1"'),
        ('range="-1 1"', 'range="1 -1"'),
        ('range="-1 1"', ""),
        ('type="sphere"', 'type="plane"'),
        ('type="sphere"', 'type="mesh"'),
        ('mass="1"', 'mass="0"'),
        ('<freejoint name="trunk"/>', ""),
        ('<body name="leg">', '<body name="leg" mocap="true">'),
        ('<body name="leg">', '<body name="leg"><frame/>'),
        ('name="leg"', 'name="trunk"'),  # rejected by MuJoCo
        ('diaginertia="1 1 1"', 'diaginertia="1 1 9"'),  # rejected by MuJoCo
        ('<geom type="sphere" size="0.1"/>', '<geom type="sphere" size="0.1"/>' * 2001),
        (TEXT, f'<?xml version="1.0" encoding="utf-16"?>{TEXT}'.encode("utf-16").decode("latin1")),
        (TEXT, ""),
        (TEXT, "<robot/>"),
        (TEXT, HIDDEN),
        (TEXT, TEXT + " " * 2**21),
    ],
)
def test_anything_else_is_refused(old, new):
    with pytest.raises(RobotError):
        compile_model(TEXT.replace(old, new, 1))

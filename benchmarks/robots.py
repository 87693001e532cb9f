"""Unmodified public robots: a verdict for each file, the resulting mass, and the repairs.

    python benchmarks/robots.py [FOLDER]

FOLDER keeps the downloaded packages; the default is a temporary folder. The reference mass is the
sum over the links in the XML of a URDF, or the mass from MuJoCo's compiler for MJCF. `alone` is the
share of the mass that MuJoCo keeps when it loads the file without gaitsim. The verdict has the legs
with their driven joints, the motors and how many the file states, passive joints, and whether the
robot stands with its own servos; it is WRONG if a joint that the file's actuators drive has no
motor, or another one has.
"""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
from public_robots import MJCF, URDF, fetch, robots

from gaitsim.errors import GaitsimError
from gaitsim_robot.importing import import_robot
from gaitsim_robot.linkage import motors
from gaitsim_robot.organism import Robot
from gaitsim_robot.text import compile_model

TOLERANCE = 0.01  # tolerance, as a share of the mass


@dataclass(frozen=True)
class LoadResult:
    """Result of loading a file: the robot's masses, kg, or the reason for its rejection."""

    mass: float = np.nan
    expected: float | None = None
    alone: float | None = None
    joints: int = 0
    size: int = 0
    repairs: tuple[str, ...] = ()
    verdict: str = ""
    warnings: tuple[str, ...] = ()
    rejected: str = ""

    @property
    def correct(self) -> bool:
        """Whether the robot loads, with the expected mass if that is known."""
        known = self.expected is None or abs(self.mass / self.expected - 1) <= TOLERANCE
        return not self.rejected and known


def main() -> None:
    """Print a table and the number of files that load, for each format."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else temporary)
        folder.mkdir(parents=True, exist_ok=True)
        unpacked = fetch(folder)
        for title, files in (("URDF", URDF), ("MJCF", MJCF)):
            print(f"\n{title:52}{'kg':>9}{'expected':>9}{'alone':>7}{'joints':>7}{'kB':>5}")
            found = []
            for path, package in robots(unpacked, files):
                found.append(load(path, package))
                print_row(str(path.relative_to(package)), found[-1])
            count = sum(not one.rejected for one in found)
            known = [one for one in found if one.expected is not None]
            correct = sum(one.correct for one in known)
            clear = sum(not (one.rejected or one.warnings) for one in found)
            print(f"{count} of {len(found)} load, {clear} without a warning", end="; ")
            print(f"of {len(known)} with known mass, {correct} are within {TOLERANCE:.0%}")


def load(path: Path, package: Path) -> LoadResult:
    """Import a file, which may refer to other files of its package."""
    try:
        imported = import_robot(path, [package])
        model = compile_model(imported.text)
        verdict, warnings = judge(path, model, Robot(model=imported.text))
    except GaitsimError as error:
        return LoadResult(rejected=f"{error.what} ({error.where.rpartition('/')[2]})")
    alone, largest = mujoco_alone(path)
    expected = largest if path.suffix == ".xml" else link_masses(path)
    return LoadResult(
        float(model.body_mass.sum()),
        expected,
        None if alone is None or not expected else alone / expected,
        int(model.njnt) - 1,
        len(imported.text) // 1000,
        imported.repairs,
        verdict,
        (*imported.warnings, *warnings),
    )


def judge(path: Path, model: mujoco.MjModel, robot: Robot) -> tuple[str, tuple[str, ...]]:
    """Return what was read of a robot, and its warnings."""
    names = [model.joint(joint).name for joint in motors(model)]
    anatomy, driven = robot.anatomy, {name.removesuffix(" pulley") for name in names}
    stated = stated_motors(path)
    wrong = stated is not None and driven != stated & {
        model.joint(i).name.removesuffix(" pulley") for i in range(model.njnt)
    }
    legs = ", ".join(f"{leg.name} {len(leg.joints)}" for leg in anatomy.legs)
    told = "none stated" if stated is None else f"{len(stated)} stated"
    return (
        f"legs {legs}; {len(driven)} motors, {told}; {len(anatomy.passive)} passive; "
        f"{'stands' if robot.simulation.stands else 'falls'}{'; WRONG MOTORS' if wrong else ''}"
    ), anatomy.warnings


def stated_motors(path: Path) -> set[str] | None:
    """Return the joints and tendons that the actuators of a file move; None if it has none."""
    root = ElementTree.fromstring(path.read_bytes().strip(b"\0 \r\n"))
    if root.tag == "robot":
        return {one.get("name", "") for one in root.iterfind("transmission/joint")} or None
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:  # gaitsim repairs what MuJoCo does not read
        return None
    names: set[str] = set()
    for kind, target in zip(model.actuator_trntype, model.actuator_trnid[:, 0], strict=True):
        if kind == mujoco.mjtTrn.mjTRN_TENDON:
            names.add(model.tendon(int(target)).name)  # of its pulley, too
        elif kind == mujoco.mjtTrn.mjTRN_JOINT:
            names.add(model.joint(int(target)).name)
    return names or None


def link_masses(path: Path) -> float:
    """Return the sum of the masses in a URDF, kg."""
    root = ElementTree.fromstring(path.read_bytes().strip(b"\0 \r\n"))
    return sum(float(mass.get("value", "0")) for mass in root.iterfind("link/inertial/mass"))


def mujoco_alone(path: Path) -> tuple[float | None, float | None]:
    """Return the total mass and the mass of the tree with the most joints, kg; None on failure."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError:
        return None, None
    joints = np.bincount(model.body_rootid, model.body_jntnum, model.nbody)
    joints[0] = -1
    trees = np.bincount(model.body_rootid, model.body_mass, model.nbody)
    return float(model.body_mass.sum()), float(trees[joints.argmax()])


def print_row(name: str, loaded: LoadResult) -> None:
    """Print a file's figures, and the repairs below them."""
    short = name if len(name) < 51 else f"…{name[-49:]}"
    if loaded.rejected:
        print(f"{short:52}rejected: {loaded.rejected}")
        return
    expected = f"{loaded.expected:.4g}" if loaded.expected else "–"
    alone = f"{loaded.alone:.0%}" if loaded.alone is not None else "no"
    mark = "" if loaded.correct else "  WRONG MASS"
    print(
        f"{short:52}{loaded.mass:9.4g}{expected:>9}{alone:>7}{loaded.joints:7}{loaded.size:5}{mark}"
    )
    print(f"    {loaded.verdict}")
    for warning in loaded.warnings:
        print(f"    WARNING: {warning[:160]}")
    for repair in loaded.repairs:
        print(f"    {repair[:110]}")


if __name__ == "__main__":
    main()

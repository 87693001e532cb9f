"""Gaits evolved by the presets, played with other contacts, servos, time steps and engines.

    python benchmarks/engines.py [--folder FOLDER] [--robots NAME …] [--seeds 20] [--first 100]

Each gait is the champion of a whole search, one for each seed from `--first` on. Three robots are
bundled and use their own presets; two public robots use the preset `robot`, unchanged, and their
packages are downloaded to FOLDER. PyBullet is skipped if it is not installed.

`plain` is MuJoCo without gaitsim: the robot's text, a plane, and position actuators with the
stiffness, damping, torque limit and armature of the servos. Contacts are as in gaitsim: an elliptic
cone with `impratio` 10.
"""

import argparse
import contextlib
import importlib.util
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from public_robots import URDF, fetch, robots

import gaitsim as gs
from gaitsim_robot.importing import import_robot
from gaitsim_robot.loading import BUNDLED
from gaitsim_robot.organism import Robot
from gaitsim_robot.simulation import FRAME_RATE, GRIP, TIPPED

PUBLIC = {
    "laikago": "laikago/laikago_toes_zup.urdf",
    "solo12": "solo_description/robots/solo12.urdf",
}
KEPT = 0.75
WORLDS: tuple[Mapping[str, float], ...] = (
    {"grip": 1.0},
    {"friction": 0.4},
    {"friction": 1.1},
    {"latency": 0.0},
    {"latency": 0.03},
    {"servo_stiffness": 0.7},
    {"servo_stiffness": 2.0},
)
STEP = 0.002  # s, of plain MuJoCo


class Walk(NamedTuple):
    """Forward distance, m, and whether the robot fell."""

    far: float
    fell: bool


def main() -> None:
    """Print a row for each gait, and for each robot the least and the median share kept."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--robots", nargs="*", default=[*BUNDLED, *PUBLIC])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=100)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        for name in arguments.robots:
            preset, changes = name, {}
            if name in PUBLIC:
                text = public_text(arguments.folder or Path(temporary), PUBLIC[name])
                preset, changes = "robot", {"organism.model": text}
            found: dict[str, list[tuple[float, bool]]] = {}
            for seed in range(arguments.first, arguments.first + arguments.seeds):
                for label, kept, fell in row(name, preset, seed, changes):
                    found.setdefault(label, []).append((kept, fell))
            print_summary(name, found)


def public_text(folder: Path, wanted: str) -> str:
    """Return the text of a public robot."""
    for path, package in robots(fetch(folder), URDF):
        if str(path).endswith(wanted):
            return import_robot(path, [package]).text
    raise SystemExit(f"not found: {wanted}")


def row(
    name: str, preset: str, seed: int, changes: dict[str, Any]
) -> Iterator[tuple[str, float, bool]]:
    """Evolve a gait, print its row, and yield what it keeps in each simulation."""
    start = time.process_time()
    with gs.evolve(preset, seed=seed, set=changes) as search:
        for _ in search:
            pass
        assert search.champion is not None
        genome = np.asarray(search.champion.genome)[None]
        body = search.experiment.organism
    assert isinstance(body, Robot)
    seconds = time.process_time() - start
    own = walk(body, genome)
    yield "own", 1.0, own.fell
    cells = []
    for label, simulate in simulations(body).items():
        other = simulate(genome)
        kept = other.far / own.far
        cells.append(f"{label} {kept:.0%}{' falls' * other.fell}")
        yield label, kept, other.fell
    fallen = " falls" * own.fell
    print(
        f"{name} {seed}: {seconds:.0f} s, {own.far:.2f} m{fallen}; {', '.join(cells)}", flush=True
    )


def simulations(body: Robot) -> dict[str, Callable[[Any], Walk]]:
    """Return functions that walk a genome in other simulations, by name."""
    changes: dict[str, dict[str, Any]] = {
        " ".join(f"{key} {value:g}" for key, value in world.items()): {"world": world}
        for world in WORLDS
    }
    changes["half step"] = {"dt": body.dt / 2}
    if importlib.util.find_spec("pybullet"):
        changes["bullet"] = {"engine": "bullet"}
    found: dict[str, Callable[[Any], Walk]] = {
        label: lambda genome, change=change: walk(body.model_copy(update=change), genome)  # type: ignore[misc]
        for label, change in changes.items()
    }
    return {**found, "plain": lambda genome: walk_plainly(body, genome)}


def walk(body: Robot, genome: Any) -> Walk:
    """Walk in one of gaitsim's simulations."""
    motion = body.move(genome)
    far = motion["torso"][0, -1, 0] - motion["torso"][0, 0, 0]
    return Walk(float(far), bool(motion["lasted"][0] < body.duration - 1e-6))


def walk_plainly(body: Robot, genome: Any) -> Walk:
    """Walk in plain MuJoCo, after standing for a second."""
    import mujoco

    commands, anatomy = body.move(genome)["joint_angles"][0], body.anatomy
    servos, rest = body.simulation.servos, body.simulation.rest
    spec = mujoco.MjSpec.from_string(body.text)
    option = spec.option
    option.timestep, option.impratio = STEP, GRIP
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for geom in spec.geoms:
        geom.friction[0] = body.friction
    floor = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    floor.friction[0] = body.friction
    for name, servo in servos.items():
        joint = spec.joint(name)
        joint.actfrclimited, joint.armature = 0, max(joint.armature, servo.armature)
        actuator = spec.add_actuator(
            name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, forcelimited=True
        )
        actuator.forcerange = [-servo.stall_torque, servo.stall_torque]
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.gainprm[0] = servo.stiffness
        actuator.biasprm[1:3] = -servo.stiffness, -servo.damping
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = anatomy.stance, rest
    mujoco.mj_step(model, data, round(1 / STEP))
    place, height = data.qpos[0], data.qpos[2]
    legs = [model.actuator(name).id for name in anatomy.joints]
    upright = data.xmat[1, 6:].copy()
    for angles in commands[:-1]:
        data.ctrl[legs] = angles
        mujoco.mj_step(model, data, round(1 / (FRAME_RATE * STEP)))
        if data.xmat[1, 6:] @ upright < TIPPED or data.qpos[2] < height / 2:
            return Walk(float(data.qpos[0] - place), True)
    return Walk(float(data.qpos[0] - place), False)


def print_summary(name: str, found: Mapping[str, list[tuple[float, bool]]]) -> None:
    """Print what the gaits of a robot keep in each simulation."""
    print(f"\n{name:20}{'worst':>8}{'median':>8}{'falls':>7}{f'≥ {KEPT:.0%}, no fall':>18}")
    for label, walks in found.items():
        kept = np.array([share for share, _ in walks])
        fell = np.array([fallen for _, fallen in walks])
        held = int(((kept >= KEPT) & ~fell).sum())
        print(
            f"{label:20}{kept.min():8.0%}{np.median(kept):8.0%}{fell.sum():7}"
            f"{f'{held} of {len(walks)}':>18}"
        )
    print(flush=True)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()

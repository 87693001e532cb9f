"""Gaits evolved in MuJoCo and played in PyBullet: the share of the distance kept, and speed.

    python benchmarks/engines.py [--folder FOLDER] [--generations 6] [--seconds 5]

The benchmark needs PyBullet (`pip install pybullet`). Three robots are bundled; the packages of two
public robots are downloaded to FOLDER. Each gait is the champion of a short search in MuJoCo with
seed 0. The two engines play it one after the other on one core; only the engine differs.
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from public_robots import URDF, fetch, robots

import gaitsim as gs
from gaitsim.gait.changed import with_body
from gaitsim_robot.importing import import_robot

BUNDLED = ("quadruped", "hexapod", "spider-physics")
PUBLIC = ("laikago/laikago_toes_zup.urdf", "solo_description/robots/solo12.urdf")
KEPT = 0.8


def main() -> None:
    """Print a row for each robot."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--generations", type=int, default=6)
    parser.add_argument("--seconds", type=float, default=5.0)
    arguments = parser.parse_args()
    print(
        f"{'robot':16}{'MuJoCo m':>10}{'Bullet m':>10}{'kept':>7}{'falls':>14}"
        f"{'× real time':>14}{'Bullet':>8}"
    )
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        overrides = {"organism.duration": arguments.seconds}
        kept = [row(name, name, overrides, arguments) for name in BUNDLED]
        for path, package in robots(fetch(folder), URDF):
            if any(str(path).endswith(one) for one in PUBLIC):
                text = import_robot(path, [package]).text
                changes = {**overrides, "organism.model": text, "organism.symmetry": "trot"}
                kept.append(row(path.stem, "robot", changes, arguments))
    print(f"{sum(share >= KEPT for share in kept)} of {len(kept)} keep at least {KEPT:.0%}")


def row(
    name: str, preset: str, overrides: dict[str, object], arguments: argparse.Namespace
) -> float:
    """Evolve a gait in MuJoCo, play it in both engines, and return the share of distance kept."""
    with gs.evolve(preset, seed=0, set=overrides) as search:
        for count, _ in enumerate(search, 1):
            if count == arguments.generations:
                break
        genomes = np.asarray(search.champion.genome)[None]
        experiment = search.experiment
    far, lasted, speeds = [], [], []
    for engine in ("mujoco", "bullet"):
        body = with_body(experiment, {"organism.engine": engine}).organism
        body.move(genomes)  # compiles the robot
        start = time.perf_counter()
        motion = body.move(genomes)
        speeds.append(float(motion["lasted"][0]) / (time.perf_counter() - start))
        far.append(float(motion["torso"][0, -1, 0] - motion["torso"][0, 0, 0]))
        lasted.append(float(motion["lasted"][0]))
    falls = [f"{last:.1f} s" if last < arguments.seconds else "none" for last in lasted]
    print(
        f"{name[:15]:16}{far[0]:10.2f}{far[1]:10.2f}{far[1] / far[0]:7.0%}{'/'.join(falls):>14}"
        f"{speeds[0]:14.0f}{speeds[1]:8.1f}",
        flush=True,
    )
    return far[1] / far[0]


if __name__ == "__main__":
    main()

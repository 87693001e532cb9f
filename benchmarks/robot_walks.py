"""Public robots, from the file to a gait: distance in 10 s, and the time to find the gait.

    python benchmarks/robot_walks.py [--folder FOLDER] [--generations 10] [--seconds 900]
                                     [--only NAME …]

Each robot uses the preset `robot` unchanged, with the torque limits of its file, if any. A search
ends after `--generations`, or after `--seconds`. FOLDER keeps the downloaded packages. The last
columns are what the gait keeps in the worst of its checks, the checks that it fails, and what it
keeps in PyBullet, if that is installed.

Processor seconds are those of this process, summed over the cores.
"""

import argparse
import contextlib
import importlib.util
import tempfile
import time
from pathlib import Path

from public_robots import MJCF, URDF, fetch, robots

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.gait import check_gait
from gaitsim.gait.changed import in_engine
from gaitsim.individual import Individual
from gaitsim_robot.importing import import_robot
from gaitsim_robot.organism import Robot

FAR = 5.0  # trunk lengths


def main() -> None:
    """Print a row for each legged robot, and how many walk."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--seconds", type=float, default=900.0)
    parser.add_argument("--generations", type=int, default=10)
    parser.add_argument("--only", nargs="*", default=[])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        unpacked = fetch(folder)
        print(
            f"{'robot':36}{'legs':>5}{'kg':>8}{'lengths':>9}{'m':>7}{'lasted':>8}{'yaw °':>7}"
            f"{'tried':>7}{'cpu s':>7}{'worst':>7}{'failed':>8}{'Bullet':>8}"
        )
        walked = held = tried = 0
        for path, package in [*robots(unpacked, URDF), *robots(unpacked, MJCF)]:
            name = f"{path.parent.name}/{path.name}"
            if arguments.only and not any(one in str(path) for one in arguments.only):
                continue
            try:
                far, holds = walk(name, path, package, arguments.generations, arguments.seconds)
            except GaitsimError as error:
                print(f"{name[-35:]:36}not loaded: {error.what}", flush=True)
                continue
            tried, walked, held = tried + 1, walked + far, held + (far and holds)
    print(
        f"{walked} of {tried} walk at least {FAR:g} lengths in 10 s without a fall; of these, "
        f"{held} hold in all checks"
    )


def walk(
    name: str, path: Path, package: Path, generations: int, time_limit: float
) -> tuple[bool, bool]:
    """Evolve a robot's gait and print its row.

    Returns:
        Whether the robot walks far enough, and whether its gait holds.
    """
    text = import_robot(path, [package]).text
    start, processor, evaluated = time.monotonic(), time.process_time(), 0
    with gs.evolve("robot", set={"organism.model": text}) as search:
        body = search.experiment.organism
        for generation in search:
            evaluated += len(generation.genomes)
            if generation.number >= generations or time.monotonic() - start > time_limit:
                break
        champion = search.champion
    assert isinstance(body, Robot)
    seconds = time.process_time() - processor
    if champion is None:
        print(f"{name[-35:]:36}no champion after {evaluated} evaluations", flush=True)
        return False, False
    checks = check_gait(champion)
    assert checks is not None
    measures = dict(champion.measures)
    print(
        f"{name[-35:]:36}{len(body.anatomy.legs):5}{body.anatomy.mass:8.3g}"
        f"{measures['body lengths']:9.1f}{measures['forward']:7.2f}{measures['lasted']:8.1f}"
        f"{measures['yaw']:7.0f}{evaluated:7}{seconds:7.0f}{checks.kept_in(checks.worst):7.0%}"
        f"{checks.passed.count(False):8}{in_bullet(champion):>8}",
        flush=True,
    )
    far = measures["body lengths"] >= FAR and measures["lasted"] >= 10.0 - 1e-6
    return far, checks.holds


def in_bullet(champion: Individual) -> str:
    """Return the share of the distance that a gait keeps in PyBullet, as text."""
    if not importlib.util.find_spec("pybullet"):
        return "–"
    try:
        measures = in_engine(champion, "bullet").measures
    except GaitsimError:
        return "refused"
    fell = " F" * (measures["lasted"] < 10.0 - 1e-6)
    return f"{measures['forward'] / champion.measures['forward']:.0%}{fell}"


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()

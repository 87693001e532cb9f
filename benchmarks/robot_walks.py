"""Public robots, from the file to a gait: distance in 10 s, and the time to find the gait.

    python benchmarks/robot_walks.py [--folder FOLDER] [--seconds 900] [--only NAME …]

Each robot uses the preset `robot` unchanged, with the torque limits of its file, if any. A search
ends with the first champion that moves five lengths of its trunk in 10 s without a fall, at the
preset's last generation, or after `--seconds`. FOLDER keeps the downloaded packages.

Processor seconds are those of this process, summed over the cores.
"""

import argparse
import contextlib
import tempfile
import time
from pathlib import Path

from public_robots import MJCF, URDF, fetch, robots

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim_robot.importing import import_robot

FAR = 5.0  # trunk lengths


def main() -> None:
    """Print a row for each legged robot, and how many walk."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--seconds", type=float, default=900.0)
    parser.add_argument("--only", nargs="*", default=[])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        unpacked = fetch(folder)
        print(
            f"{'robot':40}{'legs':>5}{'kg':>8}{'lengths':>9}{'m':>7}{'lasted':>8}{'yaw °':>7}"
            f"{'tried':>7}{'s':>6}{'cpu s':>7}"
        )
        walked = tried = 0
        for path, package in [*robots(unpacked, URDF), *robots(unpacked, MJCF)]:
            name = f"{path.parent.name}/{path.name}"
            if arguments.only and not any(one in str(path) for one in arguments.only):
                continue
            try:
                far = walk(name, path, package, arguments.seconds)
            except GaitsimError as error:
                print(f"{name[-39:]:40}not loaded: {error.what}", flush=True)
                continue
            tried, walked = tried + 1, walked + far
    print(f"{walked} of {tried} walk at least {FAR:g} lengths in 10 s without a fall")


def walk(name: str, path: Path, package: Path, time_limit: float) -> bool:
    """Evolve a robot's gait, print its row, and return whether the robot walks far enough."""
    text = import_robot(path, [package]).text
    start, processor = time.monotonic(), time.process_time()
    evaluated, seen, measures = 0, None, {"body lengths": 0.0, "lasted": 0.0}
    with gs.evolve("robot", set={"organism.model": text}) as search:
        anatomy = search.experiment.organism.anatomy  # type: ignore[attr-defined]
        for generation in search:
            evaluated += len(generation.genomes)
            if search.champion is not None and search.champion is not seen:
                seen = search.champion
                measures = dict(seen.measures)
            if is_far(measures) or time.monotonic() - start > time_limit:
                break
    row = [len(anatomy.legs), anatomy.mass, measures["body lengths"], measures.get("forward", 0.0)]
    print(
        f"{name[-39:]:40}{row[0]:5}{row[1]:8.3g}{row[2]:9.1f}{row[3]:7.2f}"
        f"{measures['lasted']:8.1f}{measures.get('yaw', 0.0):7.0f}{evaluated:7}"
        f"{time.monotonic() - start:6.0f}{time.process_time() - processor:7.0f}",
        flush=True,
    )
    return is_far(measures)


def is_far(measures: dict[str, float]) -> bool:
    """Return whether a gait covers the distance in 10 s without a fall."""
    return measures["body lengths"] >= FAR and measures["lasted"] >= 10.0 - 1e-6


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()

"""Gaits that feel: tapes and reflexes in the same worlds.

    python benchmarks/feedback.py [--folder FOLDER] [--seeds 100 101 102] [--draws 10]
                                  [--only horns ground square speed] [--file ROBOT …]

FOLDER keeps the runs of the presets, which are evolved with `--seeds` if they are missing.
`--draws` are seeds of worlds from 100 on, which no preset uses. A robot FILE evolves the preset
`robot`, as it is and with the reflex `heading`. Distances are forward; a robot falls as in
`gaitsim run`. MuJoCo's figures hold for one of its versions and one kind of processor.
"""

import argparse
import contextlib
import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from timing import print_machine, times

import gaitsim as gs
from gaitsim_robot.organism import Robot
from gaitsim_robot.rollout import LockStep, Mover
from gaitsim_robot.simulation import FRAME_RATE

Floats = NDArray[np.float64]

BODIES = {
    "spider-physics": "spider-steady",
    "hexapod": "hexapod-steady",
    "quadruped": "quadruped-steady",
}
FIRST_DRAW = 100
HORNS = 2.0  # °
SENSORS = ("mpu6050", "contacts", "load")
REFLEXES: Mapping[str, Mapping[str, Any]] = {
    "tape": {},
    "heading": {"heading": {}},
    "heading, level": {"heading": {}, "level": {}},
    "heading, contact": {"heading": {}, "contact": {}},
    "heading, phase": {"heading": {}, "phase": {}},
    "heading, level, contact": {"heading": {}, "level": {}, "contact": {}},
}


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path, default=Path("feedback-runs"))
    parser.add_argument("--seeds", type=int, nargs="+", default=[100, 101, 102])
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--only", nargs="*", default=["horns", "ground", "square", "speed"])
    parser.add_argument("--bodies", nargs="*", default=[*BODIES])
    parser.add_argument("--file", nargs="*", default=[], help="robots that nobody tuned")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print_machine()
    gaits = {}
    for tape in arguments.bodies:
        for name in (tape, BODIES[tape]):
            gaits[name] = [
                champion(arguments.folder, name, name, seed, {}) for seed in arguments.seeds
            ]
    for file in arguments.file:
        for name, reflexes in (("robot", {}), ("robot-steady", REFLEXES["heading"])):
            options = {"organism.model": file, "organism.reflexes": reflexes}
            gaits[f"{Path(file).stem}, {name}"] = [
                champion(arguments.folder, "robot", f"{Path(file).stem}-{name}", seed, options)
                for seed in arguments.seeds
            ]
    for table in arguments.only:
        {"horns": horns, "ground": ground, "square": square, "speed": speed}[table](
            gaits, arguments.draws
        )


Gait = tuple[Robot, Floats]
"""A robot and its champion's genome, (1, genes)."""
Gaits = Mapping[str, Sequence[Gait]]


def champion(folder: Path, preset: str, name: str, seed: int, options: dict[str, Any]) -> Gait:
    """Return the champion of a run, which is evolved if it is not in the folder."""
    path = folder / f"{name}-{seed}"
    if not path.exists():
        for _ in gs.evolve(preset, seed=seed, set=options, out=path):
            pass
    found = gs.load(path).champion
    body = found.experiment.organism
    assert isinstance(body, Robot)
    return body, found.genome[None]


def changed(gait: Gait, **options: Any) -> Gait:
    """Return a gait with other options of the body; without reflexes, without their genes."""
    body, genome = gait
    if options.get("reflexes") == {}:
        options["evolve"] = ()
    found = Robot.model_validate({**body.model_dump(), **options})
    return found, genome[:, : found.genome_space().genes]


def walk(gait: Gait, **options: Any) -> tuple[float, float, bool]:
    """Return the distance, m, the RMS yaw, °, and whether the robot stays up."""
    body, genome = changed(gait, **options)
    motion = body.move(genome)
    yaw = np.degrees(motion["orientation"][0, :, 2])
    upright = motion["lasted"][0] >= body.duration - 1e-6
    return float(motion["torso"][0, -1, 0]), float(np.sqrt(np.mean(yaw**2))), bool(upright)


def horns(gaits: Gaits, draws: int) -> None:
    """Print heading and distance with errors of all joints, with reflexes and without."""
    print(f"## Horn errors of {HORNS:g}° SD, {draws} draws for each champion\n")
    print(
        "| preset | reflexes | seeds | RMS yaw, °: median, most | way kept: median, least | fell |"
    )
    print("| --- | --- | --- | --- | --- | --- |")
    for name, champions in gaits.items():
        for blind in (False, True) if champions[0][0].reflexes else (True,):
            yaws, kept, falls = [], [], 0
            for gait in champions:
                own = {"reflexes": {}} if blind else {}
                far, _, _ = walk(gait, **own)
                for seed in range(FIRST_DRAW, FIRST_DRAW + draws):
                    world = {"joint_offset": HORNS, "seed": float(seed)}
                    distance, yaw, upright = walk(gait, world=world, **own)
                    yaws.append(yaw)
                    kept.append(distance / far)
                    falls += not upright
            reflexes = "none" if blind else ", ".join(champions[0][0].reflexes)
            print(
                f"| {name} | {reflexes} | {len(champions)} | "
                f"{np.median(yaws):.1f}, {np.max(yaws):.1f} | "
                f"{np.median(kept):.0%}, {np.min(kept):.0%} | {falls} of {len(yaws)} |",
                flush=True,
            )
    print()


def ground(gaits: Gaits, draws: int) -> None:
    """Print the share without falls and the distance on uneven ground, slopes and with pushes."""
    print(f"## Pushes and ground, {draws} draws for each champion: distance, m; falls in %\n")
    for name, champions in gaits.items():
        if not champions[0][0].reflexes:
            continue
        body = champions[0][0]
        legs = float(np.mean([leg.length for leg in body.anatomy.legs]))
        worlds = {
            "level": {},
            "push 0.5 m/s": {"push": 0.5},
            "push 1 m/s": {"push": 1.0},
            "10° up": {"slope": 10.0},
            "10° aside": {"side_slope": 10.0},
            "steps": {"steps": 0.15 * legs},
            "rubble": {"rubble": 0.15 * legs},
        }
        mass = body.anatomy.mass
        print(f"{name}: 1 m/s is {mass:.2f} N s; steps and rubble {150 * legs:.0f} mm\n")
        print(f"| reflexes | {' | '.join(worlds)} |\n| --- |{' --- |' * len(worlds)}")
        own = {"as evolved": body.reflexes}
        for label, reflexes in {**REFLEXES, **own}.items():
            cells = []
            for world in worlds.values():
                found = [
                    walk(
                        gait,
                        reflexes=reflexes,
                        sensors=SENSORS,
                        world={**world, "seed": float(seed)},
                    )
                    for gait in champions
                    for seed in range(FIRST_DRAW, FIRST_DRAW + (draws if world else 1))
                ]
                falls = np.mean([not upright for _, _, upright in found])
                cells.append(f"{np.median([one[0] for one in found]):.2f}; {falls:.0%}")
            print(f"| {label} | {' | '.join(cells)} |", flush=True)
        print()


SIDE = 1.0  # m


def square(gaits: Gaits, draws: int) -> None:
    """Print how closely robots follow a square, turn on the spot, and stop."""
    print("## A square of 1 m: farthest from a corner, m; turning on the spot; stopping\n")
    print(
        "| preset | seed | blind commands | a driver who sees the robot | turn, °/s (true, limit) "
        "| way after the command to stop, m (and a stride) |"
    )
    print("| --- | --- | --- | --- | --- | --- |")
    for name, champions in gaits.items():
        if not champions[0][0].reflexes:
            continue
        for number, (uncalibrated, genome) in enumerate(champions):
            body = uncalibrated.calibrated(genome[0])
            rhythm = body.pilot(genome).rhythm
            most = rhythm.limits[0]
            pace, turn = 0.7 * most[0], min(0.5 * most[1], math.radians(60))
            blind = followed(body, genome, timed_square(pace, turn))
            seen = followed(body, genome, None, pace=pace, turn=turn)
            spot, _ = driven(body, genome, [{"at": 0.0, "turn": math.degrees(most[1])}], 6.0)
            rate = (spot[-1, 2] - spot[100, 2]) / (len(spot) - 101) * FRAME_RATE
            stop, _ = driven(
                body, genome, [{"at": 0.0, "speed": pace}, {"at": 5.0, "speed": 0.0}], 8.0
            )
            way = math.dist(stop[250, :2], stop[-1, :2])
            stride = pace / float(rhythm.frequency[0])
            print(
                f"| {name} | {number} | {blind:.2f} | {seen:.2f} | {math.degrees(rate):.0f}, "
                f"{math.degrees(most[1]):.0f} | {way:.3f} ({stride:.3f}) |",
                flush=True,
            )
    print()


def timed_square(pace: float, turn: float) -> list[dict[str, float]]:
    """Return a drive along a square to the left, by time alone."""
    drive: list[dict[str, float]] = []
    at = 0.0
    for _ in range(4):
        drive.append({"at": at, "speed": pace, "turn": 0.0})
        at += SIDE / pace
        drive.append({"at": at, "speed": 0.0, "turn": math.degrees(turn)})
        at += math.pi / 2 / turn
    drive.append({"at": at, "turn": 0.0})
    return drive


def driven(
    body: Robot, genome: Floats, drive: Sequence[Mapping[str, float]], seconds: float
) -> tuple[Floats, bool]:
    """Return x, y and yaw in each frame, (frames, 3), and whether the robot stays up."""
    found = Robot.model_validate({**body.model_dump(), "drive": drive, "duration": seconds})
    motion = found.move(genome)
    place = np.concatenate([motion["torso"][0, :, :2], motion["orientation"][0, :, 2:]], axis=1)
    return place, bool(motion["lasted"][0] >= seconds - 1e-6)


CORNERS = np.array([[SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE], [0.0, 0.0]])
LONGEST = 60.0  # s


def followed(
    body: Robot,
    genome: Floats,
    drive: Sequence[Mapping[str, float]] | None,
    *,
    pace: float = 0.0,
    turn: float = 0.0,
) -> float:
    """Return the largest distance from a corner when the robot is closest to it, m.

    Without a drive, a driver who sees the robot turns it towards the next corner, and then walks.
    """
    if drive is not None:
        place, _ = driven(body, genome, drive, min(drive[-1]["at"] + 2.0, LONGEST))
        quarter = [one["at"] for one in drive if one.get("turn")]
        at = [min(round(when * FRAME_RATE), len(place) - 1) for when in quarter]
        return max(
            math.dist(place[frame, :2], corner) for frame, corner in zip(at, CORNERS, strict=True)
        )
    frames = round(LONGEST * FRAME_RATE)
    target = np.zeros((1, frames, 4))
    simulation = body.simulation
    walk = LockStep(simulation, body.pilot(genome), target, Mover(simulation, 1))
    corner, worst, nearest = 0, 0.0, math.inf
    for frame in range(frames - 1):
        state = walk.mover.state[0]
        place = state[1:3] - simulation.start[1:3]
        away = CORNERS[corner] - place
        far = float(np.hypot(*away))
        nearest = min(nearest, far)
        if far < 0.05 or (far > nearest + 0.03 and nearest < 0.3):
            worst, nearest, corner = max(worst, nearest), math.inf, corner + 1
            if corner == len(CORNERS):
                return worst
            continue
        w, x, y, z = simulation.turn(state[4:8])
        yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        error = (math.atan2(away[1], away[0]) - yaw + math.pi) % (2 * math.pi) - math.pi
        target[0, frame] = (
            (0.0, math.copysign(turn, error), 0.0, 0.0)
            if abs(error) > 0.35
            else (pace, np.clip(2 * error, -turn, turn), 0.0, 0.0)
        )
        walk.advance(np.array([0]), frame, frame + 1)
    return max(worst, nearest)


def speed(gaits: Gaits, draws: int) -> None:
    """Print the time of a rollout with reflexes and as a tape, in turns."""
    print("## Time of a rollout of 12 robots, in turns\n")
    for name, champions in gaits.items():
        body, genome = champions[0]
        if not body.reflexes:
            continue
        tape, own = changed((body, genome), reflexes={})
        both = [(body, np.tile(genome, (12, 1))), (tape, np.tile(own, (12, 1)))]
        taken: list[list[float]] = [[], []]
        for _ in range(4):
            for (robot, genomes), seconds in zip(both, taken, strict=True):
                start = time.perf_counter()
                robot.move(genomes)
                seconds.append(time.perf_counter() - start)
        felt, blind = (min(seconds) for seconds in taken)
        print(
            f"{name}: {1000 * felt / 12:.1f} ms, tape {1000 * blind / 12:.1f} ms an individual; "
            f"speed {times(blind / felt)} of the tape's"
        )
    print()


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()

"""Adaptation of the spider to the loss of each leg and each pair of legs, in rigid-body physics.

The benchmark evolves atlases in kinematics with ten seeds that were not used for tuning. Atlases in
FOLDER are reused. Trials run on the damaged twin `spider-physics`. Baselines: the champion of the
atlas, random gaits from the atlas, a hand-made tetrapod gait, a hand-made gait of the remaining
legs, and evolution from scratch on the damaged body. It takes 40 minutes on two cores,
most of it physics. If it is interrupted, start it again to continue.

    python benchmarks/adaptation.py FOLDER [--seeds 10] [--generations 400]
"""

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

import gaitsim as gs
from gaitsim.experiment import load_experiment
from gaitsim.gait import play_on_twin
from gaitsim.gait.changed import damage_body
from gaitsim.gait.gait_files import GaitFile, play_gait
from gaitsim_adaptation.report import AdaptationReport, Case, leg_losses
from gaitsim_adaptation.settings import AdaptationSettings

SETTINGS = AdaptationSettings()
LEGS = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
SEGMENTS = ("coxa", "femur", "tibia")
FROM_SCRATCH = (("L1",), ("L3",), ("L1", "L2"), ("L2", "L3"))  # losses evolved from scratch
EVALUATIONS = (30, 300, 3_000, 10_000)  # after which gaits from scratch are tested


def kind_of_loss(legs: Sequence[str]) -> str:
    """Return the kind of loss, such as 'adjacent pair'."""
    if len(legs) == 1:
        return "one leg"
    (side, place), (other, next_place) = legs
    if side == other:
        return "adjacent pair" if abs(int(place) - int(next_place)) == 1 else "pair of one side"
    return "opposite pair" if place == next_place else "pair of both sides"


def lost_legs(case: Case) -> list[str]:
    """Return the lost legs of a case."""
    return [text.removesuffix(" lost") for text in case.damage]


def hand_made_distance(left: Sequence[str], damage: Sequence[str]) -> float:
    """Return the forward distance of a hand-made gait on the damaged twin, m.

    The gait has 1.2 Hz, coxa angles of ±20° and a lift of 14°. Neighbouring legs of a side
    alternate, as do the left and the right leg of a pair.

    Args:
        left: remaining legs, front to back, which alternate in this order.
        damage: damage to the twin.
    """
    turn = {
        leg: at for side in "LR" for at, leg in enumerate(one for one in left if one[0] == side)
    }
    phase = 2 * np.pi * 1.2 * np.arange(300)[:, None] / 30.0 + np.pi * np.array(
        [turn.get(leg, 0) + (leg[0] == "R") for leg in LEGS]
    )
    angles = np.zeros((300, 8, 3))
    angles[:, :, 0] = -20 * np.cos(phase)
    angles[:, :, 1] = 14 * np.maximum(np.sin(phase), 0)
    names = tuple(f"{leg} {segment}" for leg in LEGS for segment in SEGMENTS)
    gait = GaitFile(Path("by-hand"), np.radians(angles.reshape(300, 24)), 30.0, names)
    twin = load_experiment("spider-physics")
    return play_gait(gait, damage_body(twin, damage) if damage else twin).measures["forward"]


def evolve_from_scratch(legs: Sequence[str], seed: int) -> list[float]:
    """Return the distances in physics of gaits that CMA-ES evolves on the damaged body.

    Returns:
        Forward distance of the champion after each number of evaluations in `EVALUATIONS`, m.
    """
    damage = [f"{leg} lost" for leg in legs]
    given = {
        "search.start": "random",
        "organism.symmetry": "none",
        "organism.damage": damage,
        "evolution.population": 30,
    }
    found: list[float] = []
    generations = EVALUATIONS[-1] // 30 + 1
    with gs.evolve("spider", seed=seed, generations=generations, set=given) as search:
        for generation in search:
            if generation.number * 30 >= EVALUATIONS[len(found)]:
                found.append(play_on_twin(search.champion).measures["forward"])
    return found


def quartiles(values: Iterable[float], scale: float = 100) -> str:
    """Format the median and the quartiles of values, multiplied by `scale`."""
    low, middle, high = np.quantile(np.array([*values]) * scale, (0.25, 0.5, 0.75))
    return f"{middle:.0f} ({low:.0f}–{high:.0f})"


def make_reports(
    folder: Path, seeds: int, generations: int, *, physics: bool
) -> list[AdaptationReport]:
    """Evolve the missing atlases, and create or continue their reports."""
    reports = []
    for seed in range(seeds):
        path = folder / f"atlas-{seed}"
        if not path.exists():
            for _ in gs.evolve("spider-atlas", seed=seed, generations=generations, out=path):
                pass
        name = f"{'physics' if physics else 'kinematics'}-{seed}"
        run = gs.load(path)
        reports.append(
            gs.adaptation_report(run, folder / name, pairs=True, physics=physics, settings=SETTINGS)
        )
        print(
            f"{name}: {len(run.members.scores):,} gaits, best {reports[-1].best:.2f} m", flush=True
        )
    return reports


def print_table(reports: Sequence[AdaptationReport]) -> None:
    """Print shares and numbers of trials for each kind of loss, over all seeds."""
    print("\n| lost | trials | kept, % | slowest, % | champion, % | random, % |")
    print("| --- | --- | --- | --- | --- | --- |")
    every = [(report, case) for report in reports for case in report.cases]
    for kind in dict.fromkeys(kind_of_loss(lost_legs(case)) for _, case in every):
        some = [(report, case) for report, case in every if kind_of_loss(lost_legs(case)) == kind]

        def shares(
            of: Callable[[Case], float], some: list[tuple[AdaptationReport, Case]] = some
        ) -> list[float]:
            return [report.kept(of(case)) for report, case in some]

        kept = shares(lambda case: case.best.measured)
        cells = (
            f"{kind} ({len(some)})",
            quartiles((len(case.trials) for _, case in some), 1),
            quartiles(kept),
            f"{100 * min(kept):.0f}",
            quartiles(shares(lambda case: case.champion)),
            quartiles(shares(lambda case: max(case.random))),
        )
        print(f"| {' | '.join(cells)} |")


def print_by_damage(reports: Sequence[AdaptationReport]) -> None:
    """Print medians over the seeds for each damage, and the distances of hand-made gaits."""
    intact = float(np.median([report.best for report in reports]))
    whole = hand_made_distance(LEGS, ())
    print(f"\nbest gait of the atlases on the intact twin {intact:.2f} m; tetrapod {whole:.2f} m")
    print("\n| lost | trials | kept, % | m | champion, % | random, % | tetrapod, m | by hand, m |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for at, case in enumerate(reports[0].cases):
        same, legs = [report.cases[at] for report in reports], lost_legs(case)
        left = [leg for leg in LEGS if leg not in legs]
        both = list(zip(reports, same, strict=True))
        cells = (
            case.name,
            f"{np.median([len(one.trials) for one in same]):g}",
            quartiles(report.kept(one.best.measured) for report, one in both),
            f"{np.median([one.best.measured for one in same]):.2f}",
            quartiles(report.kept(one.champion) for report, one in both),
            quartiles(report.kept(max(one.random)) for report, one in both),
            f"{hand_made_distance(LEGS, case.damage):.2f}",
            f"{hand_made_distance(left, case.damage):.2f}",
        )
        print(f"| {' | '.join(cells)} |", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument(
        "--generations", type=int, default=400, help="number of generations of 1,000 gaits"
    )
    given = parser.parse_args()
    assert len(leg_losses(load_experiment("spider"), pairs=True)) == 36
    print_table(make_reports(given.folder, given.seeds, given.generations, physics=False))
    reports = make_reports(given.folder, given.seeds, given.generations, physics=True)
    print_table(reports)
    print_by_damage(reports)
    print(
        f"\nevolution from scratch, CMA-ES, m in physics after {EVALUATIONS} evaluations, 3 seeds"
    )
    for legs in FROM_SCRATCH:
        found = np.array([evolve_from_scratch(legs, seed) for seed in range(3)])
        print(
            f"| {' + '.join(legs)} | {' | '.join(f'{one:.2f}' for one in np.median(found, 0))} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

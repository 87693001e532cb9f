"""Adaptation of the spider beyond its atlas, in three simulators, and of robots of another scale.

For the loss of each leg and each adjacent pair, up to 20 trials: gaits of the atlas, then changes
of the best. The simulators are the kinematic body and its twin in MuJoCo, each with unknown and
with visible damage, and the twin in PyBullet with visible damage, until a gait walks. Then, in
kinematics, the number of trials of robots that walk 40 to 150 % as far as the simulation. Atlases
and results in FOLDER, made with `adaptation.py` or here, are reused. If it is interrupted, start it
again to continue.

    python benchmarks/adaptation_trials.py FOLDER [--seeds 10] [--generations 400]
"""

import argparse
import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from adaptation import kind_of_loss

import gaitsim as gs
from gaitsim.experiment import with_overrides
from gaitsim.gait.changed import play_on, twin_of
from gaitsim.gait.report import frames_before_fall
from gaitsim.individual import Individual
from gaitsim_adaptation.adaptation import Adaptation
from gaitsim_adaptation.prior import Prior, performance_of, read_prior
from gaitsim_adaptation.report import leg_losses
from gaitsim_adaptation.settings import MOST_TRIALS, AdaptationSettings
from gaitsim_adaptation.trials import (
    MeasureGait,
    Trial,
    measure_intact,
    simulated_robot,
    transfer_map,
)

OF_MAP = 5  # the most trials of gaits of the map
COUNTS = {  # all trials, at most; in PyBullet, a gait takes four seconds
    "kinematics": 20,
    "twin": 20,
    "kinematics-visible": 10,
    "twin-visible": 10,
    "bullet": 4,
}
SCALES = (1.0, 0.4, 0.6, 0.8, 1.5)
WALKS = 1.25  # m in 10 s, of a gait that walks in PyBullet


def losses(prior: Prior) -> list[tuple[str, ...]]:
    """Return the loss of each leg and of each adjacent pair."""
    every = leg_losses(prior.experiment, pairs=True)
    return [one for one in every if kind_of(one) in ("one leg", "adjacent pair")]


def kind_of(damage: Sequence[str]) -> str:
    """Return the kind of loss; '' for none."""
    return kind_of_loss([text.removesuffix(" lost") for text in damage]) if damage else "none"


def robot_in(simulator: str, prior: Prior, damage: Sequence[str]) -> MeasureGait:
    """Return a function that measures gaits in a simulator; in PyBullet, a fall is 0 m."""
    if simulator != "bullet":
        return simulated_robot(prior.experiment, damage, physics=simulator.startswith("twin"))
    body = with_overrides(twin_of(prior.experiment, damage), {"organism.engine": "bullet"})

    def measure(gait: Individual) -> float:
        found = play_on(gait, body)
        fell = frames_before_fall(found) < len(found.skeleton.path)
        return 0.0 if fell else float(performance_of(body, found.motion, "forward")[0])

    return measure


def try_gaits(
    prior: Prior,
    measure: MeasureGait,
    count: int,
    enough: float,
) -> list[Trial]:
    """Return trials of the atlas and of changes of the best, until one measures `enough`."""
    settings = AdaptationSettings(trials=OF_MAP, refine=MOST_TRIALS)
    trials: list[Trial] = []
    for trial in islice(Adaptation.unsaved(prior, measure, settings), count):
        trials.append(trial)
        if trial.measured >= enough:
            break
    return trials


def measure_losses(run: gs.Run, simulator: str) -> dict[str, Any]:
    """Return the trials after each loss, and the best of the map on the intact body."""
    prior, measured = read_prior(run.snapshot), dict[int, float]()
    enough = WALKS if simulator == "bullet" else math.inf
    visible = simulator not in ("kinematics", "twin")
    with ThreadPoolExecutor(2) as pool:
        if simulator.startswith("twin"):
            intact = simulated_robot(prior.experiment, (), physics=True)
            measured = measure_intact(run.snapshot, prior, intact, pool)

        def known_map(damage: Sequence[str]) -> Prior:
            found = read_prior(run.snapshot, damage=damage)
            return transfer_map(found, measured) if measured else found

        def case(damage: tuple[str, ...]) -> dict[str, Any]:
            robot = robot_in(simulator, prior, damage)
            known = known_map(damage) if visible else whole
            trials = try_gaits(known, robot, COUNTS[simulator], enough)
            of_map = [trial for trial in trials if not trial.genome]
            values = [trial.measured for trial in trials]
            return {"damage": damage, "map": len(of_map), "measured": values}

        whole = known_map(())
        # PyBullet holds the interpreter's lock, so its threads only take turns.
        cases = [*pool.map(case, losses(prior))]
    return {"best": whole.best, "cases": cases}


def measure_scales(run: gs.Run) -> dict[str, Any]:
    """Return the number of trials and the kept share for each loss and scale in kinematics."""
    prior, found = read_prior(run.snapshot), []
    for damage in [(), *losses(prior)]:
        robot = simulated_robot(prior.experiment, damage)
        for scale in (None, *SCALES):
            factor = 1.0 if scale is None else scale
            settings = AdaptationSettings(scale=1.0 if scale is None else None)

            def measure(gait: Individual, robot: MeasureGait = robot, by: float = factor) -> float:
                return by * robot(gait)

            trials = [*Adaptation.unsaved(prior, measure, settings)]
            best = max(trial.measured for trial in trials) / factor / prior.best
            found.append({"damage": damage, "scale": scale, "trials": len(trials), "kept": best})
    return {"cases": found}


def stored(path: Path, compute: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return the result in a file; compute and store it if the file does not exist."""
    if not path.exists():
        path.write_text(json.dumps(compute()))
        print(f"{path.name} is done", flush=True)
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def print_losses(simulator: str, results: Sequence[dict[str, Any]]) -> None:
    """Print medians over losses and atlases, by the kind of loss."""
    best = np.median([result["best"] for result in results])
    print(f"\n{simulator}: {len(results)} atlases, best of the map {best:.2f} m")
    last = COUNTS[simulator]
    print(f"| lost (cases) | trials of the map | after 3, % | the map, % | after {last}, % | m |")
    print("| --- | --- | --- | --- | --- | --- |")
    for kind in ("one leg", "adjacent pair"):
        cases = [
            (one, result["best"])
            for result in results
            for one in result["cases"]
            if kind_of(one["damage"]) == kind
        ]

        def after(count: int | None, cases: list[Any] = cases) -> str:
            shares = [
                max(one["measured"][: one["map"] if count is None else count]) / best
                for one, best in cases
            ]
            low, middle, high = np.quantile(shares, (0.25, 0.5, 0.75))
            return f"{100 * middle:.0f} ({100 * low:.0f}–{100 * high:.0f})"

        metres = np.median([max(one["measured"]) for one, _ in cases])
        trials = np.median([one["map"] for one, _ in cases])
        cells = (f"{kind} ({len(cases)})", f"{trials:g}", after(3), after(None), after(last))
        print(f"| {' | '.join(cells)} | {metres:.2f} |")
    if simulator == "bullet":
        for at, case in enumerate(results[0]["cases"]):
            every = [result["cases"][at]["measured"] for result in results]
            walked = [len(values) for values in every if max(values) >= WALKS]
            print(
                f"{', '.join(case['damage'])}: {len(walked)} of {len(every)} walk, after "
                f"{max(walked, default=0)} trials or fewer"
            )


def print_scales(results: Sequence[dict[str, Any]]) -> None:
    """Print the median number of trials and the kept share by scale and kind of loss."""
    cases = [one for result in results for one in result["cases"]]
    kinds = ("none", "one leg", "adjacent pair")
    print("\nkinematics, trials and kept share in %, medians")
    print(f"| scale | {' | '.join(kinds)} |\n| --- | {' | '.join('---' for _ in kinds)} |")
    for scale in (None, *SCALES):
        cells = ["1, known" if scale is None else f"{scale:g}, estimated"]
        for kind in kinds:
            some = [
                one for one in cases if one["scale"] == scale and kind_of(one["damage"]) == kind
            ]
            trials, kept = (np.median([one[name] for one in some]) for name in ("trials", "kept"))
            cells.append(f"{trials:g}, {100 * kept:.0f}")
        print(f"| {' | '.join(cells)} |")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--generations", type=int, default=400, help="of 1,000 gaits")
    parser.add_argument("--simulators", nargs="*", default=[*COUNTS])
    given = parser.parse_args()
    runs = []
    for seed in range(given.seeds):
        path = given.folder / f"atlas-{seed}"
        if not path.exists():
            for _ in gs.evolve("spider-atlas", seed=seed, generations=given.generations, out=path):
                pass
        runs.append(gs.load(path))
    scales = [
        stored(given.folder / f"scales-{seed}.json", lambda run=run: measure_scales(run))  # type: ignore[misc]
        for seed, run in enumerate(runs)
    ]
    print_scales(scales)
    for simulator in given.simulators:
        results = [
            stored(
                given.folder / f"trials-{simulator}-{seed}.json",
                lambda run=run, simulator=simulator: measure_losses(run, simulator),  # type: ignore[misc]
            )
            for seed, run in enumerate(runs)
        ]
        print_losses(simulator, results)


if __name__ == "__main__":
    main()

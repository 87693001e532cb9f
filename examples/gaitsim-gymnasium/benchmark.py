"""Returns after a number of episodes, beside published ones. Start it again to continue.

python benchmark.py FOLDER [--only oscillators-Swimmer-v5] [--seeds 10]
"""

import argparse
from pathlib import Path

import numpy as np

import gaitsim as gs

# Case: preset, individuals, generations, published return. Gains of the oscillators, and initial
# weights and covariance of linear policies were chosen on seed 100.
CASES = {
    "oscillators-Swimmer-v5": ("gymnasium", 16, 40, "351, Raffin et al. 2024"),
    "oscillators-HalfCheetah-v5": ("gymnasium", 16, 125, "3960, Raffin et al. 2024"),
    "linear-Swimmer-v5": ("gymnasium-linear", 16, 40, "325, reached by Mania et al. 2018"),
    "linear-Hopper-v5": ("gymnasium-linear", 20, 60, "3120, reached by Mania et al. 2018"),
    "linear-HalfCheetah-v5": ("gymnasium-linear", 20, 50, "3430, reached by Mania et al. 2018"),
    "linear-Walker2d-v5": ("gymnasium-linear", 20, 100, "4390, reached by Mania et al. 2018"),
}


def best_return(folder: Path, case: str, seed: int) -> float:
    """Return the champion's return in episode seeds that no search has seen."""
    preset, population, generations, _ = CASES[case]
    path = folder / f"{case}-{seed}"
    options = {"organism.env": case.partition("-")[2]}
    if path.exists():
        every = gs.load(path).resume(generations=generations)
    else:
        every = gs.evolve(
            preset,
            seed=seed,
            population=population,
            generations=generations,
            set=options,
            out=path,
            workers=1,
        )
    for _ in every:
        pass
    champion = gs.load(path).champion
    body = champion.experiment.organism
    unseen = [
        body.model_copy(update={"world": {"seed": float(seed)}}).move(champion.genome[None])
        for seed in range(1000, 1010)
    ]
    return float(np.mean([motion["return"][0] for motion in unseen]))


def main() -> None:
    """Print a line for each case and seed, and a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", default=[*CASES])
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    for case in given.only:
        _, population, generations, published = CASES[case]
        found = []
        for seed in range(given.seeds):
            found.append(best_return(given.folder, case, seed))
            print(f"{case}, seed {seed}: {found[-1]:.0f}", flush=True)
        low, middle, high = np.quantile(found, (0, 0.5, 1))
        print(
            f"| {case} | {population * generations} | {middle:.0f} ({low:.0f} to {high:.0f}, "
            f"{len(found)} seeds) | {published} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

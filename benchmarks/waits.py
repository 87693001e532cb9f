"""Waits of a user: for the first kernels, a step of `ask` and `tell`, pictures of an atlas.

    python benchmarks/waits.py [ATLAS]

ATLAS is a run of spider-atlas with 300 generations; without it, one is evolved first.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from timing import print_budget, print_machine

import gaitsim as gs
from gaitsim.contracts import RealSpace

COMPILED, STEP, PICTURE = 4.0, 60e-6, 5.0  # budgets, s
STEPS, POPULATION = 2_000, 10
MOTIONS = "export", "--format", "motion", "--population", "every 100"


def main() -> None:
    """Print each wait beside its budget."""
    print_machine()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        atlas = Path(sys.argv[1]) if len(sys.argv) > 1 else folder / "atlas"
        if not atlas.exists():
            run("run", "spider-atlas", "--generations", "300", "--out", str(atlas))
        print_budget("kernels of a first run", compiling(folder), COMPILED, seconds)
        print_budget(
            "ask and tell, an evaluation of a population of 10",
            steps(),
            STEP,
            lambda time: f"{1e6 * time:.0f} µs",
        )
        picture = str(folder / "plot.png")
        for kind in ("gaits", "parallel"):
            took = run("plot", str(atlas), "--kind", kind, "--out", picture)
            print_budget(f"plot --kind {kind} of an atlas", took, PICTURE, seconds)
        motions = str(folder / "motions.npz")
        took = run(*MOTIONS, "--out", motions, str(atlas))
        print_budget("export --population 'every 100' of an atlas", took, PICTURE, seconds)


def compiling(folder: Path) -> float:
    """Return by how long the first start is longer than the second, s."""
    command = ("run", "spider", "--generations", "2", "--out")
    kernels = {"NUMBA_CACHE_DIR": str(folder / "kernels")}
    first, second = (run(*command, str(folder / name), **kernels) for name in ("one", "two"))
    return first - second


def steps() -> float:
    """Return the time of `ask` and `tell` for each genome, s; the least of five."""
    least = float("inf")
    for _ in range(5):
        space = RealSpace(np.full(10, -5.0), np.full(10, 5.0))
        search = gs.Optimiser(space, population=POPULATION, seed=0)
        start = time.perf_counter()
        for _ in range(STEPS // POPULATION):
            genomes = search.ask()
            search.tell(-(genomes**2).sum(axis=1))
        least = min(least, (time.perf_counter() - start) / STEPS)
    return least


def run(*arguments: str, **environment: str) -> float:
    """Run a command of gaitsim, and return its time, s."""
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "gaitsim", *arguments],
        env=os.environ | environment,
        check=True,
        capture_output=True,
    )
    return time.perf_counter() - start


def seconds(time: float) -> str:
    """Format a time."""
    return f"{time:.1f} s"


if __name__ == "__main__":
    main()

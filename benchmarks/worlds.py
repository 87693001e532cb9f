"""Gaits evolved in several worlds and in one world, compared in unseen worlds.

    python benchmarks/worlds.py [--full] [--only NAME …] [--seeds 11 12 13] [--folder FOLDER]

Each champion of several worlds is compared with the champion of one world with the same seed. Both
walk in the same unseen worlds. For the robots: friction 0.3 to 1.1, masses up to +32 % (0.6 kg on
the hexapod), latency 0 to 60 ms, torque of the servos 60 to 100 %, slopes of ±5° forward and to the
side. For the walkers: friction 0.3 to 1.2, masses ±20 %, latency 0 to 50 ms, torque and speed of
the servos 70 to 100 %, slope ±3°. The budget of a search is the number of simulations: individuals
times worlds.

The default of one seed, two generations and ten worlds only demonstrates the table. `--full` uses
the presets' generations, seeds 11, 12 and 13 unless others are given, and 100 worlds, and takes
about an hour of processor time. FOLDER keeps the runs; runs that exist in it are tested without
evolving them.
"""

import argparse
import contextlib
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import gaitsim as gs
from gaitsim.gait.worlds import UnseenResults, evaluate_unseen

RANGES = {
    "friction": (0.3, 1.2),
    "mass": (0.8, 1.2),
    "latency": (0.0, 0.05),
    "servo_torque": (0.7, 1.0),
    "servo_speed": (0.7, 1.0),
    "slope": (-3.0, 3.0),
}
WIDE = {
    "friction": (0.3, 1.1),
    "mass": (1.0, 1.32),
    "latency": (0.0, 0.06),
    "servo_torque": (0.6, 1.0),
    "slope": (-5.0, 5.0),
    "side_slope": (-5.0, 5.0),
}
OVER_WORLDS: dict[str, tuple[str, dict[str, Any]]] = {
    "quadruped": ("quadruped-worlds", {}),
    "hexapod": ("hexapod-worlds", {}),
    "walker-four": ("walker-worlds", {}),
    "walker": (  # two legs: has no preset over worlds, as it falls in most worlds
        "walker",
        {"worlds.number": 3, "worlds.ranges": {name: [*ends] for name, ends in RANGES.items()}},
    ),
}
"""Preset of one world -> the preset over worlds, and its other options."""

TITLES = (
    f"{'evolved in':>11}{'seed':>6}{'simulations':>13}{'nominal m':>11}{'median m':>10}"
    f"{'worst tenth m':>15}{'of its nominal':>16}{'of one world’s':>16}{'falls':>7}  sensitive to"
)


class Row(NamedTuple):
    """A champion: the simulations of its search, and its results in unseen worlds."""

    simulations: int
    unseen: UnseenResults
    of_one: float

    @property
    def kept(self) -> float:
        """Return the mean of the worst tenth of distances, as a share of the nominal distance."""
        return self.unseen.worst_tenth / self.unseen.nominal.result


def main() -> None:
    """Print a row for each champion, and the median and range of each kind over seeds."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--only", nargs="*", default=[*OVER_WORLDS], choices=[*OVER_WORLDS])
    parser.add_argument("--seeds", nargs="*", type=int)
    parser.add_argument("--folder", type=Path)
    arguments = parser.parse_args()
    seeds = arguments.seeds or ([11, 12, 13] if arguments.full else [11])
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        for name in arguments.only:
            compare(name, seeds, folder, full=arguments.full)


def compare(name: str, seeds: Sequence[int], folder: Path, *, full: bool) -> None:
    """Print the rows for one body."""
    print(f"\n{name}\n{TITLES}")
    rows: dict[str, list[Row]] = {"one world": [], "worlds": []}
    preset, options = OVER_WORLDS[name]
    for seed in seeds:
        generations = None if full else 2
        one = champion(folder / f"{name}-{seed}", name, seed, {}, generations)
        many = champion(folder / f"{name}-over-worlds-{seed}", preset, seed, options, generations)
        alone = test_champion(one, full=full)
        for label, run in (("one world", one), ("worlds", many)):
            found = alone if run is one else test_champion(run, full=full)
            row = Row(simulations(run), found, found.worst_tenth / alone.nominal.result)
            rows[label].append(row)
            sensitive = ", ".join(effect.condition for effect in found.effects)
            print(
                f"{label:>11}{seed:6}{row.simulations:13,}{found.nominal.result:11.2f}"
                f"{found.median:10.2f}{found.worst_tenth:15.2f}{row.kept:16.0%}{row.of_one:16.0%}"
                f"{found.falls:7}  {sensitive or 'no significant effect'}",
                flush=True,
            )
    for label, of_label in rows.items():
        print(
            f"{label:>11}: of its nominal {spread([row.kept for row in of_label], '.0%')}, "
            f"of one world’s {spread([row.of_one for row in of_label], '.0%')}, "
            f"falls {spread([row.unseen.falls for row in of_label], 'g')}"
        )


def champion(
    path: Path, preset: str, seed: int, options: dict[str, Any], generations: int | None
) -> gs.Run:
    """Return the run in a folder; evolve it if it is missing."""
    if path.exists():
        return gs.load(path)
    with gs.evolve(preset, seed=seed, set=options, generations=generations, out=path) as search:
        for _ in search:
            pass
        return search.run


def test_champion(run: gs.Run, *, full: bool) -> UnseenResults:
    """Test a run's champion in unseen worlds."""
    body = run.experiment.entries["organism"].name
    ranges = WIDE if body == "robot" else RANGES
    return evaluate_unseen(run.champion, 100 if full else 10, ranges=ranges)


def simulations(run: gs.Run) -> int:
    """Return the number of individuals times the worlds in which each was evaluated."""
    return int(run.history["evaluations"][-1]) * max(run.experiment.worlds.count, 1)


def spread(values: Sequence[float], form: str) -> str:
    """Format the median and the range of values."""
    return f"{median(values):{form}} ({min(values):{form}} to {max(values):{form}})"


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main()

"""The atlas of the spider's gaits: speed, sizes, and a comparison of its archives with pyribs'.

The axes are the duty factors of the eight legs, as Voronoi cells. pyribs' `IsoLineEmitter` gets
the same objective, axes, centroids, first population and budget. Its genes are scaled to their
bounds, so that its standard deviation is relative to their width, as in gaitsim.

    python benchmarks/atlas.py [--seeds 3] [--evaluations 200000] [--population 1000]
"""

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from timing import milliseconds, print_figure, print_machine

from gaitsim.contracts import Context, Genomes, RealSpace, Results, State
from gaitsim.evaluation import Evaluation, Evaluator
from gaitsim.evolution import Generation, evolve
from gaitsim.experiment import Experiment, load_experiment
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.folder import CHECKPOINT
from gaitsim.storage.writer import RunWriter

SIZES = (15_625, 40_000)
OFFSET = -10.0  # lower than all but the worst random gaits
SECONDS = 10.0
SIGMAS = (0.01, 0.03)  # pyribs' default and gaitsim's
SHARES = (0.1, 0.25, 0.5, 1.0)  # shares of the budget at which the curves are printed
Curve = list[tuple[float, float]]
"""Coverage, %, and QD score at each share of the budget."""
Evaluate = Callable[[Genomes], Evaluation]


def atlas(
    cells: int, population: int, generations: int, seed: int, **options: object
) -> Experiment:
    """Return the experiment of the spider's atlas over its duty factors, with line variation."""
    legs = load_experiment("spider").organism.leg_joints()
    return load_experiment(
        "spider",
        {
            "seed": seed,
            "evolution.population": population,
            "evolution.generations": generations,
            "organism.symmetry": "none",
            "fitness.drift_weight": 0.0,
            "fitness.yaw_weight": 0.0,
            "search.plugin": "map-elites",
            "search.start": "random",
            "search.axes": {f"duty factor {leg}": [0.0, 1.0] for leg in legs},
            "search.cells": cells,
            "search.offset": OFFSET,
            **{f"search.{name}": value for name, value in options.items()},
        },
    )


def full_archive_state(experiment: Experiment, cells: int) -> State:
    """Return the search's state with an elite in each cell."""
    search, space, rng = experiment.search, experiment.space(), np.random.default_rng(0)
    state = search.initial(Context(space, cells, 0, rng))
    values = dict(zip(search.reads(), state["centroids"].T, strict=True))
    held = Results(space.random(cells, rng), rng.random(cells), values)
    return search.tell(state, held, Context(space, cells, 1, rng))


def print_speed(cells: int, population: int) -> None:
    """Print speed, memory and folder size of a run on disk, and the cost of a full archive."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as held:
        experiment = atlas(cells, population, 1_000_000, 0)
        writer = held.enter_context(RunWriter.open(create_run(experiment, Path(folder) / "run")))
        evaluator = held.enter_context(Evaluator(experiment))
        evaluator.prepare()
        generations = writer.evolve(evaluator.evaluate)
        first = next(generations)
        start, work = time.perf_counter(), time.process_time()
        for finished in generations:
            generation = finished
            if time.perf_counter() - start > SECONDS:
                break
        seconds, work = time.perf_counter() - start, time.process_time() - work
        evaluations = (generation.number - first.number) * population
        print(f"\n{cells:,} cells, {population:,} spiders per generation, {SECONDS:g} s")
        hourly = f"{3600e-6 * evaluations / seconds:.1f} million"
        busy = f"{1e6 * work / evaluations:.0f} µs of processor time each"
        print_figure("evaluations per hour", hourly, busy)
        elites = len(generation.state["cells"])
        print_figure(
            "folder", _megabytes(_size(writer.path)), f"{elites:,} elites, two checkpoints"
        )
        progress = generation.progress
        full = replace(
            generation,
            number=generation.number + 1,
            progress=replace(progress, evaluations=progress.evaluations + population),
            state=full_archive_state(experiment, cells),
        )
        start, work = time.perf_counter(), time.process_time()
        writer.record(full)
        work, seconds = time.process_time() - work, time.perf_counter() - start
        beside = f"{milliseconds(work)} of processor time"
        print_figure("writing a generation, all cells occupied", milliseconds(seconds), beside)
        print_figure(
            "its checkpoint; a run folder holds two",
            _megabytes((writer.path / CHECKPOINT).stat().st_size),
        )
        print_figure("ask and tell", milliseconds(_step(experiment, full.state, generation)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print_figure("peak memory of the process", _megabytes(1024 * peak))


def _step(experiment: Experiment, state: State, generation: Generation) -> float:
    """Return the processor time of ask and tell for a generation, minimum of five, seconds."""
    search, space, rng = experiment.search, experiment.space(), np.random.default_rng(0)
    told = Results(generation.genomes, generation.scores, generation.evaluation.values)
    taken = []
    for _ in range(5):
        context = Context(space, len(generation.genomes), 2, rng)
        start = time.process_time()
        _, asked = search.ask(state, None, context)
        search.tell(asked, told, context)
        taken.append(time.process_time() - start)
    return min(taken)


def _size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.1f} MB"


def gaitsim_curve(experiment: Experiment, evaluate: Evaluate) -> Curve:
    """Return coverage and QD score during gaitsim's evolution."""
    found = [
        (100 * generation.figures["coverage"], generation.figures["QD score"])
        for generation in evolve(experiment, evaluate)
    ]
    return [found[round(share * len(found)) - 1] for share in SHARES]


def pyribs_curve(experiment: Experiment, evaluate: Evaluate, sigma: float) -> Curve:
    """Return coverage and QD score with pyribs, from the same first population."""
    from ribs.archives import CVTArchive
    from ribs.emitters import IsoLineEmitter
    from ribs.schedulers import Scheduler

    space, names = experiment.space(), experiment.search.reads()
    assert isinstance(space, RealSpace)
    first = next(iter(evolve(experiment, evaluate)))
    genes, population = first.genomes.shape[1], len(first.genomes)
    archive = CVTArchive(
        solution_dim=genes,
        centroids=first.state["centroids"],
        ranges=[(0, 1)] * len(names),
        qd_score_offset=OFFSET,
    )
    emitter = IsoLineEmitter(
        archive,
        iso_sigma=sigma,
        line_sigma=0.2,
        initial_solutions=(first.genomes - space.lower) / space.width,
        bounds=[(0, 1)] * genes,
        batch_size=population,
        seed=experiment.seed,
    )
    scheduler = Scheduler(archive, [emitter])
    found: Curve = []
    for _ in range(experiment.evolution.generations):
        genomes = space.lower + scheduler.ask() * space.width
        evaluation = evaluate(np.clip(genomes, space.lower, space.upper))
        values = np.stack([evaluation.values[name] for name in names], 1)
        scheduler.tell(evaluation.scores, values)
        found.append((100 * archive.stats.coverage, archive.stats.qd_score))
    return [found[round(share * len(found)) - 1] for share in SHARES]


def print_curves(cells: int, population: int, evaluations: int, seeds: int) -> None:
    """Print the medians of coverage and QD score over the seeds, and the range of coverage."""
    print(f"\n{cells:,} cells, {population:,} genomes per generation, {seeds} seeds")
    heads = "".join(f"{share * evaluations:>37,.0f}" for share in SHARES)
    print(f"{'evaluations':<22}{heads}")
    for sigma in SIGMAS:
        for name in ("gaitsim", "pyribs"):
            curves = []
            for seed in range(1, seeds + 1):
                experiment = atlas(cells, population, evaluations // population, seed, sigma=sigma)
                with Evaluator(experiment) as evaluator:
                    evaluate = evaluator.evaluate
                    curves.append(
                        gaitsim_curve(experiment, evaluate)
                        if name == "gaitsim"
                        else pyribs_curve(experiment, evaluate, sigma)
                    )
            row = ""
            for coverages, scores in np.moveaxis(np.array(curves), 0, 2):
                spread = f"{min(coverages):.2f} to {max(coverages):.2f}"
                middle = f"{np.median(coverages):.2f} % ({spread})"
                row += f"{middle:>28}{np.median(scores):>9,.0f}"
            print(f"{name + f', sigma {sigma:g}':<22}{row}", flush=True)


def main() -> None:
    """Print speed, sizes and curves."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--evaluations", type=int, default=200_000)
    parser.add_argument("--population", type=int, default=1_000)
    parser.add_argument("--only", choices=["speed", "curves"])
    arguments = parser.parse_args()
    print_machine()
    if arguments.only != "curves":
        for cells in SIZES:  # a process for each size, to measure its peak memory
            child = get_context("spawn").Process(
                target=print_speed, args=(cells, arguments.population)
            )
            child.start()
            child.join()
    if arguments.only != "speed":
        print_curves(SIZES[0], arguments.population, arguments.evaluations, arguments.seeds)


if __name__ == "__main__":
    main()

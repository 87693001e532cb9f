"""Python functions and objects as fitness and body; genomes scored for external optimisers."""

import functools
import json
import os
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.contracts import Array, Channel, Genomes, Skeleton, option
from gaitsim.evaluation.chunking import Scheduler
from gaitsim.registry import entry_points, python_plugins
from gaitsim.registry.entry_points import find_registered
from gaitsim.render.terminal.explanation import explanation
from gaitsim.storage.snapshot import RunSnapshot

SPACE = gs.RealSpace(np.full(3, -5.0), np.full(3, 5.0))


def sphere(genomes: Genomes) -> Array:
    """Return scores without terms."""
    return -(genomes**2).sum(axis=1)


def pendulum(genomes: Genomes) -> dict[str, Array]:
    """Return the channels of a pendulum, driven by a torque for each genome."""
    return {"angle": np.sin(genomes), "effort": np.abs(genomes).sum(axis=1)}


def upright(motion: gs.Motion) -> dict[str, Array]:
    """Return two terms."""
    return {"angle": motion["angle"].sum(axis=1), "effort": -0.1 * motion["effort"]}


def height(motion: gs.Motion) -> Array:
    """Return one term, which reads an undeclared channel."""
    return np.asarray(motion["feet"][:, :, :, 2].max(axis=(1, 2)))


class Weighted(gs.Fitness):
    """A fitness outside any package."""

    weight: float = option(1.0, "of the effort")
    floor: float | None = option(None, "lowest term")
    needs: ClassVar[tuple[str, ...]] = ("effort",)

    def terms(self, motion: gs.Motion) -> dict[str, Array]:
        """Return one term."""
        return {"effort": -self.weight * motion["effort"]}


class Stick(gs.Organism):
    """A body outside any package."""

    length: float = option(1.0, "of the stick", unit="m")
    channels: ClassVar[Mapping[str, Channel]] = {"effort": Channel((), "J", "of a motor")}

    def genome_space(self) -> gs.RealSpace:
        """Return a space of two genes."""
        return gs.RealSpace(np.zeros(2), np.ones(2))

    def move(self, genomes: Genomes) -> gs.Motion:
        """Return a motion with the effort only."""
        return gs.Motion(10.0, {"effort": genomes.sum(axis=1) * self.length})

    def skeleton(self, motion: gs.Motion, individual: int) -> Skeleton:
        """Raise an error, as there is nothing to draw."""
        raise NotImplementedError


@pytest.fixture
def forget_functions(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Return a function that makes this process forget given functions, like a new process."""
    return lambda: monkeypatch.setattr(entry_points, "_registered", {})


def run_to_end(search: gs.RunningSearch) -> gs.Generation:
    """Run a search, and return the last generation."""
    *_, last = search
    return last


def search_for_pendulum(out: Path | None = None, generations: int = 6) -> gs.RunningSearch:
    """Return a search for the pendulum."""
    return gs.evolve(
        body=pendulum,
        space=SPACE,
        fitness=upright,
        generations=generations,
        population=8,
        seed=3,
        out=out,
    )


def test_a_function_that_returns_an_array_is_a_body_with_its_score() -> None:
    last = run_to_end(gs.evolve(body=sphere, space=SPACE, generations=40, population=10))
    assert last.scores.max() > -1e-3
    assert np.array_equal(last.scores, sphere(last.genomes))


def test_a_function_scores_a_body_from_a_package() -> None:
    search = gs.evolve("spider", fitness=height, generations=2, population=6, seed=1)
    last = run_to_end(search)
    again = gs.evaluate(search.experiment, last.genomes)
    assert list(last.evaluation.terms) == ["height"]
    assert np.array_equal(last.scores, again.scores)
    assert search.champion is not None
    assert search.champion.replayed_score == search.champion.score


def test_a_run_is_resumed_exactly_with_its_functions(
    tmp_path: Path, forget_functions: Callable[[], None]
) -> None:
    run_to_end(search_for_pendulum(tmp_path / "whole"))
    run_to_end(search_for_pendulum(tmp_path / "part", generations=3))
    forget_functions()
    part = gs.load(tmp_path / "part", fitness=upright, body=pendulum, space=SPACE)
    run_to_end(part.resume(6))
    whole = gs.load(tmp_path / "whole")
    assert part.fingerprint() == whole.fingerprint()
    assert len(RunSnapshot(part.path).stages) == 1
    assert part.champion.terms == part.champion.replayed_terms


def test_a_run_whose_functions_have_checksums_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    section = python_plugins._section

    def with_checksum(*given: Any) -> dict[str, Any]:
        found = section(*given)
        return {**found, "plugin": f"{found['plugin']}@1a2b3c4d"}

    path = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(python_plugins, "_section", with_checksum)
        run_to_end(search_for_pendulum(path, generations=2))
    assert "python:upright@1a2b3c4d" in (path / "experiment.toml").read_text()
    run = gs.load(path, fitness=upright, body=pendulum, space=SPACE)
    last = run_to_end(run.resume(3, fitness=upright, body=pendulum, space=SPACE))
    assert (last.number, last.progress.stage) == (3, 1)
    assert run.champion.terms == run.champion.replayed_terms


def test_a_function_of_another_name_starts_a_stage(tmp_path: Path) -> None:
    run_to_end(search_for_pendulum(tmp_path / "run", generations=2))

    def tilted(motion: gs.Motion) -> Array:
        return np.asarray(motion["angle"][:, 0])

    run = gs.load(tmp_path / "run")
    with pytest.raises(gs.GaitsimError, match="the fitness of the run is 'python:upright'"):
        gs.load(tmp_path / "run", fitness=tilted)
    last = run_to_end(run.resume(3, fitness=tilted))
    assert last.progress.stage == 2
    assert list(last.evaluation.terms) == ["tilted"]


def test_searches_with_functions_of_the_same_name_do_not_mix() -> None:
    def weighted(weight: float) -> gs.RunningSearch:
        def effort(motion: gs.Motion) -> Array:
            return np.asarray(weight * motion["effort"] - weight)

        return gs.evolve(body=pendulum, space=SPACE, fitness=effort, seed=1)

    one, two = weighted(1.0), weighted(2.0)
    assert np.array_equal(2 * next(one).scores, next(two).scores)
    assert np.array_equal(2 * next(weighted(1.0)).scores, next(weighted(2.0)).scores)


def test_objects_of_classes_outside_packages_keep_their_options(
    tmp_path: Path, forget_functions: Callable[[], None]
) -> None:
    search = gs.evolve(
        body=Stick(length=2.0), fitness=Weighted(weight=3.0), generations=2, population=6,
        out=tmp_path / "stick",
    )  # fmt: skip
    last = run_to_end(search)
    assert search.experiment.fitness == Weighted(weight=3.0)
    assert np.allclose(last.scores, -6 * last.genomes.sum(axis=1))
    forget_functions()
    run = gs.load(tmp_path / "stick", fitness=Weighted(), body=Stick())
    assert run.experiment.fitness == Weighted(weight=3.0)
    assert run_to_end(run.resume(3, fitness=Weighted(weight=2.0))).progress.stage == 2


def test_without_its_functions_a_run_can_be_read_but_not_replayed(
    tmp_path: Path, forget_functions: Callable[[], None], gaitsim: Any
) -> None:
    path = tmp_path / "runs/pendulum"
    last = run_to_end(search_for_pendulum(path))
    forget_functions()
    run = gs.load(path)
    assert run.history["best"][-1] == last.scores.max()
    assert run.plot("fitness") is not None
    shown = gaitsim("show", path).stdout
    assert "files alone cannot reproduce it" in shown
    assert "Champion of generation" in shown
    assert "cannot be reproduced" in gaitsim("runs", path.parent).stdout
    found = json.loads(gaitsim("show", path, "--json").stdout)
    assert [name.partition("@")[0] for name in found["outside"]] == [
        "python:pendulum",
        "python:upright",
    ]
    for refuse in (
        lambda: run.champion,
        lambda: run_to_end(run.resume(9)),
        run.share,
        lambda: run_to_end(gs.evolve(path / "experiment.toml", out=tmp_path / "again")),
    ):
        with pytest.raises(gs.GaitsimError, match="must be passed again"):
            refuse()
    for command in (("verify", path), ("resume", path), ("fork", path, "--out", "fork")):
        assert "must be passed again" in gaitsim(*command, code=2).stderr
    assert "files alone cannot reproduce it" in (path / "experiment.toml").read_text()
    assert "Python code outside the run" in (path / "provenance.json").read_text()


def test_without_its_fitness_function_a_run_can_be_replayed_but_not_scored(
    tmp_path: Path, forget_functions: Callable[[], None]
) -> None:
    search = gs.evolve("spider", fitness=height, generations=1, population=6, out=tmp_path / "up")
    run_to_end(search)
    forget_functions()
    champion = gs.load(tmp_path / "up").champion
    assert champion.motion["feet"].shape[0] == 1
    assert champion.scored_terms == champion.terms
    with pytest.raises(gs.GaitsimError, match="fitness 'height' is not stored"):
        champion.replayed_terms  # noqa: B018
    warnings = [part.warning for part in explanation(champion, gs.load(tmp_path / "up").history)]
    assert "fitness 'height'" in warnings[0]


def test_runs_with_functions_cannot_be_shared_or_detached(tmp_path: Path) -> None:
    search = search_for_pendulum(tmp_path / "run", generations=2)
    run_to_end(search)
    with pytest.raises(gs.GaitsimError, match="cannot be verified"):
        search.run.share()
    with pytest.raises(gs.GaitsimError, match="another process"):
        search.run.detach(9)


def fails(motion: gs.Motion) -> Array:
    raise ValueError("of my own")


def changes(motion: gs.Motion) -> Array:
    motion["effort"][:] = 0
    return motion["effort"]


def assigns(motion: gs.Motion) -> Array:
    motion["effort"] = np.zeros(6)  # type: ignore[index]
    return motion["effort"]


def reads(motion: gs.Motion) -> Array:
    return motion["angel"]


def renames(motion: gs.Motion, calls: list[int] = []) -> dict[str, Array]:  # noqa: B006
    calls.append(1)
    return {f"call {len(calls)}": motion["effort"]}


@pytest.mark.parametrize(
    ("fitness", "told"),
    [
        (fails, "'fails' failed .* of my own\n.*test_in_python.py, line"),
        (changes, "'changes' modifies the motion"),
        (assigns, "'assigns' modifies the motion"),
        (reads, "no channel 'angel'; it has angle, effort"),
        (renames, "'renames' returned the terms call 2 after call 1"),
        (functools.partial(height), "a functools.partial of height"),
        (Weighted, r"Weighted is a class, not an instance[\s\S]*fitness=Weighted\(\)"),
        ("upright", "'upright' is not a function"),
    ],
)
def test_errors_of_a_fitness_name_the_function(fitness: Any, told: str) -> None:
    with pytest.raises(gs.GaitsimError, match=told) as caught:
        run_to_end(
            gs.evolve(body=pendulum, space=SPACE, fitness=fitness, generations=3, population=6)
        )
    assert "report the error to its author" not in str(caught.value)


def clears(genomes: Genomes) -> Array:
    genomes[:] = 0
    return genomes[:, 0]


@pytest.mark.parametrize(
    ("body", "space", "told"),
    [
        (sphere, None, "needs a genome space"),
        (None, SPACE, "the body is missing"),
        (pendulum, SPACE, "the body returned no score"),
        (clears, SPACE, "'clears' modifies the genomes"),
        (Stick, None, "not an instance"),
    ],
)
def test_errors_of_a_body_name_the_function(body: Any, space: Any, told: str) -> None:
    with pytest.raises(gs.GaitsimError, match=told):
        run_to_end(gs.evolve(body=body, space=space, generations=2, population=6))


@pytest.fixture
def shared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worker processes get every population, even if they are slower."""
    monkeypatch.setattr(Scheduler, "chunks", lambda self, individuals: min(individuals, 3))


def test_functions_and_objects_give_the_same_bits_in_worker_processes(shared: None) -> None:
    weights, process = np.arange(1.0, 4.0), os.getpid()
    data = np.ones((2**16, 3))  # 1.5 MB, which workers read from a file

    def weighted(genomes: Genomes) -> Array:
        if len(genomes) > 1 and os.getpid() == process:  # the first individual is timed here
            raise ValueError("not in a worker")
        return -(data[0] * weights * genomes**2).sum(axis=1)

    def one(genomes: Genomes) -> Array:
        return -(weights * genomes**2).sum(axis=1)

    found = [
        run_to_end(gs.evolve(body=body, space=SPACE, generations=3, population=7, workers=workers))
        for body, workers in ((one, 1), (weighted, 2))
    ]
    assert np.array_equal(found[0].genomes, found[1].genomes)
    assert np.array_equal(found[0].scores, found[1].scores)
    parts = {"body": Stick(length=2.0), "fitness": Weighted(weight=3.0)}
    last = run_to_end(gs.evolve(**parts, generations=2, population=6, workers=2))
    assert np.allclose(last.scores, -6 * last.genomes.sum(axis=1))


def test_an_error_of_a_function_in_a_worker_names_its_line(shared: None) -> None:
    def picky(genomes: Genomes) -> Array:
        if len(genomes) > 1:
            raise ValueError("of my own")
        return genomes[:, 0]

    line = picky.__code__.co_firstlineno + 2
    told = f"'picky' failed .*ValueError: of my own\n.*test_in_python.py, line {line}"
    with pytest.raises(gs.GaitsimError, match=told):
        run_to_end(gs.evolve(body=picky, space=SPACE, population=7, workers=2))


def test_a_function_that_gives_other_scores_in_a_worker_is_named(shared: None) -> None:
    process = os.getpid()

    def shifted(genomes: Genomes) -> Array:
        return genomes[:, 0] + (os.getpid() == process)

    search = gs.evolve(body=shifted, space=SPACE, generations=3, workers=2)
    with pytest.warns(UserWarning, match="'shifted' gave the same genome the score") as warned:
        run_to_end(search)
    assert len(warned) == 1


def test_a_function_that_cannot_be_pickled_is_named_before_the_search() -> None:
    lock = threading.Lock()

    def guarded(genomes: Genomes) -> Array:
        with lock:
            return genomes[:, 0]

    assert run_to_end(gs.evolve(body=guarded, space=SPACE, generations=1)).number == 1
    with pytest.raises(gs.GaitsimError, match=r"'guarded' cannot be sent to workers.*lock"):
        run_to_end(gs.evolve(body=guarded, space=SPACE, workers=2))


def test_a_function_is_called_only_for_genomes_of_the_search() -> None:
    genes: list[float] = []

    def counted(genomes: Genomes) -> Array:
        genes.extend(genomes[:, 0])
        return genomes[:, 0]

    found = [one.genomes[:, 0] for one in gs.evolve(body=counted, space=SPACE, generations=3)]
    assert genes == np.concatenate(found).tolist()


def rosenbrock(x: Array) -> float:
    return float(-(100 * (x[1:] - x[:-1] ** 2) ** 2 + (1 - x[:-1]) ** 2).sum())


TEN = gs.RealSpace(np.full(10, -5.0), np.full(10, 5.0))


@pytest.mark.parametrize("population", [10])
@pytest.mark.parametrize(
    "function",
    [rosenbrock, lambda x: -(x[0] ** 2) - x[1] ** 2, lambda x: -float(x @ x), lambda x: -sum(x**2)],
)
def test_a_function_of_one_genome_is_never_mistaken_for_one_of_a_population(
    function: Any, population: int
) -> None:
    """`x[0] ** 2` of ten genomes of ten genes has the shape of their scores."""
    with pytest.raises(gs.GaitsimError, match=r"body=gs\.scalar\("):
        run_to_end(gs.evolve(body=function, space=TEN, population=population))


def trade(genomes: Genomes) -> tuple[Array, Array]:
    """Return two objectives, one of which is to be minimised."""
    return (genomes**2).sum(axis=1), -((genomes - 2) ** 2).sum(axis=1)


def test_objectives_are_returned_in_any_form() -> None:
    def columns(genomes: Genomes) -> Array:
        return np.stack(trade(genomes), axis=1)

    def named(genomes: Genomes) -> dict[str, Array]:
        return dict(zip(("far", "near"), trade(genomes), strict=True))

    @gs.scalar
    def one(genome: Array) -> tuple[float, float]:
        far, near = trade(genome[None])
        return float(far[0]), float(near[0])

    fronts = []
    for body in (trade, columns, named, one):
        objectives: Any = {"far": "min", "near": "max"} if body is named else ("min", "max")
        search = gs.evolve(
            body=body, space=SPACE, objectives=objectives, generations=4, population=8
        )
        run_to_end(search)
        assert search.members is not None
        fronts.append(search.members)
    for front in fronts[1:]:
        assert np.array_equal(front.genomes, fronts[0].genomes)
        assert np.array_equal([*front.values.values()], [*fronts[0].values.values()])
    with pytest.raises(gs.GaitsimError, match="2 objectives, but the search 'cma-es'"):
        run_to_end(gs.evolve(body=trade, space=SPACE))


def measured(genomes: Genomes) -> dict[str, Array]:
    """Return scores with two measures."""
    return {"score": sphere(genomes), "a": genomes[:, 0], "b": genomes[:, 1]}


@pytest.mark.parametrize(
    ("options", "score"),
    [
        ({}, sphere),
        ({"objectives": ("min", "max"), "population": 8}, trade),
        (
            {
                "set": {"search.plugin": "map-elites", "search.axes": {"a": [-5, 5], "b": [-5, 5]}},
                "population": 8,
            },
            measured,
        ),
    ],
)
def test_an_optimiser_gives_the_same_bits_as_evolve(options: Any, score: Any) -> None:
    search = gs.evolve(body=score, space=SPACE, generations=6, seed=5, **options)
    last = run_to_end(search)
    optimiser = gs.Optimiser(SPACE, generations=6, seed=5, **options)
    while not optimiser.stop:
        assert np.array_equal(optimiser.ask(), optimiser.ask())
        told = optimiser.tell(score(optimiser.ask()))
    assert np.array_equal(told.genomes, last.genomes)
    assert np.array_equal(told.scores, last.scores)
    assert optimiser.stop == search.stop
    best = [optimiser.champion, search.champion]
    assert best[0] is not None
    assert best[1] is not None
    assert np.array_equal(best[0].genome, best[1].genome)
    assert np.array_equal(optimiser.history["mean"], search.history["mean"])
    assert optimiser.history["generation"].tolist() == [1, 2, 3, 4, 5, 6]


def test_mistakes_with_an_optimiser_are_explained() -> None:
    optimiser = gs.Optimiser(SPACE, generations=1)
    with pytest.raises(gs.GaitsimError, match=r"call ask\(\) before"):
        optimiser.tell([1.0])
    size = len(optimiser.ask())
    for scores in (0.0, np.zeros(3), np.zeros((size, 1)), ["a"] * size, {"a": np.zeros((size, 2))}):
        with pytest.raises(gs.GaitsimError, match=r"tell\(\) received scores"):
            optimiser.tell(scores)
    optimiser.tell([np.nan, *range(size - 1)])
    assert optimiser.champion is not None
    assert optimiser.champion.score == size - 2
    with pytest.raises(gs.GaitsimError, match="the search has ended: 1 generations are done"):
        optimiser.ask()


def test_genomes_are_scored_for_any_optimiser() -> None:
    experiment = search_for_pendulum().experiment
    genomes = experiment.space().random(5, np.random.default_rng(0))
    found = gs.evaluate(experiment, np.asfortranarray(genomes))
    assert np.array_equal(found.scores, sum(found.terms.values()))
    assert gs.evaluate(experiment, genomes[2]).scores == found.scores[2]
    outside = gs.evaluate(experiment, [[9, 0, -9], [5, 0, -5]]).scores
    assert outside[0] == outside[1]
    for given, told in (
        ([[9, 0, -9]], "is out of bounds"),
        (genomes.T, r"shape \(3, 5\)"),
        ([0, np.nan, 0], "gene 2"),
        (["a", "b", "c"], "not real numbers"),
    ):
        with pytest.raises(gs.GaitsimError, match=told):
            gs.evaluate(experiment, given, repair=False)
    with pytest.raises(gs.GaitsimError, match="uint8"):
        gs.evaluate("millipede", np.full(36, 0.5))


def test_a_remedy_contains_no_code_from_a_file() -> None:
    remedy = find_registered("fitness", "python:f(print(6 * 7))@12345678").missing_error.remedy
    assert "fitness=…" in remedy
    assert "print" not in remedy


def test_a_search_starts_from_genomes_and_individuals(tmp_path: Path) -> None:
    def first(start: Any, out: Path | None = None) -> tuple[gs.RunningSearch, Array]:
        search = gs.evolve(
            body=sphere, space=TEN, start=start, generations=3, seed=2, out=out,
            set={"search.start_step": 1e-6},
        )  # fmt: skip
        return search, next(search).genomes

    point = np.linspace(-4.0, 4.0, 10)
    search, genomes = first(point)
    assert np.allclose(genomes, point, atol=1e-3)
    run_to_end(search)
    assert search.champion is not None
    assert np.allclose(first(search.champion)[1], search.champion.genome, atol=1e-3)
    optimiser = gs.Optimiser(TEN, start=point, seed=2, set={"search.start_step": 1e-6})
    assert np.array_equal(optimiser.ask(), genomes)
    recorded, _ = first([point, point / 2], tmp_path / "run")
    assert np.array_equal(recorded.run.snapshot.start.genomes, [point, point / 2])
    recorded.close()
    whole, _ = first([point, point / 2])
    last = run_to_end(gs.load(tmp_path / "run", body=sphere, space=TEN).resume())
    assert np.array_equal(last.genomes, run_to_end(whole).genomes)


@pytest.mark.parametrize(
    ("start", "told"),
    [
        (np.full(10, 9.0), r"the start point is out of bounds: 'gene 1' is 9, allowed -5 to 5"),
        (np.full(10, np.nan), "gene 1, 'gene 1', of individual 0 is nan"),
        ("origin", "has no start point 'origin'"),
    ],
)
def test_wrong_start_points_are_explained(start: Any, told: str) -> None:
    with pytest.raises(gs.GaitsimError, match=told):
        gs.evolve(body=sphere, space=TEN, start=start)
    with pytest.raises(gs.GaitsimError, match=told):
        gs.Optimiser(TEN, start=start)

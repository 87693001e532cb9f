"""The Python interface, `import gaitsim as gs`: searches as loops, loaded runs, reprs."""

import html
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from waiting import until

import gaitsim as gs
from gaitsim.experiment import load_experiment
from gaitsim.storage.creation import create_run
from gaitsim.storage.writer import RunWriter


@pytest.fixture(scope="module")
def evolved_search(tmp_path_factory: pytest.TempPathFactory) -> gs.RunningSearch:
    """Return a finished, recorded search for a gait of the spider."""
    out = tmp_path_factory.mktemp("runs") / "evolved_search"
    search = gs.evolve("spider", generations=4, population=24, seed=2, out=out)
    assert [generation.number for generation in search] == [1, 2, 3, 4]
    return search


def test_importing_gaitsim_imports_nothing_else() -> None:
    script = (
        "import sys; import gaitsim; before = set(sys.modules); dir(gaitsim); "
        "print({'numpy', 'pydantic', 'numba', 'matplotlib', 'typer'} & before)"
    )
    found = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert found.stdout.strip() == "set()"


def test_every_public_name_exists() -> None:
    assert set(gs.__all__) <= set(dir(gs))
    assert all(getattr(gs, name).__name__ == name for name in gs.__all__)
    with pytest.raises(AttributeError, match="no attribute 'evovle': did you mean 'evolve'"):
        gs.evovle  # noqa: B018


def test_runs_and_presets_are_listed_as_tables(evolved_search: gs.RunningSearch) -> None:
    import gaitsim.storage.snapshot  # noqa: F401 - submodules must not hide the functions

    found = gs.runs(evolved_search.run.path.parent)
    assert [run.path.name for run in found] == ["evolved_search"]
    title, head, row = repr(found).splitlines()
    assert title == f"runs in {evolved_search.run.path.parent}: 1"
    assert head.split() == ["run", "body", "fitness", "generation", "best", "state", "tags"]
    assert row.split()[:4] == ["evolved_search", "spider", "spider-walk", "4/4"]
    assert row.split()[4:] == [f"{found[0].champion.score:.4g}", "finished"]
    assert "<td>evolved_search</td>" in found._repr_html_()
    assert repr(found[1:]).endswith(": 0")
    with pytest.raises(gs.GaitsimError, match="folder not found"):
        gs.runs("nowhere")
    presets = gs.presets()
    assert {"spider", "fly"} <= {*presets}
    assert "a spider that walks" in repr(presets[presets.index("spider") :])


def test_runs_are_tagged_found_and_deleted(
    evolved_search: gs.RunningSearch, tmp_path: Path
) -> None:
    for name in ("a", "b"):
        shutil.copytree(evolved_search.run.path, tmp_path / name)
    run = gs.load(tmp_path / "a")
    run.tag("good", "straight")
    run.untag("straight", "missing")
    assert run.tags == ("good",)
    (found,) = gs.runs(tmp_path, where="tag:good score>-100 forward>-100")
    assert found.path == run.path
    assert "good" in repr(gs.runs(tmp_path))
    assert [one.path.name for one in gs.runs(tmp_path, sort="-name")] == ["b", "a"]
    for options in ({"where": "scor>1"}, {"sort": "-scor"}):
        with pytest.raises(gs.GaitsimError, match="unknown key 'scor'"):
            gs.runs(tmp_path, **options)
    with pytest.raises(gs.GaitsimError, match="invalid tag"):
        run.tag("a b")
    run.delete()
    assert [one.path.name for one in gs.runs(tmp_path)] == ["b"]


def test_guesses_of_a_notebook_user_work(evolved_search: gs.RunningSearch, tmp_path: Path) -> None:
    run = evolved_search.run
    assert run.best.score == run.champion.score
    assert run.champion.gait == run.analyse().name.name == gs.analyse(str(run.path)).name.name
    with pytest.raises(gs.GaitsimError, match="a RunningSearch is neither a run nor an indiv"):
        gs.analyse(evolved_search)  # type: ignore[arg-type]
    assert repr(run.analyse()).startswith(f"Gait: {run.champion.gait}, ")
    assert isinstance(run.champion.plot("footfall"), Figure)
    assert isinstance(run.champion.plot(), Figure)
    with pytest.raises(gs.GaitsimError, match="needs a whole run"):
        run.champion.plot("fitness")
    damaged = run.replay(2, damage="L2 lost")
    assert damaged.damage == ("L2 lost",)
    assert "changes='L2 lost'" in repr(damaged)
    assert damaged.score == run.replay(2, damage=["L2 lost"]).score < run.replay(2).score
    assert "2 individuals" in run.export(tmp_path / "a.csv", "motion", generations=[1, 2]).summary
    assert run.replay(2, world="slope 2").score == run.replay(2, world={"slope": 2}).score
    run.export(tmp_path / "gait.csv")
    gs.export(run.champion, tmp_path / "same.csv")
    assert (tmp_path / "gait.csv").read_bytes() == (tmp_path / "same.csv").read_bytes()
    assert gs.share(run) == run.share() == run.champion.share()
    for subject in (run, str(run.path), run.champion, run.share()):
        found = gs.verify(subject)
        assert found.identical
        assert "identical=True" in repr(found)


def test_a_motion_names_its_channels(evolved_search: gs.RunningSearch) -> None:
    motion = evolved_search.run.champion.motion
    with pytest.raises(KeyError, match=r"no channel 'foot'; did you mean 'feet'.* channels: joint"):
        motion["foot"]
    assert "foot" not in motion
    assert motion.get("foot") is None
    title, head, *rows = repr(motion).splitlines()
    assert title == "Motion of 1 at 30 Hz"
    assert head.split() == ["channel", "shape", "unit", "meaning"]
    assert rows[0].startswith("joint_angles")
    assert "(1, 300, 24)" in rows[0]
    assert "<td>joint_angles</td>" in motion._repr_html_()


def test_a_history_is_a_table_of_pandas(
    evolved_search: gs.RunningSearch, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pandas")
    for table in (evolved_search.run.to_pandas(), evolved_search.to_pandas()):
        assert table["generation"].tolist() == [1, 2, 3, 4]
        assert table["best"].max() == evolved_search.champion.score  # type: ignore[union-attr]
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(gs.GaitsimError, match="needs the package pandas"):
        evolved_search.run.to_pandas()


@pytest.mark.slow
def test_a_loop_records_the_run_that_the_command_records(
    tmp_path: Path, evolved_search: gs.RunningSearch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = "run spider --generations 4 --population 24 --seed 2 --out commanded"
    subprocess.run(
        [sys.executable, "-m", "gaitsim", *arguments.split()],
        check=True,
        capture_output=True,
        timeout=120,
    )
    assert gs.load("commanded").fingerprint() == evolved_search.run.fingerprint()
    # An unrecorded search evolves the same generations.
    unrecorded = list(gs.evolve("spider", generations=4, population=24, seed=2, workers=1))
    assert evolved_search.last is not None
    assert np.array_equal(unrecorded[-1].genomes, evolved_search.last.genomes)
    assert np.array_equal(unrecorded[-1].scores, evolved_search.last.scores)


def test_an_experiment_is_a_name_a_path_or_an_object(tmp_path: Path) -> None:
    spider = load_experiment("spider", {"evolution.population": 8})
    file = tmp_path / "mine.toml"
    file.write_text(spider.to_toml())
    found = [
        next(gs.evolve(given, seed=5, set={"evolution.population": np.int64(8)})).scores
        for given in ("spider", file, str(file), spider)
    ]
    assert all(np.array_equal(found[0], other) for other in found)


def test_invalid_arguments_are_reported_before_the_loop() -> None:
    with pytest.raises(gs.GaitsimError, match="did you mean 'spider'"):
        gs.evolve("spidr")
    with pytest.raises(gs.GaitsimError, match="2 problems"):
        gs.evolve("spider-genetic", population=1, set={"mutation.rate": 7})
    with pytest.raises(gs.GaitsimError, match="there is no run 'nowhere'"):
        gs.load("nowhere")
    with pytest.raises(gs.GaitsimError, match="not recorded"):
        gs.evolve("spider").run  # noqa: B018


def test_leaving_a_loop_stops_the_workers_and_unlocks_the_run(tmp_path: Path) -> None:
    out = tmp_path / "left"
    before = set(threading.enumerate())
    for generation in gs.evolve("spider", population=40, seed=1, workers=3, out=out):
        if generation.number == 3:
            break
    for thread in set(threading.enumerate()) - before:
        thread.join(60)  # each thread ends with its work
        assert not thread.is_alive()
    with RunWriter.open(out) as writer:  # the lock is released
        assert writer.last is not None
        assert writer.last.number == 3


@pytest.mark.slow
def test_workers_do_not_import_the_running_script(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(f"""
import gaitsim as gs
print("once")
for one in gs.evolve("walker", **{ISLANDS}, workers=2):
    print(one.scores.tolist())
""")
    run = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, check=False, timeout=120
    )
    alone = [f"{one.scores.tolist()}\n" for one in gs.evolve("walker", **ISLANDS, workers=1)]
    assert (run.stdout, run.stderr) == ("once\n" + "".join(alone), "")


ISLANDS: dict[str, Any] = {
    "generations": 3,
    "population": 4,
    "set": {
        "organism.duration": 0.5,
        "search.elites": 1,
        "islands.number": 2,
        "islands.every": 2,
        "islands.migrants": 1,
    },
}
"""Two small islands, each evolved by a worker."""


def test_a_run_resumes_after_an_error_in_the_loop(tmp_path: Path) -> None:
    out = tmp_path / "left"
    search = gs.evolve("spider", generations=4, population=24, seed=2, out=out)

    def fails() -> None:
        with search:
            for _ in search:
                raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fails()
    assert gs.load(out).generation == 1
    assert list(search) == []


def test_a_run_is_evolved_and_stopped_in_the_background(tmp_path: Path) -> None:
    out, many = tmp_path / "run", 1_000_000
    run = gs.evolve("millipede", population=11, generations=many, out=out).run
    with pytest.raises(gs.GaitsimError, match="rat"):
        run.detach(set={"mutation.rat": 1})
    run.detach(set={"seed": 3})
    until(lambda: run.generation > 0)
    assert run.state == "running"
    assert run.stop()
    assert (run.state, run.failure) == ("stopped", None)
    again = gs.evolve(run.experiment, generations=run.generation, out=tmp_path / "again")
    assert [*again][-1].number == run.generation
    assert again.run.fingerprint() == run.fingerprint()


def test_pictures_show_individuals(evolved_search: gs.RunningSearch, tmp_path: Path) -> None:
    run = evolved_search.run
    picture = gs.picture(run.champion, 1.0, size=(160, 90))
    assert isinstance(picture, Image.Image)
    assert picture.size == (160, 90)
    assert len(picture.getcolors(160 * 90) or ()) > 5
    with pytest.raises(gs.GaitsimError, match="did you mean 'side'"):
        gs.picture(run.champion, view="sid")
    assert gs.picture(run, 1.0, size=(160, 90)) == picture
    assert gs.view(run).page == gs.view(run.champion).page
    with pytest.raises(gs.GaitsimError, match="a str is not an individual"):
        gs.view("spider")
    with pytest.warns(UserWarning, match="cannot show a movement"):
        film = run.video(tmp_path / "walk.gif", size=(128, 96), speed=20, fps=5, intro=False)
    with Image.open(film) as opened:
        assert (opened.format, opened.size) == ("GIF", (128, 96))
    with pytest.raises(gs.GaitsimError, match="mp5"):
        run.video("walk.mp5")


def test_plots_are_figures_that_notebooks_show(evolved_search: gs.RunningSearch) -> None:
    figure = evolved_search.run.plot()
    assert isinstance(figure, Figure)
    assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]
    several = evolved_search.run.plot(
        "channel", channel="pose", generations=[1, 4], components=["x"]
    )
    drawn = [len(line.get_xdata()) for line in several.axes[0].lines]  # type: ignore[arg-type]
    assert drawn.count(300) == 2
    with pytest.raises(gs.GaitsimError, match="did you mean 'footfall'"):
        evolved_search.run.plot("footfal")


def test_reprs_are_short_lines(evolved_search: gs.RunningSearch, tmp_path: Path) -> None:
    assert evolved_search.last is not None
    assert evolved_search.champion is not None
    best = evolved_search.last.scores.max()
    assert repr(evolved_search.last).startswith(f"Generation(number=4, best={best:.4g}, mean=")
    assert "generation=4" in repr(evolved_search.run)
    for thing in (
        evolved_search,
        evolved_search.experiment,
        evolved_search.champion,
        evolved_search.last.evaluation,
        gs.Challenge.read(evolved_search.run.share()),
        evolved_search.champion.skeleton,
        evolved_search.experiment.space(),
        gs.BitSpace([f"bit {n}" for n in range(300)]),
        gs.evolve("spider-front", generations=1, population=8).members,
        gs.export(evolved_search.champion, tmp_path / "gait.csv"),
    ):
        assert len(repr(thing)) < 300


def test_tables_of_notebooks_are_escaped(evolved_search: gs.RunningSearch, tmp_path: Path) -> None:
    evil = "<script>alert('x')</script>"
    text = evolved_search.experiment.to_toml().replace('description = "', f'description = "{evil}')
    file = tmp_path / "evil.toml"
    file.write_text(text)
    experiment = load_experiment(str(file))
    search = gs.evolve(experiment, out=tmp_path / "<b>")
    shown = [experiment, search, search.run, gs.Run(create_run(experiment, tmp_path / "<i>"))]
    for thing in shown:
        table = thing._repr_html_()
        assert table.startswith("<table>")
        assert not any(tag in table for tag in ("<script", "<b>", "<i>"))
    assert html.escape(evil) in experiment._repr_html_()

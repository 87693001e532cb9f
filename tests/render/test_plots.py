import numpy as np
import pytest

from gaitsim.errors import GaitsimError, RunError
from gaitsim.render.plots.fitness import fitness_figure
from gaitsim.render.plots.style import LIGHT, save
from gaitsim.storage.creation import create_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_plots.curves import terms_figure


def plot_fitness(run, path):
    save(fitness_figure(run), path)


STARTS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.mark.sampled
@pytest.mark.parametrize("format", STARTS)
def test_plots_have_the_format_of_the_suffix_and_are_reproducible(spider_run, tmp_path, format):
    one, two = tmp_path / f"one.{format}", tmp_path / f"two.{format.upper()}"
    plot_fitness(spider_run, one)
    plot_fitness(spider_run, two)
    assert one.read_bytes().startswith(STARTS[format])
    assert one.read_bytes() == two.read_bytes()
    assert not list(tmp_path.glob(".gaitsim*"))


@pytest.mark.parametrize("failing", ["some", "all"])
def test_generations_without_a_finite_score_are_left_out(
    puppet_run, puppets, monkeypatch, tmp_path, failing
):
    calls = iter(range(100))

    def terms(self, motion):
        fails = failing == "all" or next(calls) == 1
        return {"reach": motion["reach"] * (np.nan if fails else 1)}

    monkeypatch.setattr(puppets.Reach, "terms", terms)
    run = puppet_run("search.elites=0")
    assert np.isinf(run.history["best"]).sum() == (5 if failing == "all" else 1)
    plot_fitness(run, tmp_path / "a.svg")
    assert "generations without a finite score are left out" in (tmp_path / "a.svg").read_text()


def test_a_run_without_a_generation_has_no_plot(puppet, tmp_path):
    run = RunSnapshot(create_run(puppet(), tmp_path / "run"))
    with pytest.raises(RunError, match="no finished generation"):
        plot_fitness(run, tmp_path / "a.png")


@pytest.mark.parametrize("name", ["a.gif", "a", ".png"])
def test_unknown_formats_are_rejected(spider_run, tmp_path, name):
    with pytest.raises(GaitsimError, match="not have the extension of a plot") as error:
        plot_fitness(spider_run, tmp_path / name)
    assert error.value.allowed == ".png, .svg, .pdf"


def with_history(run, monkeypatch, **columns):
    """Return the run with columns of its history replaced or added."""
    history = run.history | columns
    monkeypatch.setattr(type(run), "history", property(lambda self: history))
    return run


def test_the_band_shows_quartiles_if_the_history_has_them(spider_run, monkeypatch):
    low, high = spider_run.history["mean"] - 1, spider_run.history["mean"] + 3
    columns = {"lower quartile": low, "upper quartile": high}
    (axes,) = fitness_figure(with_history(spider_run, monkeypatch, **columns)).axes
    (band,) = axes.collections
    assert band.get_label() == "quartiles"
    corners = band.get_paths()[0].vertices
    for generation in (1, 2, 3):
        assert {low[generation - 1], high[generation - 1]} <= {
            y for x, y in corners if x == generation
        }


def test_scores_of_two_stages_are_not_joined(puppet_run, monkeypatch):
    run = with_history(puppet_run(), monkeypatch, stage=np.array([1.0, 1, 1, 2, 2]))
    (axes,) = fitness_figure(run).axes
    best = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert [line.get_xdata().tolist() for line in best[:2]] == [[1, 2, 3], [4, 5]]
    assert [text.get_text() for text in axes.texts] == ["stage 2"]
    assert axes.texts[0].xy[0] == 3.5
    panels = terms_figure(run, LIGHT).axes
    assert all(len(line.get_xdata()) <= 3 for axes in panels for line in axes.lines)


def test_saved_champions_are_marked(puppet_run):
    run = puppet_run("evolution.fitness_threshold=-100", "evolution.delta_fitness=0.01")
    kept = sorted(int(path.stem[-6:]) for path in (run.path / "champions").iterdir())
    assert kept
    (axes,) = fitness_figure(run).axes
    marks = {line.get_label().split(":")[0]: line for line in axes.lines}
    assert marks["saved champion"].get_xdata().tolist() == kept
    best = run.individual()
    number, score = best.generation, best.score
    assert marks["champion"].get_xydata().tolist() == [[number, score]]


def test_the_best_of_each_island_is_drawn(puppet_run):
    run = puppet_run("islands.number=3", "islands.migrants=1")
    (axes,) = fitness_figure(run).axes
    drawn = [line.get_ydata().tolist() for line in axes.lines[:3]]
    assert drawn == run.islands.T.tolist()
    assert [line.get_label() for line in axes.lines[:2]] == ["best of each of 3 islands", "_child1"]

"""`gaitsim design`, `gs.design` and the plots, on a body whose best design is known."""

import csv
import json
import shutil

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.storage.snapshot import RunSnapshot

ERRORS = [
    (("--dimensions", "arn"), "did you mean 'arm'?"),
    (("--dimensions", "arm=1.1:1.3"), "with the original, 1, in between"),
    (("--dimensions", "arm=1.2:0.8"), "invalid range of the dimension 'arm': 1.2 to 0.8"),
    (("--dimensions", "leg=0.05:1.2"), "factors from 0.2 to 5"),
    (("--dimensions", "leg=long"), "invalid range of the dimension 'leg': 'long'"),
    (("--levels", "2"), "--levels"),
    (("--from", "nowhere"), "nowhere"),
    (("--set", "organism.dimensions={arm=1.1}"), "both set and evolved"),
]


def rows(folder):
    with (folder / "exports/designs.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_planted_design_is_found_and_the_useless_dimension_named(mapped, gaitsim):
    done = gaitsim("design", "crawler-designs", "--json")
    found = json.loads(done.stdout)
    arm, leg = found["designs"][found["best"]]
    assert (arm, leg) == pytest.approx((1.2, 0.8), abs=0.11)
    score = found["quantities"]["score"]
    top = max(one for one in score["mean"] if one is not None)
    assert top > 1.97  # the best on the grid is 1.99
    assert score["vs_original"][found["original"]] == 0
    assert score["vs_original"][found["best"]] == 1
    assert score["r_squared"] > 0.99
    assert sum(score["variance_explained"].values()) == pytest.approx(1, abs=0.05)
    assert found["original"] not in found["plateau"]
    assert found["best"] in found["plateau"]
    assert set(found["failures"].values()) == {"its leg is too long"}
    assert len(found["failures"]) == 7
    assert found["servos"] == {}
    table = rows(mapped)
    assert [int(row["original"]) for row in table].index(1) == found["original"]
    assert float(table[found["best"]]["score"]) == top
    assert float(table[0]["leg (m)"]) == pytest.approx(0.7 * 0.2)
    text = gaitsim("design", mapped).stdout
    assert "Plateau:" in text
    assert "7 designs do not walk" in text


def test_a_tail_that_does_not_matter_has_no_share(crawler, gaitsim):
    options = "--dimensions", "arm,leg=0.7:1.2,tail", "--sample", 30, "--original", 6, "--json"
    found = json.loads(gaitsim("design", crawler, *options).stdout.splitlines()[-1])
    explained = found["quantities"]["score"]["variance_explained"]
    assert explained["tail"] < 0.02 < explained["leg"]
    assert len(found["designs"]) == 30


def test_a_stopped_map_continues_to_the_same_bits(crawler, gaitsim, tmp_path):
    short = "--levels", 3, "--replicates", 2, "--original", 3, "--polish", 3
    gaitsim("design", crawler, *short, "--out", "whole")

    class Stopped(Exception):
        pass

    def stop(generation):
        if generation in (2, 5):
            raise Stopped

    options = {"levels": 3, "replicates": 2, "original": 3, "polish": 3}
    with pytest.raises(Stopped):
        gs.design(crawler, **options, out="parts", on_generation=stop)
    early = gaitsim("plot", "parts", "--kind", "design", code=2).stderr
    assert "still evolves gaits of the original" in early
    with pytest.raises(Stopped):
        gs.design("parts", on_generation=stop)
    gaitsim("design", "parts")
    whole, parts = (RunSnapshot(tmp_path / name) for name in ("whole", "parts"))
    assert parts.generation == 7
    assert parts.fingerprint() == whole.fingerprint()
    assert gs.verify("parts").identical


def test_known_gaits_start_a_map_and_reach_the_speed(crawler, gaitsim, tmp_path):
    gaitsim("run", crawler)
    options = {"levels": 3, "replicates": 2, "polish": 4, "speed": 1.5}
    found = gs.design(crawler, ["arm"], start=["crawler"], **options)
    assert found.experiment.evolution.generations == 5
    state = found.run.finished.state
    champion = gs.load("crawler").champion.genome
    np.testing.assert_array_equal(state["known"], champion[None])
    assert found.quantities["speed"].values.max() > 1.5
    shown = gaitsim("design", "crawler-designs").stdout
    assert "Gaits should reach 1.5 m/s" in shown


@pytest.mark.parametrize(("options", "words"), ERRORS)
def test_mistakes_are_explained_before_a_run_is_created(options, words, crawler, gaitsim, tmp_path):
    assert words in gaitsim("design", crawler, *options, code=2).stderr
    assert not (tmp_path / "runs").exists()


def test_other_bodies_and_folders_are_refused(crawler, finished, gaitsim, tmp_path):
    assert "3 genes" in gaitsim("design", crawler, "--from", "puppet", code=2).stderr
    assert "has no dimensions" in gaitsim("design", "puppet.toml", code=2).stderr
    assert "is not a map of designs" in gaitsim("design", "runs/puppet", code=2).stderr
    assert "neither a body nor a map" in gaitsim("design", tmp_path, code=2).stderr
    assert "not a map" in gaitsim("plot", "puppet", "--kind", "design", code=2).stderr


def test_a_damaged_map_is_an_error_and_not_a_crash(mapped, gaitsim):
    for name in ("population.pickle", "population.previous.pickle"):
        path = mapped / name
        path.write_bytes(path.read_bytes()[:-40] + bytes(40))
    assert "Traceback" not in gaitsim("design", mapped, code=2).stderr


def test_a_link_in_the_exports_is_not_followed(mapped, gaitsim, tmp_path):
    shutil.rmtree(mapped / "exports")
    (tmp_path / "elsewhere").mkdir()
    (mapped / "exports").symlink_to(tmp_path / "elsewhere")
    assert "symbolic link" in gaitsim("design", mapped, code=2).stderr
    assert not list((tmp_path / "elsewhere").iterdir())


@pytest.mark.parametrize("options", [(), ("--dimensions", "arm,leg=0.7:1.2,tail", "--sample", 12)])
def test_the_plot_shows_each_quantity(options, crawler, gaitsim, tmp_path):
    small = "--levels", 4, "--original", 3, "--polish", 2, "--out", "small"
    gaitsim("design", crawler, *small, *options)
    gaitsim("plot", "small", "--kind", "design", "--out", tmp_path / "map.svg")
    drawn = (tmp_path / "map.svg").read_text()
    for words in ("speed", "cost of transport", "original"):
        assert words in drawn
    assert ("plateau of the score" in drawn) == (not options)

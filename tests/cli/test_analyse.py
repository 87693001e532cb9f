"""Input and output of `gaitsim analyse`."""

import re
from pathlib import Path

import numpy as np
import pytest
from run_helpers import strict

from gaitsim.gait import analyse_individual, with_damage
from gaitsim.gait.gait_files import gait_of, write_gait
from gaitsim.storage.snapshot import RunSnapshot

GAITS = Path(__file__).parents[2] / "data/gaits"
SMALL = ("--population", 10, "--generations", 3)


@pytest.fixture
def spider(gaitsim, tmp_path, once):
    """Evolve ten spiders for three generations, and return the run."""
    path = tmp_path / "runs/spider"
    return RunSnapshot(once("spider", path, lambda: gaitsim("run", "spider", *SMALL)))


def test_the_gait_and_its_score_are_explained(gaitsim, spider):
    shown = gaitsim("analyse", "spider")
    assert shown.stderr == ""
    assert "\x1b" not in shown.stdout
    best = spider.individual()
    generation, score = best.generation, best.score
    for text in (
        f"runs/spider, best of generation {generation}",
        "Gait: ",
        "33 ms per character",
        "L1 ",
        "R4 ",
        "Froude number",
        "least margin",
        f"Score analysis: {score:.4f}".replace("-", "−"),
        "term, if the motion ended at",
        f"of {generation}",
    ):
        assert text in shown.stdout
    assert "Robustness to perturbations" not in shown.stdout
    assert "The run recorded" not in shown.stdout


def test_a_damaged_body_is_analysed_and_plotted(gaitsim, spider, tmp_path):
    damage = ("--damage", "L2 lost", "--damage", "R1 femur stuck 20")
    found = strict(gaitsim("analyse", "spider", *damage, "--json").stdout)
    duty = {foot["name"]: foot["duty_factor"] for foot in found["feet"]}
    assert duty.pop("L2") == 0
    assert len(duty) == 7
    hurt = with_damage(spider.individual(), ["L2 lost", "R1 femur stuck 20"])
    assert found["travel"]["forward"] == pytest.approx(hurt.measures["forward"])
    gaitsim("plot", "spider", "--kind", "footfall", *damage)
    assert [*tmp_path.glob("runs/spider/exports/footfall-*-L2-lost--R1-femur-stuck-20.png")]
    assert "L2 lost" in gaitsim("play", "spider", "--at", 1, *damage).stdout
    for wrong, said in (("L9 lost", "L1, L2"), ("L1 femur weak", "spider-physics")):
        assert said in gaitsim("analyse", "spider", "--damage", wrong, code=2).stderr
    refused = gaitsim("plot", "spider", "--kind", "fitness", *damage, code=2).stderr
    assert "has no option --damage" in refused


def test_a_body_is_analysed_and_played_in_a_different_world(gaitsim, tmp_path):
    gaitsim("run", "walker", "--population", 4, "--generations", 1, "--set", "organism.duration=2")
    ice = ("--world", "friction 0.1", "--world", "servo_torque=0.7")
    usual, found = (
        strict(gaitsim("analyse", "walker", *world, "--json").stdout) for world in ((), ice)
    )
    assert found["score"] != usual["score"]
    assert "friction 0.1, servo_torque 0.7" in gaitsim("play", "walker", "--at", 1, *ice).stdout
    for wrong, said in (("ice 1", "friction"), ("friction 9", "0 to 5"), ("friction", "a number")):
        assert said in gaitsim("analyse", "walker", "--world", wrong, code=2).stderr


def test_the_diagram_shows_the_contacts_of_the_feet(gaitsim, spider):
    shown = gaitsim("analyse", "spider", "--gait", GAITS / "alternating-tetrapod.npz").stdout
    assert (
        "Gait: alternating tetrapod, the feet touch down within 0.000 cycles (rms) of this pattern"
        in shown
    )
    rows = dict(line.split() for line in shown.splitlines() if re.match(r"[LR]\d [█·]+$", line))
    assert list(rows) == ["L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4"]
    assert set(map(len, rows.values())) == {48}  # two strides of 24 frames
    assert rows["L1"] == rows["R2"] == rows["L3"] == rows["R4"]
    assert rows["R1"] == rows["L2"] == rows["R3"] == rows["L4"]
    assert rows["L1"].count("█") == pytest.approx(24, abs=2)
    overlap = sum(a == b for a, b in zip(rows["L1"], rows["R1"], strict=True))
    assert overlap <= 4


def test_json_has_all_numbers(gaitsim, spider):
    found = strict(gaitsim("analyse", "spider", "--json", "--perturb").stdout)
    best = spider.individual()
    generation, score = best.generation, best.score
    kept = spider.individual()
    gait = analyse_individual(kept)
    assert (found["run"], found["generation"]) == ("runs/spider", generation)
    assert found["score"] == found["recorded_score"] == score
    assert sum(found["terms"].values()) == pytest.approx(score)
    assert found["name"] == gait.name.name
    assert found["travel"]["froude"] == gait.travel.froude
    assert [foot["name"] for foot in found["feet"]] == [foot.name for foot in gait.footfalls.feet]
    touching = np.array([foot["touching"] for foot in found["feet"]], dtype=bool).T
    assert (touching == kept.motion["stance"][0]).all()
    assert found["stability"]["margin"] == pytest.approx(gait.footfalls.margin.tolist())
    assert found["terms_over_time"]["terms"]["forward"][-1] == found["terms"]["forward"]
    assert found["terms_over_generations"]["first_generation"] == 1
    assert found["robustness"]["perturbations"][0] == {
        "name": "played again", "score": pytest.approx(score), "fall": pytest.approx(0, abs=1e-9),
        "sign": "",
    }  # fmt: skip
    assert found["summary"]
    assert found["figure"] is None


def test_a_gait_from_a_file_is_analysed(gaitsim, spider, tmp_path):
    champion = strict(gaitsim("analyse", "spider", "--json").stdout)
    for format in ("mat", "csv", "npz"):
        path = tmp_path / f"gait.{format}"
        write_gait(gait_of(spider.individual()), path, format)
        found = strict(gaitsim("analyse", "spider", "--gait", path.name, "--json").stdout)
        assert found["subject"] == f"gait.{format} on the spider"
        assert found["score"] == pytest.approx(champion["score"])
        assert found["feet"] == champion["feet"]
        assert found["terms_over_generations"] is found["recorded_score"] is None
    shown = gaitsim("analyse", "spider", "--gait", GAITS / "flip-flop.npz", "--perturb").stdout
    assert "Likely exploit: flip-flop. " in shown
    assert "No servo can follow" in shown
    assert gaitsim("analyse", "spider", "--gait", "none.csv", code=2).stdout == ""


@pytest.mark.slow
def test_the_figure_is_drawn(gaitsim, spider, tmp_path):
    assert gaitsim("analyse", "spider", "--figure", "a.svg").stdout.endswith("\na.svg\n")
    gaitsim("analyse", "spider", "--figure", "b.svg", "--json")
    assert (tmp_path / "a.svg").read_text() == (tmp_path / "b.svg").read_text()
    gaitsim("analyse", "spider", "--gait", GAITS / "standing.npz", "--figure", "c.png")
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
    assert gaitsim("analyse", "spider", "--figure", "none/a.png", code=2).stdout == ""


def test_a_body_without_feet_has_a_score_but_no_gait(gaitsim, puppet_file, tmp_path):
    gaitsim("run", puppet_file)
    shown = gaitsim("analyse", "puppet", "--perturb").stdout
    assert "Gait: none, the body has no feet" in shown
    assert "reach " in shown
    found = strict(gaitsim("analyse", "puppet", "--json").stdout)
    assert found["feet"] is found["stride"] is found["stability"] is found["slip"] is None
    done = gaitsim("analyse", "puppet", "--figure", "a.png", code=2)
    assert "the body has no feet, so there are no footfalls to draw" in done.stderr
    assert not (tmp_path / "a.png").exists()


@pytest.fixture
def walker(gaitsim):
    """Evolve walkers for one second of motion."""
    gaitsim("run", "walker", *SMALL, "--set", "organism.duration=1")


def test_a_gait_is_evaluated_in_unseen_worlds(gaitsim, walker, tmp_path):
    command = ("analyse", "walker", "--worlds", 12, "--workers", 1)
    shown = gaitsim(*command, "--figure", "worlds.png")
    assert "In 12 unseen worlds" in shown.stdout
    assert (tmp_path / "worlds.png").read_bytes().startswith(b"\x89PNG")
    found = strict(gaitsim(*command, "--json").stdout)["unseen_worlds"]
    assert len(found["worlds"]) == found["number"] == 12
    results = [one["result"] for one in found["worlds"]]
    assert found["median"] == np.median(results)
    others = strict(gaitsim("analyse", "walker", "--worlds", 2, "--world-seed", 7, "--json").stdout)
    assert others["unseen_worlds"]["worlds"][0]["world"] != found["worlds"][0]["world"]


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--worlds", 0), "number of worlds"),
        (("--world-seed", 3), "--worlds"),
    ],
)
def test_invalid_worlds_are_rejected(gaitsim, options, named):
    assert named in gaitsim("analyse", "walker", *options, code=2).stderr


@pytest.mark.slow
def test_a_gait_is_played_in_a_second_engine(gaitsim, spider):
    assert "only one engine" in gaitsim("play", "spider", "--engine", "bullet", code=2).stderr
    pytest.importorskip("pybullet")
    gaitsim("run", "quadruped", *SMALL, "--set", "organism.duration=0.5")
    found = strict(gaitsim("analyse", "quadruped", "--engine", "bullet", "--json").stdout)
    (forward,) = (one for one in found["engine"] if one["name"] == "forward")
    assert forward["mujoco"] == pytest.approx(found["travel"]["forward"])
    assert np.isfinite(forward["bullet"])
    assert forward["bullet"] != forward["mujoco"]
    shown = gaitsim("analyse", "quadruped", "--engine", "bullet").stdout
    assert "The same gait in the engine bullet" in shown

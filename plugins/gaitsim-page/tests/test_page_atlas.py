"""Pages of archives: all cells, and the same gaits as in Python."""

import json
from itertools import product

import numpy as np
import pytest
from javascript import CHROMIUM, call

from gaitsim.contracts.quaternions import rotated
from gaitsim.errors import NothingToPlotError
from gaitsim.evaluation.scoring import move_genomes
from gaitsim.experiment import load_experiment
from gaitsim.individual import Member
from gaitsim.render.archive_view import ArchiveView
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim_page.atlas import SCRIPTS, atlas_data, rig_of, write_atlas
from gaitsim_page.document import asset
from gaitsim_page.gaits import MAX_WAVE_ERROR, SETTLED, gaits_data, stride_of
from gaitsim_page.packing import unpack

DRAWING = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--disable-quic")
HALF_STEP = np.radians(0.2)
GRID = "search.plugin=map-elites", "search.axes={ reach = [-3, 3], price = [-1, 0] }"


def in_waves(data, count):
    """Return the joint angles (individuals, frames, joints) of a page with waves."""
    waves = unpack(data["waves"])
    amounts = unpack(data["amounts"]).reshape(count, len(data["joints"]), -1) + data["lowest"]
    return (amounts @ waves).swapaxes(1, 2)


def in_strides(data):
    """Return the joint angles (frames, joints) of each stride in a page's data."""
    changes = unpack(data["amounts"]).ravel() + data["lowest"]
    lengths = unpack(data["lengths"]).astype(int)
    parts = np.split(changes, np.cumsum(lengths * len(data["joints"]))[:-1])
    return [
        part.reshape(len(data["joints"]), length).cumsum(axis=1).T
        for part, length in zip(parts, lengths, strict=True)
    ]


PLACING = """
const bodies = data.bodies ? await unpackJson(data.bodies) : [data.body];
const gaits = await Gaits.read(data.gaits);
return [...Array(data.count).keys()].map((i) => {
  const shape = bodies[data.bodies ? i : 0];
  const angles = gaits.at(i, 0);
  const pose = shape && new Rig(shape).place(angles);
  return pose && { ...pose, angles: [...angles], points: [...pose.points] };
});
"""


def placed_by_page(data):
    """Return the pose of each gait at the start, as a page places it, with its joint angles."""
    scripts = [asset(name) for name in ("unpack.js", *SCRIPTS[:2])]
    gaitsim = "const gaitsim = { unpack };"
    return call("\n".join([*scripts, gaitsim]), PLACING, json.loads(json.dumps(data)))


def test_gaits_of_one_frequency_are_sums_of_two_waves():
    experiment = load_experiment("spider-atlas")
    genomes = experiment.space().random(120, np.random.default_rng(1))
    counts: list[int] = []
    found = gaits_data(experiment, genomes, workers=1, begin=counts.append, advance=counts.append)
    data = json.loads(json.dumps(found))
    assert data["waves"]["shape"] == [2, 300]
    assert counts[0] == sum(counts[1:]) == 120
    apart = np.abs(in_waves(data, 120) - move_genomes(experiment, genomes)["joint_angles"])
    assert apart.max() <= data["error"] + 1e-12
    assert data["error"] <= MAX_WAVE_ERROR
    assert len(data["amounts"]["data"]) < 170 * 120  # larger archives need less per gait


def test_other_gaits_are_stored_as_strides():
    experiment = load_experiment("spider-atlas", {"organism.encoding": "cpg"})
    genomes = experiment.space().random(5, np.random.default_rng(2))
    data = json.loads(json.dumps(gaits_data(experiment, genomes, workers=1)))
    assert data["form"] == "strides"
    assert unpack(data["periods"]) == pytest.approx(20, abs=0.05)  # 1.5 Hz at 30 Hz
    angles = move_genomes(experiment, genomes)["joint_angles"]
    for stride, played in zip(in_strides(data), angles, strict=True):
        first = int(SETTLED * len(played))
        apart = np.abs(stride - played[first : first + len(stride)]).max()
        assert apart <= min(data["error"] + 1e-12, HALF_STEP)


@pytest.mark.parametrize("period", [17.3, 48.6])
def test_a_stride_is_found_after_the_start_and_before_a_fall(period):
    turns = 2 * np.pi * np.arange(250)[:, None] / period + [0, 1, 2]
    angles = np.sin(turns) + 0.3 * np.sin(2 * turns)
    angles *= np.clip(np.arange(250) / 25, 0, 1)[:, None]
    angles[200:] = angles[200]
    found, stride = stride_of(angles)
    assert found == pytest.approx(period, abs=0.02)
    assert len(stride) == np.ceil(period) + 1
    assert (stride == angles[30 : 30 + len(stride)]).all()


@pytest.mark.parametrize("angles", [np.zeros((9, 2)), np.eye(40)[:, :1], np.ones((1, 1))])
def test_a_motion_that_does_not_repeat_is_kept_whole(angles):
    period, stride = stride_of(angles)
    assert 0 <= period <= len(angles)
    assert 1 <= len(stride) <= len(angles)


@pytest.mark.parametrize("cells", ["[4, 5]", "30"])
def test_a_map_without_joint_angles_has_all_cells(puppet_run, tmp_path, cells):
    run = puppet_run(*GRID, f"search.cells={cells}")
    data = json.loads(json.dumps(atlas_data(run)))
    members, view = run.members, ArchiveView.of(run.members)
    assert data["gaits"] is None
    assert data["body"] is None
    assert unpack(data["scores"])[0] == pytest.approx(members.scores, rel=1e-4, abs=1e-3)
    panel = view.panel("reach", "price")
    if cells == "30":
        assert (unpack(data["raster"]) == panel.members).all()
    else:
        places = tuple(unpack(axis["places"])[0].astype(int) for axis in data["axes"])
        assert (panel.members[places] == np.arange(1, len(members.scores) + 1)).all()
    summary = write_atlas(run, tmp_path / "atlas.html")
    assert "no motions" in summary


SMALL = "--generations", "1", "--population", "20", "--out", "run"
OWN = {
    "creature-zoo": ("organism.duration=1", "organism.most=6"),
    "hexapod-atlas": ("organism.duration=1", "organism.evolve=['tibia']"),
    "spider-atlas": ("organism.evolve=['femur']",),
}


@pytest.mark.parametrize("preset", OWN)
def test_gaits_with_bodies_of_their_own_are_placed_as_in_python(preset, gaitsim, tmp_path):
    gaitsim("run", preset, *(part for one in OWN[preset] for part in ("--set", one)), *SMALL)
    run = RunSnapshot(tmp_path / "run")
    data = atlas_data(run, workers=1)
    assert data["body"] is None
    poses = placed_by_page(data)
    assert len(poses) == len(run.members.scores) > 1
    assert len({json.dumps(spans(pose["feet"]).round(6).tolist()) for pose in poses}) > 1
    for number, pose in enumerate(poses, 1):
        one = run.individual(Member(number))
        assert len(pose["angles"]) == len(one.body.joint_names())
        if pose["angles"]:
            apart = np.abs(one.joint_angles - pose["angles"]).max(axis=1)
            assert apart.min() <= HALF_STEP + 1e-9
        rig = rig_of(one)
        placed = rig.place(np.array(pose["angles"]))
        assert spans(pose["feet"]) == pytest.approx(spans(placed.feet), abs=1e-6)
        if len(placed.poses):  # level, and raised as a whole
            moved = np.reshape(pose["poses"], (-1, 7)) - placed.poses
            assert np.ptp(moved, axis=0) == pytest.approx(0.0, abs=1e-6)
        if preset == "creature-zoo":  # on its lowest corner
            corners = [
                place[:3] + rotated(place[3:], np.array(sign) * solid.size)
                for place, solid in zip(np.reshape(pose["poses"], (-1, 7)), rig.solids, strict=True)
                for sign in product((-1, 1), repeat=3)
            ]
            assert min(z for _, _, z in corners) == pytest.approx(0.0, abs=1e-6)


def spans(feet):
    """Return the distances between feet, (feet, feet) m."""
    feet = np.reshape(feet, (-1, 3))
    return np.linalg.norm(feet[:, None] - feet, axis=-1)


def test_gaits_of_one_body_share_its_rig(bundled):
    data = atlas_data(bundled("spider-atlas"), workers=1)
    assert data["bodies"] is None
    assert "counts" not in data["gaits"]
    assert data["body"]["rests"]


def test_a_search_without_an_archive_is_rejected(puppet_run):
    with pytest.raises(NothingToPlotError, match="keeps no archive"):
        atlas_data(puppet_run())


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_the_page_plays_gaits_without_network_requests(bundled, tmp_path):
    playwright = pytest.importorskip("playwright.sync_api", reason="needs Playwright")
    run = bundled("spider-atlas")
    write_atlas(run, tmp_path / "atlas.html")
    genomes = run.members.genomes
    angles = move_genomes(run.experiment, genomes)["joint_angles"]
    messages, requests = [], []
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=DRAWING)
        page = browser.new_context(offline=True).new_page()
        page.on("console", lambda message: messages.append(message.text))
        page.on("pageerror", lambda problem: messages.append(str(problem)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto((tmp_path / "atlas.html").as_uri())
        page.wait_for_selector("#chosen h2")
        best = int(run.members.scores.argmax())
        assert page.evaluate("gaitsimPage.member") == best
        decoded = (
            "(n) => [...Array(n).keys()].map((i) => gaitsimPage.anglesOf(i).map((a) => [...a]))"
        )
        assert (
            np.abs(np.array(page.evaluate(decoded, len(genomes))) - angles).max() <= MAX_WAVE_ERROR
        )
        shown = "Array.from(gaitsimPage.body.pose.points)"
        before = page.evaluate(shown)
        page.focus("canvas.cells")
        for key in ("ArrowLeft", "ArrowDown", "ArrowRight", "ArrowUp"):
            page.keyboard.press(key)
            if page.evaluate("gaitsimPage.member") != best:
                break
        other = page.evaluate("gaitsimPage.member")
        assert other != best
        page.evaluate("gaitsimPage.play(false); gaitsimPage.clock.now = 0; gaitsimPage._show()")
        assert page.evaluate(shown) != before
        # At the start, the body is as in a drawing: it leans, with standing feet on the ground.
        skeleton = run.individual(Member(other + 1)).skeleton
        feet = np.array(page.evaluate("gaitsimPage.body.pose.feet")).reshape(-1, 3)
        moved = feet - skeleton.contacts[0]
        assert np.ptp(moved, axis=0) == pytest.approx([0, 0, 0], abs=1e-4)
        down = np.array(page.evaluate("Array.from(gaitsimPage.body.pose.touching)"), bool)
        assert down.sum() >= 3
        assert np.ptp(feet[down, 2]) < 0.0025
        page.click("table button >> nth=1")
        ranked = np.argsort(-run.members.scores, kind="stable")
        assert page.evaluate("gaitsimPage.member") in ranked[:3]
        assert messages == []
        assert requests == [(tmp_path / "atlas.html").as_uri()]

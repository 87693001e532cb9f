"""Members of a front, chosen by number to list, show, export or start from."""

import json

import numpy as np
import pytest

import gaitsim as gs

SEARCH = """[search]
plugin = "nsga-2"
objectives = { price = "max", reach = "max" }
"""


@pytest.fixture
def front(gaitsim, puppet_file, tmp_path, once):
    """Evolve a run with a front, and return its members as JSON."""
    puppet_file.write_text(puppet_file.read_text().partition("[search]")[0] + SEARCH)
    path = tmp_path / "runs/puppet"
    once("front", path, lambda: gaitsim("run", puppet_file, "--population", 12))
    return [json.loads(line) for line in gaitsim("members", "puppet", "--json").stdout.splitlines()]


def test_members_are_listed_in_the_order_of_the_first_objective(gaitsim, front, tmp_path):
    assert [row["member"] for row in front] == list(range(1, len(front) + 1))
    assert list(front[0]) == ["member", "score", "price", "reach"]
    prices = [row["price"] for row in front]
    assert prices == sorted(prices)
    shown = gaitsim("members", "puppet").stdout
    assert "reach, m" in shown
    assert f"{len(front)} member" in shown
    assert f"{len(front)} member" in gaitsim("show", "puppet").stdout
    gaitsim("members", "puppet", "--out", "front.csv")
    first, *rows = (tmp_path / "front.csv").read_text().splitlines()
    assert first == "member,score,price,reach"
    assert [float(row.split(",")[3]) for row in rows] == [row["reach"] for row in front]


def test_all_commands_return_the_same_member(gaitsim, front, tmp_path):
    number, last = len(front), front[-1]
    member = gs.load("runs/puppet").replay(member=number)
    genome = member.genome
    assert member.score == pytest.approx(member.replayed_score) == last["score"]
    assert member.terms == pytest.approx({"price": last["price"], "reach": last["reach"]})
    np.testing.assert_array_equal(gs.load("runs/puppet").members.genomes[-1], genome)

    assert (
        f"member {number} of generation 5"
        in gaitsim("play", "puppet", "--member", number, "--at", 0).stdout
    )
    analysis = json.loads(gaitsim("analyse", "puppet", "--member", number, "--json").stdout)
    assert (analysis["member"], analysis["score"]) == (number, pytest.approx(last["score"]))
    assert analysis["terms_over_generations"] is None  # it is not the best of any generation
    gaitsim("export", "puppet", "--member", number, "--format", "csv")
    file = tmp_path / f"runs/puppet/exports/gait-generation-5-member-{number}.csv"
    angles = [float(cell) for cell in file.read_text().splitlines()[-1].split(",")[-3:]]
    np.testing.assert_allclose(angles, genome)
    drawn = gaitsim("plot", "puppet", "--kind", "joints", "--member", number).stdout
    assert f"joints-generation-5-member-{number}.png" in drawn

    gaitsim("run", "puppet.toml", "--from", f"puppet#{number}", "--out", "b")
    assert gs.load("b").snapshot.start.genomes.tobytes() == genome.tobytes()


def test_a_member_can_be_chosen_by_values(gaitsim, front):
    least, most = front[0]["price"], front[-1]["price"]
    near = [row for row in front if row["price"] - least <= 0.05 * (most - least)]
    best = max(near, key=lambda row: row["score"])
    shown = gaitsim("analyse", "puppet", "--member", f"price={least - 1}", "--json").stdout
    assert json.loads(shown)["member"] == best["member"]
    (exact,) = {row["member"] for row in front if row["price"] == most}
    both = f"price={most},reach={front[-1]['reach']}"
    shown = gaitsim("play", "puppet", "--member", both, "--at", 0).stdout
    assert f"member {exact} of" in shown


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("play", "puppet", "--member", 99), "has no member 99"),
        (("play", "puppet", "--member", 1, "--generation", 1), "--generation, --member"),
        (("play", "puppet", "--member", "prize=1"), "unknown axis 'prize'"),
        (("video", "puppet", "--generations", "1,2", "--member", 1), "--member, --generations"),
        (("members", "puppet", "--out", "front.txt"), "FILE.csv"),
    ],
)
def test_invalid_members_are_rejected(gaitsim, front, arguments, says):
    assert says in " ".join(gaitsim(*arguments, code=2).stderr.replace("│", " ").split())


def test_an_archive_is_printed_as_a_map(gaitsim, puppet_file):
    archive = """[search]
plugin = "map-elites"
axes = { price = [-1.0, 0.0], reach = [-1.0, 3.0], score = [-2.0, 3.0] }
cells = [8, 9, 3]
"""
    puppet_file.write_text(puppet_file.read_text().partition("[search]")[0] + archive)
    gaitsim("run", puppet_file, "--population", 30)
    shown = gaitsim("members", "puppet", "--map").stdout
    scores = gs.load("runs/puppet").members.scores
    assert f"member {scores.argmax() + 1}, the best" in shown
    assert f"{len(scores)} of 216 cells" in shown
    assert "◆" in shown
    assert "↑ reach (m)" in shown
    turned = gaitsim("members", "puppet", "--map", "--axes", "reach", "score").stdout
    assert "reach (m) →" in turned
    for options in (("--map", "--axes", "reach", "height"), ("--axes", "reach", "price")):
        assert gaitsim("members", "puppet", *options, code=2).stderr

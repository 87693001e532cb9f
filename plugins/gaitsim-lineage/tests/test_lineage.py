"""Lines of ancestors, whose gains are known in closed form."""

import json
from functools import partial

import networkx as nx
import numpy as np
import pytest

import gaitsim as gs
from gaitsim.evaluation import evaluate
from gaitsim.individual import Numbered
from gaitsim.storage.replaying import breed_again
from gaitsim.storage.writer import RunWriter
from gaitsim_lineage import genealogy
from gaitsim_lineage.genealogy import Genealogy, line_of
from gaitsim_lineage.lineage import lineage

UNIFORM = ("crossover.plugin=uniform", "mutation.plugin=gaussian")
ARCHIVE = ("search.plugin=map-elites", "search.axes.reach=[-2, 3]", "search.cells=[8]")
FRONT = ("search.plugin=nsga-2", "search.objectives.reach=max", "search.objectives.price=max")
SEARCHES = {
    "genetic": UNIFORM,
    "islands": (*UNIFORM, "islands.number=2", "islands.every=3"),
    "front": FRONT,
    "archive": ARCHIVE,
    "cma-es": ("search.plugin=cma-es",),
    "restarts": ("search.plugin=cma-es", "search.tolerance=0.09", "evolution.generations=40"),
    "emitters": (*ARCHIVE, "search.variation=cma-me", "search.emitters=2"),
    "age-fitness": ("search.plugin=age-fitness", *UNIFORM),
}


@pytest.mark.parametrize("search", SEARCHES)
def test_every_step_is_as_recorded_and_its_gain_follows(line_run, score_of, search):
    run, evolved = line_run(*SEARCHES[search])
    found = lineage(run)
    assert found.named == (search != "emitters")
    assert np.array_equal(found.steps[-1].genome, found.individual.genome)
    before = None
    for step in found.steps:
        then = evolved[step.place.generation - 1]
        if step.place.number:
            row = step.place.number - 1
            assert np.array_equal(step.genome, then.genomes[row])
            assert step.score == step.recorded == then.scores[row]
        assert step.score == pytest.approx(score_of(step.genome))
        assert step.reproduced
        if before is not None:
            ends = before.place.generation, step.place.generation
            assert ends[0] < ends[1] or (ends[0] == ends[1] and not before.place.number)
            assert step.gain == pytest.approx(score_of(step.genome) - score_of(before.genome))
            changed = {change.gene for change in step.changes}
            assert changed == {*np.flatnonzero(step.genome != before.genome)}
            assert sum(step.terms.values()) == pytest.approx(step.gain)
        before = step


def test_the_centres_are_the_means_of_the_distribution(line_run):
    run, evolved = line_run("search.plugin=cma-es", "search.restarts=none")
    space = run.experiment.space()
    *centres, last = lineage(run, 15).steps
    assert [step.how for step in centres[1:]] == ["centre moved"] * 14
    assert last.how == "sample"
    for generation, step in enumerate(centres, 1):
        assert step.place == Numbered(generation, 0)
        if generation > 1:
            mean = evolved[generation - 2].state["mean"]
            if ((mean >= 0) & (mean <= 1)).all():
                assert step.genome == pytest.approx(space.lower + mean * space.width, abs=1e-2)
    which = Numbered(7, 0)
    assert lineage(run, which).steps[-1].place == which
    assert len(lineage(run, which).steps) == 7
    assert np.array_equal(run.individual(which).genome, centres[6].genome)
    assert run.individual(which).score == centres[6].score


def test_changes_alone_bring_their_share_of_a_gain(line_run, score_of):
    run, _ = line_run(*UNIFORM)
    found = lineage(run, explain=100)
    tried = [index for index in found.rises if len(found.steps[index].changes) > 1]
    assert tried
    for index in tried:
        step, parent = found.steps[index], found.steps[index - 1].genome
        total = 0.0
        for change in step.changes:
            alone = parent.copy()
            alone[change.gene] = change.after
            assert change.alone == pytest.approx(score_of(alone) - score_of(parent))
            assert change.without == pytest.approx(change.alone)  # the score is a sum over genes
            total += change.alone
        assert total == pytest.approx(step.gain)
        best = max(step.changes, key=lambda change: change.alone)
        assert step.what.startswith(best.name)
        assert (best.alone >= 0.9 * step.gain) == ("alone enough" in step.why)


def test_inherited_genes_are_those_of_the_other_parent(line_run):
    run, evolved = line_run(*UNIFORM, "mutation.rate=0")
    steps = lineage(run).steps
    assert len(steps) > 1
    for step in steps[1:]:
        assert step.how == "crossover"
        other = evolved[step.other.generation - 1].genomes[step.other.number - 1]
        for change in step.changes:
            assert change.inherited
            assert change.after == other[change.gene]


@pytest.mark.parametrize("probability", [0, 0.5])
def test_copies_of_a_parent_are_not_crossed(line_run, probability):
    run, _ = line_run(*UNIFORM, f"crossover.pair_probability={probability}")
    for step in lineage(run).steps[1:]:
        if not probability:
            assert step.how == "mutation"
            assert step.other is None
        assert any(one.inherited for one in step.changes) <= (step.other is not None)


@pytest.mark.parametrize("search", ["genetic", "archive", "front", "age-fitness"])
@pytest.mark.parametrize("generation", [2, 5, 10, 15])
def test_the_common_ancestor_by_brute_force(line_run, search, generation):
    run, _ = line_run(*SEARCHES[search])
    found = lineage(run, Numbered(generation, 1))
    lines = [{*line_of(found.living, int(row))} for row in found.alive]
    shared = set.intersection(*lines)
    expected = max((int(found.living.generation[row]) for row in shared), default=None)
    assert found.coalescence == expected


def test_equal_genomes_keep_their_own_lines(line_run):
    run, evolved = line_run("search.elites=6", *UNIFORM)
    number = 1 + int(np.argsort(-evolved[3].scores, kind="stable")[2])
    one, then = Numbered(5, 3), Numbered(4, number)
    assert np.array_equal(run.individual(one).genome, run.individual(then).genome)
    assert lineage(run, one).steps[-1].place == lineage(run, then).steps[-1].place
    assert str(lineage(run, then).steps[-1].place) in lineage(run, one).paragraph()


def test_scores_before_and_after_a_change_are_not_compared(line_run):
    run, _ = line_run(*UNIFORM)
    changes = {"fitness.price": 3.0, "evolution.generations": 25}
    with RunWriter.open(run.path, overrides=changes) as writer:
        for _ in writer.evolve(partial(evaluate, writer.experiment)):
            pass
    found = lineage(run.reopened())
    assert found.steps[-1].scale == (2, 1)
    assert found.records[-1] == len(found.steps) - 1
    assert "not all scores can be compared" in found.paragraph()
    assert all(step.reproduced for step in found.steps)
    border = next(at for at, step in enumerate(found.steps) if step.scale == (2, 1))
    step, parent = found.steps[border], found.steps[border - 1]
    scores = [np.sin(one).sum() - 3 * np.abs(one).sum() for one in (parent.genome, step.genome)]
    assert step.gain == pytest.approx(scores[1] - scores[0])


def test_copies_are_one_individual(line_run):
    run, _ = line_run("search.elites=11", *UNIFORM)
    places = [step.place for step in lineage(run).steps]
    assert len(places) == len({*places})
    for one, other in zip(lineage(run).steps, lineage(run).steps[1:], strict=False):
        assert not np.array_equal(one.genome, other.genome)


@pytest.mark.parametrize("search", SEARCHES)
def test_pruning_keeps_all_ancestors_of_the_living(line_run, monkeypatch, search):
    run, _ = line_run(*SEARCHES[search])

    def trace():
        found = Genealogy(run.experiment.space())
        for bred in breed_again(run, run.generation):
            found.add(bred)
        rows = found.rows
        lines = [line_of(rows, int(row)) for row in found.latest]
        return len(rows), [[rows.genomes[row].tobytes() for row in line] for line in lines]

    everyone, lines = trace()
    monkeypatch.setattr(genealogy, "FEWEST", 1)
    kept, same = trace()
    assert kept < everyone
    assert lines == same


def test_members_and_others_have_lines_of_their_own(line_run):
    run, evolved = line_run(*ARCHIVE)
    for which in (gs.Member(2), Numbered(4, 7), 6, {"reach": 1.0}):
        found = lineage(run, which)
        assert np.array_equal(found.steps[-1].genome, run.individual(which).genome)
    assert len(lineage(run, Numbered(1, 3)).steps) == 1
    assert np.array_equal(lineage(run, Numbered(1, 3)).steps[0].genome, evolved[0].genomes[2])


def test_the_tree_of_the_living_for_networkx(line_run):
    run, _ = line_run(*UNIFORM)
    found = gs.lineage(run.path)
    graph = found.to_networkx()
    assert nx.is_forest(graph.to_undirected())
    last = found.steps[-1].place
    place = last.generation, last.number
    ancestors = nx.ancestors(graph, place)
    assert ancestors == {(one.place.generation, one.place.number) for one in found.steps[:-1]}
    assert graph.nodes[place]["score"] == found.individual.score
    leaves = [node for node in graph if not graph.out_degree(node)]
    if found.coalescence is not None:
        assert all(
            any(one[0] == found.coalescence for one in {*nx.ancestors(graph, leaf), leaf})
            for leaf in leaves
        )


def test_the_command_and_its_json(line_run, gaitsim):
    run, _ = line_run(*UNIFORM)
    found = json.loads(gaitsim("lineage", run.path, "--json").stdout)
    assert found["text"] == lineage(run).paragraph()
    assert found["steps"] == json.loads(json.dumps(lineage(run).to_dicts()))
    text = gaitsim("lineage", run.path, "--all", "--explain", 0).stdout
    for step in found["steps"]:
        assert f"{step['generation']}:{step['number']} " in text
    count = len(found["steps"])
    assert f"{count} of {count} ancestors score as recorded" in text
    last = found["steps"][-1]
    place = f"{last['generation']}:{last['number']}"
    assert "gait" in gaitsim("export", run.path, "--generation", place, "--format", "npz").stdout


def test_a_film_and_a_page_of_ancestors(line_run, gaitsim, here):
    run, _ = line_run(*UNIFORM)
    gaitsim("lineage", run.path, "--video", "a.gif", "--page", "a.html")
    assert (here / "a.gif").read_bytes().startswith(b"GIF")
    shown = lineage(run).shown()
    page = (here / "a.html").read_text(encoding="utf-8")
    for one in shown:
        assert one.label in page
        assert one.note.split(" → ")[0] in page


@pytest.mark.parametrize("kind", ["lineage", "genealogy"])
@pytest.mark.parametrize("search", ["genetic", "cma-es"])
def test_the_plots(line_run, gaitsim, here, kind, search):
    run, _ = line_run(*SEARCHES[search])
    gaitsim("plot", run.path, "--kind", kind, "--out", "a.svg")
    text = (here / "a.svg").read_text(encoding="utf-8")
    assert "generation" in text
    if kind == "lineage":
        assert lineage(run).steps[lineage(run).rises[0]].what[:12] in text


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("nowhere",), "there is no run 'nowhere'"),
        (("{run}", "--generation", "1:13"), "no individual 13"),
        (("{run}", "--generation", "1:"), "invalid generation: '1:'"),
        (("{run}", "--generation", "16"), "no generation 16"),
        (("{run}", "--generation", "3:centre"), "has no centre"),
        (("{run}", "--member", "1"), "has no members"),
        (("{run}", "--explain", "-1"), "--explain"),
        (("{run}", "--video", "a.txt"), "--video"),
        (("{run}", "--page", "nowhere/a.html"), "there is no folder nowhere"),
    ],
)
def test_mistakes_get_one_message(line_run, gaitsim, options, message):
    run, _ = line_run()
    given = [one.format(run=run.path) for one in options]
    assert message in gaitsim("lineage", *given, code=2).stderr


async def test_the_cursor_walks_through_time(line_run, drive):
    run, _ = line_run(*UNIFORM)
    found = lineage(run)
    async with drive() as driver:
        await driver.press("H")
        screen = await driver.at("LineScreen")
        await driver.until(lambda: screen.canvas.skeleton is not None)
        assert screen.step.place == found.steps[-1].place
        await driver.press("up")
        assert screen.step.place == found.steps[-2].place
        await driver.press("g")
        await driver.until(lambda: screen.index == 0)
        assert "founder" in driver.text("#line-changes Static")
        await driver.press("l")
        assert screen.step.why
        assert screen.command_line() == "gaitsim lineage runs/puppet"
        place = screen.step.place
        await driver.press("r")
        replay = await driver.at("Replay")
        await driver.until(lambda: replay.pane.shown is not None)
        assert replay.pane.shown.individual.member == place
        await driver.press("escape")
        await driver.press("f")
        await driver.at("Confirm")
        await driver.press("y")
        live = await driver.at("Live")
        await driver.until(lambda: live.run.name == "puppet-2")

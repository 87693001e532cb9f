"""The laboratory: removed legs, the champion before and after, and the trials."""

from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from textual.widgets import Input
from waiting import strips

from gaitsim.evaluation import evaluate
from gaitsim.experiment import load_experiment, parse_assignments
from gaitsim.individual import Member
from gaitsim.legged.damage import Damage, damage_options, parse_damage
from gaitsim.storage.creation import create_run
from gaitsim.storage.writer import RunWriter
from gaitsim_adaptation.damage import damage_texts, set_joint, toggle_leg
from gaitsim_adaptation.laboratory import Laboratory
from gaitsim_adaptation.laboratory_panels import axes_of, mark
from gaitsim_adaptation.record import adaptation_file, read_record
from gaitsim_adaptation.trials import Trial


@pytest.fixture
def atlas(here, monkeypatch):
    """Return a small atlas of the spider; trials are not shown while they run."""
    monkeypatch.setattr(Laboratory, "WATCHED", 0)
    small = (
        "evolution.population=10",
        "evolution.generations=2",
        "search.cells=6",
        "search.emitters=5",
    )
    axes = 'search.axes={"duty factor L1"=[0.0,1.0],"duty factor R1"=[0.0,1.0]}'
    experiment = load_experiment("spider-atlas", parse_assignments([*small, axes]))
    path = create_run(experiment, Path("runs/atlas"))
    with RunWriter.open(path) as writer:
        for _ in writer.evolve(partial(evaluate, writer.experiment)):
            pass
    return path


def plan(screen):
    return "\n".join(strip.text for strip in strips(screen.plan))


def test_trials_are_marked_on_a_map_of_the_damaged_leg():
    trials = [Trial(number, number, 1.0, 0.1, (0.5,)) for number in (1, 10, 36)]
    assert [mark(trial, trials[1]) for trial in trials] == ["1", "★", "+"]
    assert mark(trials[1], None) == "a"
    pairs = (("duty factor L1", "duty factor R1"), ("duty factor L2", "duty factor R2"))
    view = SimpleNamespace(pairs=pairs, names=("duty factor L1",))
    assert axes_of(view, ["R2"]) == pairs[1]
    assert axes_of(view, []) == axes_of(view, ["R3"]) == pairs[0]
    assert axes_of(SimpleNamespace(pairs=(), names=("yaw",)), ["L1"]) == ("yaw",)


async def refine_and_measure(driver, screen, atlas):
    """Try changes of the best gait; return the trials with the changes."""
    tried, best = len(screen.adaptation.trials), screen.adaptation.best
    await driver.press("m")
    await driver.until(lambda: len(screen.adaptation.trials) == tried + 10)
    await driver.until(lambda: not screen.is_busy("adapt"))
    refined = screen.adaptation.trials
    assert screen.adaptation.best.measured >= best.measured
    assert screen.adaptation.best.genome
    await driver.press("e")
    name = f"L2-lost-trial-{screen.adaptation.best.number}.mat"
    await driver.until((atlas / "exports" / name).exists)
    assert "gait file" in screen.obstacle("replay")
    return refined


@pytest.mark.slow
async def test_adaptation_to_a_lost_leg_finds_a_gait(atlas, drive):
    async with drive() as driver:
        await driver.press("L")
        screen = await driver.at("Laboratory")
        await driver.until(lambda: screen.intact.walk is not None and not screen.is_busy("walk"))
        assert "lab.adapt" not in driver.offered()
        assert "intact" in screen.obstacle("adapt")

        await driver.press("down", "enter")
        await driver.until(lambda: screen.damaged.walk is not None and not screen.is_busy("walk"))
        assert damage_texts(screen.damage) == ("L2 lost",)
        assert "[L2✗]" in plan(screen)
        assert screen.damaged.walk.individual.damage == ("L2 lost",)
        assert screen.intact.walk.individual.damage == ()
        assert screen.command_line() == f"gaitsim adapt {atlas} --damage 'L2 lost'"

        await driver.press("a")
        await driver.until(lambda: screen.adapted.walk is not None and not screen.is_busy("adapt"))
        trials = screen.adaptation.trials
        assert screen.trials.table.row_count == len(trials) > 0
        assert {*screen.trials.map.marks} == {trial.member for trial in trials}
        assert read_record(adaptation_file(atlas, "L2-lost")).trials == trials
        await driver.press("v", "enter")
        tasks = await driver.at("TaskList")
        assert tasks.command_line() == "gaitsim verify runs/atlas/adaptations/L2-lost.json"
        await driver.until(lambda: "identical" in driver.text("#task-text"))
        await driver.press("escape")
        await driver.until(lambda: driver.screen is screen)
        walk, best = screen.adapted.walk, screen.adaptation.best
        assert walk.individual.member.number == best.member
        assert walk.forward == pytest.approx(best.measured)
        await driver.press("e")
        await driver.at("ExportDialog")
        await driver.until(lambda: "--damage" in driver.text("#export-command"))
        assert f"--member {best.member} '--damage=L2 lost'" in driver.text("#export-command")
        await driver.press("escape")
        await driver.at("Laboratory")

        refined = await refine_and_measure(driver, screen, atlas)

        # New damage starts a new search; the previous damage restores its trials.
        await driver.press("enter")
        await driver.until(lambda: not screen.damage and not screen.is_busy("walk"))
        assert screen.trials.table.row_count == 0
        assert screen.damaged.walk is None
        await driver.press("enter")
        await driver.until(lambda: screen.damaged.walk is not None and not screen.is_busy("walk"))
        await driver.press("a")
        await driver.until(lambda: screen.adapted.walk is not None and not screen.is_busy("adapt"))
        assert screen.adaptation.trials == refined


@pytest.mark.slow
async def test_joint_damage_is_checked_against_the_body(atlas, drive):
    async with drive() as driver:
        driver.app.push_screen(Laboratory(atlas, Member(2)))
        screen = await driver.at("Laboratory")
        await driver.until(lambda: screen.plan.plan is not None and not screen.is_busy("walk"))
        assert "member 2, intact" in driver.text("WalkPane Static")
        await driver.press("d")
        dialog = await driver.at("Ask")
        for text, problem in (("L1 coxa weak 0.5", "weak"), ("L2 coxa stuck", "joint 'L2 coxa'")):
            dialog.query_one("#answer", Input).value = text
            await driver.press("enter")
            await driver.until(lambda problem=problem: problem in driver.text("#ask-problem"))
        dialog.query_one("#answer", Input).value = "L1 coxa stuck 20"
        await driver.press("enter")
        await driver.at("Laboratory")
        await driver.until(lambda: screen.damaged.walk is not None and not screen.is_busy("walk"))
        assert damage_texts(screen.damage) == ("L1 coxa stuck 20",)
        assert "[L1!]" in plan(screen)
        await driver.press("i")
        assert screen.damage == ()


LEGS = {name: (f"{name} coxa", f"{name} femur") for name in ("L1", "L2", "R1")}


def test_a_leg_is_removed_and_restored_intact():
    stuck = parse_damage(["L2 femur stuck 20"], LEGS)
    lost = toggle_leg(stuck, "L2", LEGS)
    assert damage_texts(lost) == ("L2 lost",)
    assert toggle_leg(lost, "L2", LEGS) == ()


def test_a_joint_has_one_damage_and_none_while_its_leg_is_lost():
    lost = toggle_leg((), "L2", LEGS)
    slow = set_joint(lost, "L2 femur", Damage("L2 femur", "slow", 0.25), LEGS)
    assert damage_texts(slow) == ("L2 femur slow 0.25",)
    stuck = set_joint(slow, "L2 femur", Damage("L2 femur", "stuck"), LEGS)
    assert damage_texts(stuck) == ("L2 femur stuck",)
    assert set_joint(stuck, "L2 femur", None, LEGS) == ()


def test_equal_damage_has_equal_text_in_any_order():
    one = toggle_leg(toggle_leg((), "R1", LEGS), "L1", LEGS)
    other = toggle_leg(toggle_leg((), "L1", LEGS), "R1", LEGS)
    assert one == other == parse_damage(damage_texts(one), LEGS)
    assert damage_options(damage_texts(one)) == ["--damage", "L1 lost", "--damage", "R1 lost"]

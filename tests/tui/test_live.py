"""The live screen: a run that is steered, followed or stopped."""

import asyncio
import dataclasses
import os
from contextlib import asynccontextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.style import Style
from textual.widgets import Input, Static
from waiting import app_until

from gaitsim.evaluation import evaluate
from gaitsim.experiment import load_experiment
from gaitsim.live.process import background_state
from gaitsim.live.protocol import Best, Event, Snapshot
from gaitsim.storage.creation import create_run
from gaitsim.storage.growing import HistoryBuffer
from gaitsim.storage.lock import is_locked
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens import live_board
from gaitsim.tui.screens.change import ChangeForm
from gaitsim.tui.screens.live import Live
from gaitsim.tui.screens.live_board import COLOURS
from gaitsim.tui.screens.live_source import ChampionSimulator, with_failure
from gaitsim.tui.widgets.canvas import BodyCanvas
from gaitsim.tui.widgets.curves import Curves
from gaitsim.tui.widgets.lines import Lines

pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals"),
    pytest.mark.usefixtures("here"),
]
SLOW = "organism.pause=0.01"
STYLES = {name: Style() for name in [*COLOURS, "dim"]}


@pytest.fixture
def make(walk):
    """Return a function that creates a run of puppets evolved up to a generation."""

    def make(generation=0, *overrides, name="walk", generations=20):
        return walk(name, generation, *overrides, generations=generations)

    return make


@asynccontextmanager
async def live(run, *, size=(80, 24), **options):
    """Open the screen in an app, once it knows the state of the run."""
    app = GaitsimApp(Path("runs"))
    async with app.run_test(size=size) as pilot:
        screen = Live(run, **options)
        first = screen.snapshot
        await app.push_screen(screen)
        await app_until(pilot, lambda: screen.snapshot is not first)
        yield screen, pilot
        if screen.process is not None:
            screen.process.kill()
            await screen.process.wait_ended()


async def paused_at(pilot, screen, generation):
    await app_until(
        pilot, lambda: screen.state == "paused" and screen.snapshot.generation == generation
    )


async def ask_change(pilot, key="c"):
    """Open the form of changes, and return it once the experiment is loaded."""
    await pilot.press(key)
    await app_until(pilot, lambda: isinstance(pilot.app.screen, ChangeForm))
    form = pilot.app.screen
    await app_until(pilot, lambda: form.validation is not None)
    return form


def status(form):
    return str(form.query_one("#status", Static).render())


async def type_in(pilot, text, field):
    pilot.app.screen.query_one(field, Input).value = text
    await pilot.pause()


def offered(screen):
    """Return the ids of the screen's available bindings."""
    return {
        active.binding.id.removeprefix("live.")
        for active in screen.active_bindings.values()
        if active.enabled and (active.binding.id or "").startswith("live.")
    }


def text(screen, selector):
    return screen.query_one(selector, Lines).text


def problem(screen):
    panel = screen.query_one("#live-problem", Static)
    return str(panel.render()) if panel.display else ""


def whole(make, gaitsim, *overrides, **options):
    """Return the fingerprint of the same run without interruptions."""
    path = make(0, *overrides, name="whole", **options)
    gaitsim("resume", path)
    return RunSnapshot(path).fingerprint()


def test_a_champion_that_is_not_on_disk_yet_is_simulated(tmp_path, monkeypatch):
    monkeypatch.setattr("gaitsim.storage.writer.PERIOD", 1e9)
    options = {"evolution.population": 12, "evolution.fitness_threshold": "none"}
    path = create_run(load_experiment("spider", options), tmp_path / "run")
    with RunWriter.open(path) as writer:
        *_, last = islice(writer.evolve(partial(evaluate, writer.experiment)), 3)
        genome = last.genomes[last.best]
        best = Best(last.number, float(last.scores[last.best]), tuple(genome.tolist()))
        assert RunSnapshot(path).generation == 1
        found = ChampionSimulator(path).simulate(best, 1)
    expected = RunSnapshot(path).individual(3).skeleton
    assert np.array_equal(found.segments, expected.segments)


class TestStopped:
    async def test_a_stopped_run(self, make):
        run = make(7, "evolution.fitness_threshold=0")
        history = RunSnapshot(run).history
        best = RunSnapshot(run).individual()
        generation, score = best.generation, best.score
        async with live(run) as (screen, pilot):
            await app_until(pilot, lambda: screen.query_one(BodyCanvas).skeleton is not None)
            assert offered(screen) == {
                "go", "step", "change", "goal", "fork", "log", "replay", "export", "why",
            }  # fmt: skip
            assert f"score {score:.4f}, champion of gen. {generation}" in text(
                screen, "#live-champion"
            )
            lines = {line.split()[0]: line for line in text(screen, "#live-table").splitlines()}
            assert f"{history['mean'][-1]:.3f}" in lines["score"]
            assert f"{history['mean:reach'][-1]:.3f}" in lines["reach"]
            assert f"{history['diversity'][-1]:.3f}" in lines["diversity"]
            best, mean = screen.query_one(Curves).series
            np.testing.assert_array_equal(best.y, history["best"])
            np.testing.assert_array_equal(mean.y, history["mean"])
            await pilot.press("l")
            await app_until(pilot, lambda: "best" in text(screen, "#live-events"))
            assert "saved as a champion" in text(screen, "#live-events")
            assert screen.command_line() == "gaitsim resume runs/walk"

    async def test_a_finished_run(self, make):
        async with live(make(20)) as (screen, pilot):
            assert screen.state == "finished"
            assert {"go", "step", "stop", "pause"}.isdisjoint(offered(screen))
            await app_until(
                pilot, lambda: "20 generations are done" in text(screen, "#live-status")
            )
            await pilot.press("g")
            await app_until(pilot, lambda: pilot.app.screen is not screen)
            await type_in(pilot, "20", "#answer")
            await pilot.press("enter")
            assert "21 to" in str(pilot.app.screen.query_one("#ask-problem").render())
            await type_in(pilot, "25", "#answer")
            await pilot.press("enter")
            await app_until(pilot, lambda: screen.state == "finished" and screen.process is None)
            assert screen.snapshot.generation == 25

    async def test_incomparable_scores_of_earlier_stages_have_their_own_scale(self, make, gaitsim):
        run = make(7)
        gaitsim("resume", run, "--set", "fitness.price=4", "--generations", 12)
        async with live(run) as (screen, pilot):
            await app_until(pilot, lambda: screen.query_one(Curves).series)
            best, mean, earlier = screen.query_one(Curves).series
            assert best.x.tolist() == mean.x.tolist() == [8, 9, 10, 11, 12]
            assert earlier.x.tolist() == [1, 2, 3, 4, 5, 6, 7]
            assert [one.incomparable for one in (best, mean, earlier)] == [False, False, True]
            assert "stage 2" in text(screen, "#live-status")


class TestSteering:
    async def test_a_paused_run_that_prepares_a_change_can_resume(self, make):
        async with live(make(1)) as (screen, pilot):
            await app_until(pilot, lambda: not screen.is_busy("source"))
            sent = []
            screen.process = SimpleNamespace(
                pause=lambda: sent.append("pause"),
                go=lambda: sent.append("go"),
            )
            for state in ("paused", "preparing"):
                screen.take(Snapshot(state))
            assert "go" in offered(screen)
            await pilot.press("space")
            assert "pause" in offered(screen)
            await pilot.press("space")
            assert "go" in offered(screen)
            assert sent == ["go", "pause"]
            screen.process = None

    @pytest.mark.slow
    async def test_pauses_and_steps_do_not_change_the_result(self, make, gaitsim):
        run = make(0, SLOW, generations=150)  # more than a busy machine needs to press a key
        async with live(run) as (screen, pilot):
            await pilot.press("n")
            await paused_at(pilot, screen, 1)
            assert offered(screen) >= {"go", "step", "stop", "change", "fork"}
            await pilot.press("n")
            await paused_at(pilot, screen, 2)
            await pilot.press("space")
            await app_until(pilot, lambda: screen.snapshot.generation > 4)
            assert "pause" in offered(screen)
            await pilot.press("space")
            await app_until(pilot, lambda: screen.state == "paused")
            at = screen.snapshot.generation
            await pilot.press("s")
            await app_until(pilot, lambda: screen.process is None)
            assert (screen.state, RunSnapshot(run).generation) == ("stopped", at)
            assert not is_locked(run)
            await pilot.press("space")
            await app_until(pilot, lambda: screen.state == "finished" and screen.process is None)
            assert screen.snapshot.generation == 150
            kinds = [event.generation for event in screen.board.live.events]
            assert kinds == sorted(kinds)
            assert len(set(screen.board.live.events)) == len(kinds)
        assert RunSnapshot(run).fingerprint() == whole(make, gaitsim, generations=150)

    async def test_an_option_is_changed_while_the_run_evolves(self, make, gaitsim):
        run = make(0, SLOW, generations=100_000)
        async with live(run, resume=True) as (screen, pilot):
            await app_until(pilot, lambda: screen.snapshot.generation > 2)
            form = await ask_change(pilot)
            form.go_to("fitness.price")
            await app_until(pilot, lambda: isinstance(pilot.app.focused, Input))
            pilot.app.focused.value = "[/b]"
            await pilot.press("enter")
            await app_until(pilot, lambda: "fitness.price" in status(form))
            assert pilot.app.screen is form
            pilot.app.focused.value = "0.7"
            await app_until(pilot, lambda: "not comparable" in status(form))
            command = str(form.query_one("#command").render())
            assert command == "$ gaitsim resume runs/walk --set fitness.price=0.7"
            await pilot.press("enter")
            await app_until(pilot, lambda: screen.snapshot.stage == 2)
            await app_until(pilot, lambda: screen.snapshot.generation > screen.snapshot.scored_from)
            await pilot.press("s")
            await app_until(pilot, lambda: screen.process is None)
        first, second = RunSnapshot(run).stages
        whole = make(0, SLOW, name="other", generations=first.last)
        gaitsim("resume", whole)
        more = ("--set", "fitness.price=0.7", "--generations", second.last)
        gaitsim("resume", whole, *more)
        assert (
            RunSnapshot(whole).history["best"].tolist() == RunSnapshot(run).history["best"].tolist()
        )

    async def test_a_finished_run_needs_more_generations_and_its_population_stays(self, make):
        async with live(make(20)) as (screen, pilot):
            form = await ask_change(pilot)
            assert form.builder.changes == {"evolution.generations": "30"}
            form.assign("evolution.population", "9")
            await app_until(pilot, lambda: "evolution.population" in form.validation.problems)
            await pilot.press("ctrl+r")
            await app_until(pilot, lambda: isinstance(pilot.app.focused, Input))
            assert pilot.app.screen is form
            await pilot.press("escape")
            await app_until(pilot, lambda: pilot.app.screen is screen)
            assert screen.state == "finished"

    @pytest.mark.slow
    async def test_a_fork_does_not_change_the_original(self, make):
        run = make(0, SLOW, generations=100_000)
        async with live(run, resume=True) as (screen, pilot):
            await app_until(pilot, lambda: screen.snapshot.generation > 2)
            form = await ask_change(pilot, "f")
            await type_in(pilot, "runs/[red]fork", "#out")
            form.assign("search.elites", "1")
            await pilot.press("ctrl+r")
            await app_until(
                pilot, lambda: pilot.app.screen is not screen and isinstance(pilot.app.screen, Live)
            )
            copy = pilot.app.screen
            await app_until(pilot, lambda: copy.state == "running")
            assert copy.run == Path("runs/[red]fork")
            await app_until(pilot, lambda: copy.snapshot.stage == 2)
            before = screen.snapshot.generation
            await app_until(pilot, lambda: screen.snapshot.generation > before)
            await pilot.press("s")
            await app_until(pilot, lambda: copy.process is None)
        assert RunSnapshot(Path("runs/[red]fork")).stages[0].last <= RunSnapshot(run).generation


class TestLeaving:
    @pytest.mark.slow
    async def test_a_run_continues_after_leaving_and_can_be_steered_again(self, make):
        run = make(0, SLOW, generations=100_000)
        async with live(run, resume=True) as (screen, pilot):
            await app_until(pilot, lambda: screen.snapshot.generation > 2)
            process = screen.process
            await pilot.press("escape")
            await app_until(pilot, lambda: not screen.is_attached)
            notes = [note.title + note.message for note in pilot.app._notifications]
            assert any(
                "is evolving in the background" in text and "gaitsim stop" in text for text in notes
            )
            assert background_state(run) == "running"
            again, other = Live(run), Live(run)
            await pilot.app.push_screen(other)
            await app_until(pilot, lambda: other.state == "running")
            await pilot.app.push_screen(again)
            await app_until(pilot, lambda: again.state == "running")
            assert again.process.pid == process.pid
            # A course that is re-read from the folder replaces the earlier one.
            await app_until(pilot, lambda: len(again.board.live.course) > 2)
            numbers = again.board.live.course["generation"]
            assert numbers.tolist() == [*range(1, len(numbers) + 1)]
            kinds = [event.generation for event in again.board.live.events]
            assert kinds == sorted(kinds)
            assert len(set(again.board.live.events)) == len(kinds)
            await pilot.press("space")  # both screens show the action of one
            await app_until(pilot, lambda: other.state == again.state == "paused")
            await pilot.press("s")
            await app_until(pilot, lambda: other.process is again.process is None)
            assert other.state == again.state == "stopped"
            await pilot.press("space")
            await app_until(pilot, lambda: other.state == again.state == "running")
            again.process.kill()
            await app_until(pilot, lambda: other.state == again.state == "failed")
            assert "killed or crashed" in problem(again)
            await pilot.press("escape")
            await app_until(pilot, lambda: pilot.app.screen is other)
            reopened = Live(run)
            await pilot.app.push_screen(reopened)
            await app_until(pilot, lambda: reopened.state == "failed")
            assert "killed or crashed" in problem(reopened)
            assert {"go", "step", "change"} <= offered(reopened)

    @pytest.mark.slow
    async def test_quitting_asks_about_live_runs(self, make):
        run = make(0, SLOW, generations=100_000)
        async with live(run, resume=True) as (screen, pilot):
            await app_until(pilot, lambda: screen.snapshot.generation > 2)
            for answer, keeps in (("escape", None), ("k", True), ("s", False)):
                ended = []
                pilot.app.exit = lambda ended=ended: ended.append(background_state(run))
                await pilot.press("q")
                await app_until(pilot, lambda: pilot.app.screen is not screen)
                await pilot.press(answer)
                await app_until(pilot, lambda: pilot.app.screen is screen)
                if answer != "escape":
                    await app_until(pilot, lambda ended=ended: ended)
                    assert (ended == ["running"]) is keeps
        assert RunSnapshot(run).generation == len(RunSnapshot(run).history["best"]) > 2
        assert not is_locked(run)


class TestProblems:
    @pytest.mark.slow
    async def test_a_run_written_by_another_program_is_followed(self, make, start):
        run = make(0, "organism.pause=0.05", generations=100_000)
        process = start("resume", run)
        end = await _written(run)
        assert end
        async with live(run) as (screen, pilot):
            await app_until(pilot, lambda: screen.snapshot.generation > 3)
            assert screen.state == "elsewhere"
            assert offered(screen) == {"fork", "replay", "export", "why", "log"}
            await app_until(pilot, lambda: "Another program" in text(screen, "#live-status"))
            before = screen.snapshot.generation
            await app_until(pilot, lambda: screen.snapshot.generation > before)
            await asyncio.to_thread(process.kill)
            await app_until(pilot, lambda: screen.state == "stopped")
            assert "go" in offered(screen)

    async def test_a_damaged_run_is_reported(self, make):
        run = make(3)
        (run / "history.csv").write_text("")
        async with live(run) as (screen, _pilot):
            assert screen.state == "failed"
            assert "history.csv ends at generation 0" in problem(screen)

    async def test_missing_rows_are_read_from_the_folder(self, make):
        async with live(make(7)) as (screen, pilot):
            course = screen.board.live.course
            screen.board.live.course = HistoryBuffer()
            rows = {"generation": np.array([7.0]), "best": np.array([0.0])}
            screen.take(Snapshot("stopped", rows=rows, generation=7, generations=20))
            await app_until(pilot, lambda: not screen.board.live.gap)
            read = screen.board.live.course
            np.testing.assert_array_equal(read["best"], course["best"])


@pytest.mark.parametrize("number", [4, 60])
async def test_all_islands_and_terms_are_visible(make, number):
    run = make(3, f"islands.number={number}", "evolution.population=6")
    async with live(run) as (screen, pilot):
        await app_until(pilot, lambda: "diversity" in text(screen, "#live-table"))
        table, panel = screen.query_one("#live-table"), screen.query_one("#live-terms")
        await app_until(pilot, lambda: table.size.height == len(table.text.split("\n")))
        assert "island" in table.text.splitlines()[0]
        assert panel.region.bottom <= screen.query_one("Footer").region.y
        assert screen.query_one(Curves).size.height >= 4
        panel.scroll_end(animate=False)
        await pilot.pause()
        assert table.region.bottom <= panel.region.bottom


def test_looks(make, snap_compare):
    run = make(12, "evolution.fitness_threshold=0", "fitness.price=0.3")

    async def show(pilot):
        screen = Live(run, clock=lambda: 0.0)
        await pilot.app.push_screen(screen)
        await app_until(pilot, lambda: screen.query_one(BodyCanvas).skeleton is not None)
        await app_until(pilot, lambda: "diversity" in text(screen, "#live-table"))
        table = screen.query_one("#live-table")
        await app_until(pilot, lambda: table.size.height == len(table.text.split("\n")))
        await app_until(pilot, lambda: screen.query_one(Curves).series)
        await app_until(pilot, lambda: "champion" in text(screen, "#live-champion"))
        await pilot.pause(0.3)  # some of the board's ticks

    assert snap_compare(GaitsimApp(Path("nowhere")), terminal_size=(160, 48), run_before=show)


async def _written(run):
    async with asyncio.timeout(60):
        while not (run / "population.pickle").exists():
            await asyncio.sleep(0.01)
    return True


class TestFormatting:
    SNAPSHOT = Snapshot(
        "running",
        generation=1234,
        generations=100_000,
        stage=12,
        evaluations_per_second=123_456,
        generations_per_second=100,
        top=(*[Best(9, 1.5, terms={"[red]reach": 2.0, "price" * 9: -0.5, "mean": np.nan})] * 5,),
    )

    @pytest.mark.parametrize("width", [1, 5, 12, 30, 40, 80, 160, 300])
    def test_lines_fit_any_width(self, width):
        course = HistoryBuffer(
            {name: np.arange(1, 9.0) for name in ("generation", "best", "mean", "diversity")}
        )
        line = live_board.status_line(self.SNAPSHOT, "running", width, STYLES)
        assert line.cell_len <= width
        event = Event(3, "stage", "wide 宽宽宽宽\x1b[31m" * 9)
        assert live_board.event_line(event, max(width, 12), STYLES).cell_len <= max(width, 12)
        lines = live_board.term_table(self.SNAPSHOT, course, width, STYLES)
        if width >= 30:
            assert {line.cell_len for line in lines} <= set(range(width + 1))

    def test_the_table_has_the_best_score_of_each_island(self):
        snapshot = dataclasses.replace(self.SNAPSHOT, islands=(0.5, 2.25, np.nan, -1.0))
        for width, rows in ((55, 1), (38, 2), (30, 4), (9, 5)):
            lines = [
                line.plain
                for line in live_board.term_table(snapshot, HistoryBuffer(), width, STYLES)
            ]
            found = [line.plain for line in live_board.island_lines(snapshot, width, STYLES)]
            assert lines[: len(found)] == found
            assert len(found) == rows
            assert all(len(line) <= width for line in found if width > 18)
            words = " ".join(found).split()
            assert " ".join(words) == "best of each island 0.500 2.250 – −1.000"

    def test_the_table_marks_values_that_are_not_finite(self):
        lines = live_board.term_table(self.SNAPSHOT, HistoryBuffer(), 120, STYLES)
        plain = [line.plain for line in lines]
        assert plain[1].split() == ["score", "–", *["1.500"] * 5]
        assert plain[2].split() == ["[red]reach", "–", *["2.000"] * 5]
        assert "–0" not in plain[3]
        assert plain[4].split() == ["mean", *"–––––"] or plain[4].split()[1:] == [*"––––––"]


def test_a_background_run_is_not_mistaken_for_a_run_of_another_program(tmp_path, monkeypatch):
    seen = Snapshot("elsewhere", generation=3)
    assert with_failure(seen, seen, tmp_path).state == "elsewhere"
    monkeypatch.setattr("gaitsim.tui.screens.live_source.background_state", lambda run: "paused")
    assert with_failure(seen, seen, tmp_path).state == "paused"

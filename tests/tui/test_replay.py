"""The replay: generations, frames, two synchronous bodies, sliders and footfalls."""

import re
import shutil
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from textual.app import App
from waiting import strips

from gaitsim.evaluation import evaluate
from gaitsim.individual import Member
from gaitsim.render.colours import LEFT, RIGHT
from gaitsim.render.terminal.footfalls import CURSOR, FIRST, SWING_INK, strip
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens.replay import Replay
from gaitsim.tui.screens.replay_loading import PATIENCE, Loader
from gaitsim.tui.widgets.curves import CurvePlot
from gaitsim.tui.widgets.footfalls import FootfallStrip
from gaitsim.tui.widgets.scrubber import Scrubber

WALKERS = '''
import numpy as np
from typing import ClassVar
from gaitsim.contracts import (
    Channel, Fitness, Measure, Motion, Organism, RealSpace, Skeleton, option,
)


class Walker(Organism):
    """A bar on two legs of either side."""

    frames: int = option(31, "of its motion", ge=1)
    broken: str = option("", "what it fails at")
    many: int = option(0, "more measures")
    feet: bool = option(True, "whether it has any")
    channels: ClassVar = {"distance": Channel((), "m", "how far")}

    def genome_space(self):
        return RealSpace(np.full(2, 0.0), np.full(2, 1.0), ("speed", "lift"))

    def move(self, genomes):
        if self.broken == "move" and len(genomes) == 1:
            raise RuntimeError("out of [bold]breath")
        return Motion(10.0, {"distance": genomes[:, 0] * 3, "genomes": genomes})

    def measures(self, motion):
        if self.broken == "measures":
            raise RuntimeError("no ruler")
        names = ("distance", *(f"measure {number}" for number in range(self.many)))
        return {name: Measure(motion["distance"], "m", "how far") for name in names}

    def skeleton(self, motion, individual):
        seconds = np.arange(self.frames) / 10
        speed, lift = motion["genomes"][individual]
        middle = np.stack([speed * seconds, 0 * seconds, 0 * seconds + 0.3], axis=1)
        hips = np.array([[0.2, 0.1, 0], [-0.2, 0.1, 0], [0.2, -0.1, 0], [-0.2, -0.1, 0]])
        sign = np.array([1, -1, -1, 1])
        hip = middle[:, None] + hips
        foot = hip + np.array([0, 0.1, 0]) * np.sign(hips[:, 1:2])
        foot[..., 0] += 0.1 * sign * np.sin(2 * np.pi * seconds)[:, None]
        up = np.maximum(sign * np.cos(2 * np.pi * seconds)[:, None], 0)
        foot[..., 2] = 0.1 * lift * up
        trunk = middle[:, None, None] + np.array([[[0.25, 0, 0], [-0.25, 0, 0]]])
        segments = np.concatenate([trunk, np.stack([hip, foot], axis=2)], axis=1)
        if self.broken == "skeleton":
            segments = segments * np.nan
        feet = {"contacts": foot, "touching": up == 0, "contact_names": ("L1", "L2", "R1", "R2")}
        names = ("trunk", "L1", "L2", "R1", "R2")
        return Skeleton(segments, names, 10.0, centre=middle, **(feet if self.feet else {}))


class Far(Fitness):
    """How far it goes."""

    failing: bool = option(False, "whether all fail")
    needs: ClassVar = ("distance",)

    def terms(self, motion):
        return {"distance": motion["distance"] * (np.nan if self.failing else 1.0)}
'''


@pytest.fixture
def walk(install, walk):
    """Return a function that creates a finished run of walkers."""
    install("walkers", WALKERS, {"organism": {"stilt": "Walker"}, "fitness": {"far": "Far"}})
    walkers = "organism.plugin=stilt", "fitness.plugin=far"
    return lambda name="walk", *more, until=5: walk(name, until, *walkers, *more)


@asynccontextmanager
async def replay(run, *, generation=None, beside=None, size=(80, 24), playing=False):
    """Open the screen in an app, once its bodies are shown."""
    app = GaitsimApp(Path("runs"))
    async with app.run_test(size=size) as pilot:
        app.screen.show_screen("replay.Replay", run, generation, beside)
        await pilot.pause()
        if not playing:  # motion delays a pilot
            app.screen.action_pause()
        await settled(pilot)
        yield app.screen, pilot


async def settled(pilot):
    """Wait until no individual is being read."""
    await pilot.pause()
    screen = pilot.app.screen
    for _ in range(100):
        if not isinstance(screen, Replay) or not any(pane.loading_now for pane in screen.panes):
            break
        await pilot.app.workers.wait_for_complete()
        await pilot.pause()
    else:
        raise AssertionError("an individual is still being read")
    await pilot.pause()


async def press(pilot, *keys):
    for key in keys:
        await pilot.press(key)
        await settled(pilot)


def title(pane):
    return str(pane.query_one(".title").render())


def space(screen):
    """Return the footer's label of the space bar."""
    return screen.active_bindings["space"].binding.description


def words(canvas):
    return " ".join("".join(strip.text for strip in strips(canvas)).split())


class TestTime:
    async def test_it_plays_and_pauses(self, walk):
        async with replay(walk(), playing=True) as (screen, pilot):
            assert screen.leader.playing
            assert space(screen) == "Pause"
            await press(pilot, "space")
            assert not screen.leader.playing
            assert space(screen) == "Play"
            assert "paused" in screen.sub_title
            await press(pilot, "space")
            assert screen.leader.playing

    async def test_frames_wrap_round_and_all_views_are_synchronous(self, walk):
        async with replay(walk()) as (screen, pilot):
            pane = screen.pane
            pane.canvas.show_frame(0)
            await press(pilot, "comma")
            assert pane.canvas.frame == 30
            await press(pilot, "full_stop", "full_stop")
            assert pane.canvas.frame == 1
            assert pane.query_one(FootfallStrip).frame == 1
            assert screen.query_one("#frame", Scrubber).value == 1

    async def test_the_slider_sets_the_time(self, walk):
        async with replay(walk()) as (screen, pilot):
            slider = screen.query_one("#frame", Scrubber)
            slider.focus()
            await press(pilot, "end")
            assert screen.leader.frame == 30
            assert not screen.leader.playing
            await press(pilot, "left", "shift+left")
            assert screen.leader.frame == 19
            assert "1.90 s" in slider.render().plain
            await pilot.click(slider, offset=(0, 0))
            assert screen.leader.frame == 0

    async def test_speed_is_halved_and_doubled_within_limits(self, walk):
        async with replay(walk()) as (screen, pilot):
            await press(pilot, "less_than_sign")
            assert (screen.leader.speed, "½×" in screen.sub_title) == (0.5, True)
            await press(pilot, *["greater_than_sign"] * 9)
            assert screen.leader.speed == 8


class TestGenerations:
    async def test_the_champion_is_shown_first(self, walk):
        run = walk()
        async with replay(run) as (screen, _pilot):
            shown = screen.pane.shown
            assert shown.generation == shown.champion
            assert "★" in title(screen.pane)
            assert f"{shown.individual.score:.4f}" in title(screen.pane)

    async def test_keys_step_through_generations_and_stop_at_the_ends(self, walk):
        async with replay(walk(), generation=2) as (screen, pilot):
            await press(pilot, "right_square_bracket")
            assert screen.pane.shown.generation == 3
            await press(pilot, "left_square_bracket", "left_square_bracket", "left_square_bracket")
            assert screen.pane.shown.generation == 1
            assert screen.pane.query_one(Scrubber).value == 1
            await press(pilot, "b")
            assert screen.pane.shown.generation == screen.pane.shown.champion

    async def test_only_the_last_requested_generation_is_read(self, walk, monkeypatch):
        read = []
        load = Loader.load
        monkeypatch.setattr(
            Loader, "load", lambda loader, asked: read.append(asked) or load(loader, asked)
        )
        async with replay(walk(), generation=1) as (screen, pilot):
            slider = screen.pane.query_one(Scrubber)
            for number in (2, 3, 4, 5):
                slider.choose(number)
                screen.pane.request(number)
            await settled(pilot)
            assert screen.pane.shown.generation == 5
            assert read == [1, 2, 5]

    @pytest.mark.slow
    async def test_go_to_shows_a_generation_by_number(self, walk):
        async with replay(walk()) as (screen, pilot):
            await press(pilot, "g", "4", "enter")
            assert screen.pane.shown.generation == 4
            await press(pilot, "colon", "7", "enter")
            problem = pilot.app.screen.query_one("#ask-problem")
            assert "1 to 5" in str(problem.render())
            await press(pilot, "escape")
            assert screen.pane.shown.generation == 4
            assert screen.command_line() == "gaitsim play runs/walk --generation 4"
            await press(pilot, "e")
            assert pilot.app.screen._texts["generation"] == "4"

    @pytest.mark.slow
    async def test_members_of_a_front_are_chosen_like_generations(self, walk):
        objectives = 'search.objectives={ distance = "max", "measure 0" = "min" }'
        run = walk("front", "search.plugin=nsga-2", objectives, "organism.many=1")
        async with replay(run) as (screen, pilot):
            pane = screen.pane
            await press(pilot, "o")
            best = int(np.argmax(pane.shown.members.scores)) + 1
            assert f"member {best}/6 ★" in title(pane)
            assert (pane.slider.label.strip(), pane.slider.last) == ("member", 6)
            await press(pilot, "left_square_bracket", "g", "2", "enter")
            assert pane.shown.which == Member(2)
            values = pane.shown.members.values
            assert pane.shown.measurements["distance"].value == values["distance"][1]
            (front,) = pane.query_one(CurvePlot).series
            np.testing.assert_array_equal(front.y, values["measure 0"])
            assert screen.command_line() == "gaitsim play runs/front --member 2"
            await press(pilot, "e")
            assert pilot.app.screen._texts["member"] == "2"
            await press(pilot, "escape", "o")
            assert pane.shown.which == pane.shown.champion

    def test_a_run_is_reread_only_after_changes(self, walk, monkeypatch):
        run, read, now = walk(), [], [0.0]
        monkeypatch.setattr(
            "gaitsim.storage.growing.RunSnapshot",
            lambda path: read.append(path) or RunSnapshot(path),
        )
        loader = Loader(run, lambda: now[0])
        assert [loader.load(number).generation for number in (1, 2, 5)] == [1, 2, 5]
        assert len(read) == 1
        with RunWriter.open(run, generations=7) as writer:
            for _ in writer.evolve(partial(evaluate, writer.experiment)):
                pass
        assert (loader.load(3).last, len(read)) == (5, 1)
        assert (loader.load(6).last, len(read)) == (7, 2)
        now[0] = PATIENCE
        assert (loader.load(3).last, len(read)) == (7, 2)


class TestCamera:
    @pytest.mark.slow
    async def test_a_drag_turns_the_body_and_selects_no_text(self, walk):
        async with replay(walk(), size=(160, 48)) as (screen, pilot):
            canvas, before = screen.pane.canvas, screen.pane.canvas.view
            await pilot.mouse_down(canvas, (5, 5))
            await pilot.hover(canvas, (canvas.size.width + 8, 8))
            await pilot.mouse_up(canvas, (canvas.size.width + 8, 8))
            assert canvas.view != before
            assert not screen.selections
            assert screen.get_selected_text() is None

    async def test_both_bodies_share_the_camera(self, walk):
        async with replay(walk(), beside=walk("other")) as (screen, pilot):
            screen.panes[1].canvas.focus()
            await press(pilot, "left", "up")
            one, other = (pane.canvas.view for pane in screen.panes)
            assert one == other
            assert one.name == ""


class TestTwoBodies:
    async def test_the_longer_motion_sets_the_time(self, walk):
        async with replay(walk("short", "organism.frames=11"), beside=walk("long")) as (
            screen,
            pilot,
        ):
            short, long = (pane.canvas for pane in screen.panes)
            assert screen.leader is long
            screen.query_one("#frame", Scrubber).choose(25)
            await pilot.pause()
            assert (short.frame, long.frame) == (10, 25)
            screen.query_one("#frame", Scrubber).choose(5)
            await pilot.pause()
            assert (short.frame, long.frame) == (5, 5)


class TestLayout:
    async def test_a_body_without_feet_has_no_footfalls(self, walk):
        async with replay(walk("fly", "organism.feet=false")) as (screen, _pilot):
            assert not screen.pane.query_one(FootfallStrip).display


class TestProblems:
    @pytest.mark.sampled
    @pytest.mark.parametrize(
        ("override", "message"),
        [
            ("fitness.failing=true", "has no champion"),
            ("organism.broken=skeleton", "not finite"),
            ("organism.broken=move", "out of [bold]breath"),
        ],
    )
    async def test_an_error_replaces_a_missing_body(self, walk, override, message):
        async with replay(walk("walk", override)) as (screen, pilot):
            assert message in words(screen.pane.canvas)
            for key in ("space", "full_stop", "v", "f", "m", "comma", "greater_than_sign"):
                await press(pilot, key)
            await press(pilot, "s", "b")

    async def test_a_run_deleted_during_the_replay(self, walk):
        run = walk()
        async with replay(run) as (screen, pilot):
            shutil.rmtree(run)
            await press(pilot, "left_square_bracket")
            assert "cannot read" in words(screen.pane.canvas)

    async def test_a_run_without_a_generation(self, walk):
        async with replay(walk(until=0)) as (screen, _pilot):
            assert "no finished generation yet" in words(screen.pane.canvas)
            assert "gaitsim resume" in words(screen.pane.canvas)


@pytest.mark.packages
def test_looks(walk, snap_compare):
    run = walk()

    async def show(pilot):
        pilot.app.screen.show_screen("replay.Replay", run)
        await pilot.pause()
        pilot.app.screen.action_pause()
        await settled(pilot)
        for frame in (0, 13):  # it may have reached any time
            pilot.app.screen.query_one("#frame", Scrubber).choose(frame)
        await settled(pilot)

    assert snap_compare(GaitsimApp(Path("nowhere")), terminal_size=(80, 24), run_before=show)


class TestFootfalls:
    def drawn(self, touching, frame, columns=30, rows=4, rate=10.0, names=("L1", "R1")):
        touching = np.asarray(touching, dtype=bool)
        sides = np.array([LEFT, RIGHT] * 9)[: touching.shape[1]]
        codes, inks = strip(touching, names, sides, frame, rate, columns, rows)
        return ["".join(map(chr, row)).rstrip() for row in codes], inks

    def test_a_bar_marks_a_foot_on_the_ground(self):
        touching = np.zeros((16, 2))
        touching[2:5, 0] = touching[5:8, 1] = 1
        rows, inks = self.drawn(touching, 0, 11, rate=1.0)
        assert rows[0] == "L1 │█▌·····"
        assert rows[1] == "R1 │·▐█····"
        assert inks[0, 4] == FIRST + LEFT
        assert inks[1, 4] == SWING_INK
        assert inks[0, 3] == inks[1, 3] == CURSOR

    def test_the_cursor_moves_before_the_diagram_scrolls(self):
        touching = np.ones((400, 1))
        columns = [
            int(np.argwhere(self.drawn(touching, frame, names=("L1",))[1] == CURSOR)[0, 1])
            for frame in (0, 10, 200, 210, 399)
        ]
        assert columns[0] < columns[1] < columns[2] == columns[3] < columns[4]

    def test_an_extra_row_has_the_seconds(self):
        touching = np.ones((90, 1))
        rows, _ = self.drawn(touching, 0, 49, names=("L1",), rate=10.0)
        assert re.findall(r"\d+ s", rows[1]) == ["0 s", "5 s"]
        assert rows[1].index("5 s") - rows[1].index("0 s") == 25

    def test_feet_share_rows_on_short_screens(self):
        touching = np.zeros((8, 4))
        touching[:, 0] = touching[4:, 1] = 1
        rows, _ = self.drawn(touching, 7, 14, rows=2, rate=1.0, names=("L1", "R1", "L2", "R2"))
        assert rows[0] == "L1 R1 ▀▀▀▀████"
        assert rows[1].startswith("L2 R2")

    @pytest.mark.parametrize("shape", [(0, 0), (3, 0), (0, 3), (1, 1), (5, 60)])
    @pytest.mark.parametrize("size", [(0, 0), (5, 1), (40, 3)])
    def test_any_size_can_be_drawn(self, shape, size):
        columns, rows = size
        _, inks = self.drawn(np.ones(shape), 0, columns, rows, names=())
        assert inks.shape == (rows, columns)


class Slider(App):
    def compose(self):
        yield Scrubber("time", 0, 100, 50)


class TestScrubber:
    async def test_dragging_changes_the_value(self):
        app = Slider()
        async with app.run_test(size=(60, 3)) as pilot:
            slider = app.query_one(Scrubber)
            bar = re.search("[━●─]+", str(slider.render()))
            start, width = bar.start(), len(bar[0])
            await pilot.mouse_down(slider, (start, 0))
            assert slider.value == 0
            await pilot.hover(slider, (start + width - 1, 0))
            assert slider.value == 100
            await pilot.mouse_up(slider, (start + width - 1, 0))
            await pilot.hover(slider, (start, 0))
            assert slider.value == 100

    def test_the_value_stays_in_its_range(self):
        slider = Scrubber("time", 1, 5, 9)
        assert slider.value == 5
        slider.set_range(1, 3)
        assert slider.value == 3
        slider.choose(-4)
        assert slider.value == 1

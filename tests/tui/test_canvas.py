"""The braille raster, the camera, drawn bodies, and the widget that plays them."""

import re
from contextlib import asynccontextmanager

import numpy as np
import pytest
from hypothesis import given, strategies as st
from textual.app import App
from waiting import app_until, strips

from gaitsim.contracts import Skeleton
from gaitsim.render.colours import LEFT, MIDDLE, RIGHT, sides
from gaitsim.render.scene.clip import Clip
from gaitsim.render.terminal import body
from gaitsim.render.terminal.body import MIN_ZOOM, NAMED, Viewpoint, camera
from gaitsim.render.terminal.braille import cells, draw_lines, draw_points, empty
from gaitsim.tui.widgets.canvas import BodyCanvas


def walker(frames=31, frame_rate=10.0, speed=0.5):
    """Return a bar with two legs on each side that moves forward; diagonal pairs alternate."""
    seconds = np.arange(frames) / frame_rate
    middle = np.stack([speed * seconds, 0 * seconds, 0 * seconds + 0.3], axis=1)
    swing = 0.1 * np.sin(2 * np.pi * seconds)
    hips = np.array([[0.2, 0.1, 0], [-0.2, 0.1, 0], [0.2, -0.1, 0], [-0.2, -0.1, 0]])
    sign = np.array([1, -1, -1, 1])
    hip = middle[:, None] + hips
    foot = hip + np.array([0, 0.1, 0]) * np.sign(hips[:, 1:2])
    foot[..., 0] += sign * swing[:, None]
    lifted = np.maximum(sign * np.cos(2 * np.pi * seconds)[:, None], 0)
    foot[..., 2] = 0.05 * lifted
    trunk = middle[:, None, None] + np.array([[[0.25, 0, 0], [-0.25, 0, 0]]])
    legs = np.stack([hip, foot], axis=2)
    return Skeleton(
        np.concatenate([trunk, legs], axis=1),
        ("trunk", "L1", "L2", "R1", "R2"),
        frame_rate,
        contacts=foot,
        touching=lifted == 0,
        contact_names=("L1", "L2", "R1", "R2"),
        centre=middle,
    )


def text(codes):
    return ["".join(map(chr, row)) for row in codes]


def lit(dots):
    return {(int(x), int(y)) for y, x in np.argwhere(dots)}


class Canvas(App):
    CSS = "BodyCanvas { width: 100%; height: 100%; }"

    def __init__(self, **settings):
        super().__init__()
        self.canvas = BodyCanvas(**settings)

    def compose(self):
        yield self.canvas


@asynccontextmanager
async def play(size=(40, 12), **settings):
    app = Canvas(**settings)
    async with app.run_test(size=size) as pilot:
        app.canvas.focus()
        await pilot.pause()
        yield app.canvas, pilot


class TestDots:
    def test_each_dot_sets_its_bit_of_the_braille_pattern(self):
        for place, sign in {(0, 0): "⠁", (1, 0): "⠈", (0, 3): "⡀", (1, 3): "⢀"}.items():
            dots = empty(1, 1)
            draw_points(dots, np.array([place], dtype=float), 1)
            assert text(cells(dots)[0]) == [sign]

    def test_a_line_has_a_dot_in_each_column_and_at_both_ends(self):
        dots = empty(10, 5)
        draw_lines(dots, np.array([[[2.0, 3.0], [17.0, 9.0]]]), np.array([1]))
        drawn = lit(dots)
        assert {(2, 3), (17, 9)} <= drawn
        assert sorted(x for x, _ in drawn) == list(range(2, 18))

    @given(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4))
    def test_dots_are_on_the_line(self, numbers):
        one, other = np.array(numbers).reshape(2, 2)
        dots = empty(6, 4)
        draw_lines(dots, np.array([[one, other]]), np.array([1]))
        along = other - one
        length = float(np.linalg.norm(along))
        for place in lit(dots):
            away = np.array(place) - one
            off = abs(along[0] * away[1] - along[1] * away[0]) / length if length else 0.0
            assert off <= 0.75

    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_a_line_that_is_not_finite_is_omitted(self, bad):
        dots = empty(4, 2)
        ends = np.array([[[0.0, 0.0], [bad, 1.0]], [[0.0, 0.0], [3.0, 0.0]]])
        draw_lines(dots, ends, np.array([2, 1]))
        assert dots.max() == 1

    def test_dashes_continue_from_line_to_line(self):
        dots = empty(10, 1)
        ends = np.array([[[0.0, 0.0], [5.0, 0.0]], [[5.0, 0.0], [19.0, 0.0]]])
        draw_lines(dots, ends, np.array([1, 1]), (3, 2))
        assert [x for x in range(20) if dots[0, x]] == [x for x in range(20) if x % 5 < 3]

    def test_the_highest_ink_wins_and_hides_lower_ones(self):
        dots = empty(1, 1)
        draw_points(dots, np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([5, 1]))
        codes, inks = cells(dots, behind=2)
        assert (text(codes), inks.tolist()) == (["⠁"], [[5]])
        assert text(cells(dots)[0]) == ["⠉"]


class TestView:
    def test_the_camera_stays_above_the_ground(self):
        assert Viewpoint().turned(0, -1000).elevation == 0
        assert Viewpoint().turned(0, 1000).elevation == 90

    def test_the_named_views_form_a_cycle(self):
        view, names = Viewpoint(), []
        for _ in range(len(NAMED)):
            names.append(view.name)
            view = view.next()
        assert names == list(NAMED)
        assert view == Viewpoint()
        assert Viewpoint().turned(3, 0).next().name == "iso"


class TestPicture:
    def test_only_feet_on_the_ground_are_marked(self):
        clip = Clip(walker())
        codes, inks = body.picture(clip, 0.0, Viewpoint(), 60, 20)
        standing = int(clip.skeleton.touching[0].sum())
        assert (codes == body.STANCE).sum() == standing == 2
        assert set(inks[codes == body.STANCE]) == {body.FOOT + LEFT, body.FOOT + RIGHT}

    def test_left_and_right_have_their_inks(self):
        _, inks = body.picture(Clip(walker()), 0.4, Viewpoint(), 60, 20)
        limbs = inks[(inks >= body.BODY) & (inks < body.FOOT)]
        assert set((limbs - body.BODY) % body.SIDES) == {MIDDLE, LEFT, RIGHT}

    def test_sides_follow_only_from_names(self):
        names = ("L1 femur", "R", "left wing", "right side", "leg 1", "rear", "Lower", "spine")
        expected = [LEFT, RIGHT, LEFT, RIGHT] + [MIDDLE] * 4
        assert sides(names).tolist() == expected

    def test_a_followed_body_stays_in_the_middle(self):
        clip = Clip(walker(speed=5.0))
        for seconds in (0.5, 1.5, 2.5):
            _, inks = body.picture(clip, seconds, Viewpoint(), 60, 20)
            assert abs(np.argwhere(inks >= body.BODY).mean(axis=0)[1] - 30) < 6

    def test_the_whole_path_is_in_the_picture(self):
        clip = Clip(walker(speed=5.0))
        middles = []
        for seconds in (0.0, 3.0):
            _, inks = body.picture(clip, seconds, Viewpoint(follow=False).named("side"), 60, 20)
            drawn = (inks >= body.BODY) & (inks < body.LABEL)
            middles.append(np.argwhere(drawn).mean(axis=0)[1])
        assert 1 < middles[0] < 12
        assert 48 < middles[1] < 59

    def test_the_scale_bar_is_true_at_the_body(self):
        clip = Clip(walker())
        for view in (Viewpoint(), Viewpoint(zoom=4.0).named("side"), Viewpoint(follow=False)):
            codes, _ = body.picture(clip, 1.0, view, 80, 20)
            drawn = re.match(r"([⠀-⣿]+) ([0-9.]+) (mm|cm|m) ", text(codes)[-1])
            metres = float(drawn[2]) * {"mm": 1e-3, "cm": 1e-2, "m": 1.0}[drawn[3]]
            scale = camera(view, clip, clip.at(1.0), 160, 80).scale
            assert -0.5 <= metres * scale - 2 * (len(drawn[1]) - 1) <= 1.5
        point = Clip(Skeleton(np.zeros((2, 1, 2, 3)), ("limb",), 1.0))
        for zoom in (1.0, MIN_ZOOM):
            codes, _ = body.picture(point, 0.0, Viewpoint(zoom=zoom), 80, 20)
            assert "mm" not in text(codes)[-1]

    @pytest.mark.parametrize(
        ("degrees", "shown"), [(0, "yaw ↑ 0°"), (50, "yaw ↖ 50°"), (-90, "yaw → −90°")]
    )
    def test_the_heading_is_shown_as_seen_from_above(self, degrees, shown):
        still = walker()
        turn = np.radians(degrees) * np.linspace(0, 1, 31)
        cos, sin = np.cos(turn)[:, None, None], np.sin(turn)[:, None, None]
        x, y, z = (still.segments[0] - (0, 0, 0))[None].repeat(31, 0).transpose(3, 0, 1, 2)
        turned = np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-1)
        clip = Clip(Skeleton(turned, still.names, 10.0))
        assert text(body.picture(clip, 3.0, Viewpoint(), 80, 20)[0])[-1].endswith(shown)

    @pytest.mark.parametrize("view", [Viewpoint().named("side"), Viewpoint(follow=False)])
    def test_a_flying_body_has_an_altitude(self, view):
        rising = walker().segments + np.linspace(0, 2, 31)[:, None, None, None] * (0, 0, 1)
        clip = Clip(Skeleton(rising, walker().names, 10.0))
        rows = text(body.picture(clip, 1.5, view, 80, 20)[0])
        assert f"altitude {clip.at(1.5).middle[2]:.2f} m" in rows[-1]

    @pytest.mark.parametrize(("columns", "rows"), [(0, 0), (1, 1), (3, 1), (30, 10), (200, 60)])
    @pytest.mark.parametrize("follow", [True, False])
    def test_any_size_can_be_drawn(self, columns, rows, follow):
        view = Viewpoint(follow=follow)
        codes, inks = body.picture(Clip(walker()), 1.0, view, columns, rows)
        assert codes.shape == inks.shape == (rows, columns)

    @pytest.mark.parametrize("frames", [1, 2])
    def test_a_body_without_extent_can_be_drawn(self, frames):
        clip = Clip(Skeleton(np.zeros((frames, 1, 2, 3)), ("point",), 1.0))
        for name in NAMED:
            assert body.picture(clip, 0.0, Viewpoint().named(name), 20, 8)[0].shape == (8, 20)


class TestWidget:
    async def test_keys_move_the_camera(self):
        async with play(skeleton=walker()) as (canvas, pilot):
            start = canvas.view
            await pilot.press("left")
            assert canvas.view.azimuth != start.azimuth
            await pilot.press("up")
            assert canvas.view.elevation > start.elevation
            await pilot.press("plus")
            assert canvas.view.zoom > 1
            await pilot.press("f")
            assert not canvas.view.follow
            await pilot.press("0")
            assert canvas.view == start
            await pilot.press("v")
            assert canvas.view.name == "side"

    async def test_the_mouse_turns_and_zooms(self):
        async with play(skeleton=walker()) as (canvas, pilot):
            await pilot.mouse_down(canvas, (10, 5))
            await pilot.hover(canvas, (14, 7))
            await pilot.mouse_up(canvas, (14, 7))
            turned = canvas.view
            assert turned != Viewpoint()
            await pilot.hover(canvas, (20, 3))
            assert canvas.view == turned
            canvas.post_message(wheel(canvas))
            await pilot.pause()
            assert canvas.view.zoom > 1

    async def test_it_plays_by_the_clock_in_a_loop(self):
        now = [100.0]
        async with play(skeleton=walker(), clock=lambda: now[0]) as (canvas, pilot):
            canvas.speed = 2.0
            canvas.playing = True
            now[0] += 0.5
            await app_until(pilot, lambda: canvas.seconds == pytest.approx(1.0))
            assert canvas.frame == 10
            now[0] += 1.25
            await app_until(pilot, lambda: canvas.seconds == pytest.approx(3.5 % 3.0))
            canvas.playing = False
            now[0] += 5
            canvas.playing = True
            await pilot.pause(0.2)  # some ticks
            assert canvas.seconds == pytest.approx(0.5)

    async def test_another_body_keeps_the_camera_and_the_time(self):
        async with play(skeleton=walker()) as (canvas, pilot):
            canvas.show_frame(20)
            await pilot.press("v")
            canvas.set_skeleton(walker(frames=41))
            assert (canvas.frame, canvas.view.name) == (20, "side")
            canvas.set_skeleton(walker(frames=11))
            assert canvas.seconds <= canvas.duration

    async def test_a_message_is_shown_literally_without_a_body(self):
        async with play(message="no [bold]champion[/bold] 漢字") as (canvas, pilot):
            shown = "\n".join(strip.text for strip in strips(canvas))
            assert "no [bold]champion[/bold] 漢字" in shown
            assert all(strip.cell_length == 40 for strip in strips(canvas))
            await pilot.press("left", "plus", "f")
            canvas.show_frame(3)
            assert canvas.frame == 0


def wheel(canvas):
    from textual.events import MouseScrollUp

    where = {"x": 5, "y": 5, "screen_x": 5, "screen_y": 5}
    keys = dict.fromkeys(("shift", "meta", "ctrl"), False)
    return MouseScrollUp(widget=canvas, delta_x=0, delta_y=0, button=0, **where, **keys)

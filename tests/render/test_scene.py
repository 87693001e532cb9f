import itertools
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.path import Path

from gaitsim.contracts import Skeleton
from gaitsim.render.scene import THEMES, VIEWS, Clip, Scene, draw, labels
from gaitsim.render.scene.bodies import anatomy
from gaitsim.render.scene.camera import Camera, axes, smooth_path
from gaitsim.render.scene.clip import Race
from gaitsim.render.scene.ground import grid
from gaitsim.render.scene.kernels import rule
from gaitsim.render.scene.labels import DPI, Labels
from gaitsim.render.scene.solids import hull

FRAMES = 21


def camera(view, scale=100.0):
    return Camera(
        np.zeros(3), *axes(*VIEWS[view]), distance=7.0, scale=scale, centre=np.array([320, 240])
    )


def walker(lifted=False, far=1.0):
    """Return a square table on four legs that slides `far` metres in 2 s."""
    x, y = np.array([0.1, 0.1, -0.1, -0.1]), np.array([0.1, -0.1, -0.1, 0.1])
    top = np.stack([x, y, np.full(4, 0.15)], axis=1)
    edges = np.stack([top, np.roll(top, -1, axis=0)], axis=1)
    hips = top * (0.9, 0.9, 1.0)
    feet = hips * (2.0, 2.0, 0.0)
    body = np.concatenate([edges, np.stack([hips, feet], axis=1)])
    along = np.zeros((FRAMES, 1, 1, 3))
    along[..., 0] = np.linspace(0, far, FRAMES)[:, None, None]
    segments = body + along
    names = tuple(f"edge {n}" for n in range(4)) + tuple(f"leg {n}" for n in range(4))
    touching = np.full((FRAMES, 4), not lifted)
    feet = ("L1", "R1", "R2", "L2")
    return Skeleton(segments, names, 10.0, segments[:, 4:, 1].copy(), touching, feet)


def cuboid(at=(0.0, 0.0, 0.0)):
    """Return the edges of a box that moves by `at` per frame."""
    corner = np.array([[x, y, z] for x in (0, 3) for y in (0, 2) for z in (0, 1)], float)
    pairs = [(i, j) for i in range(8) for j in range(i) if (corner[i] != corner[j]).sum() == 1]
    box = np.array([[corner[i], corner[j]] for i, j in pairs])
    segments = box + np.arange(FRAMES)[:, None, None, None] * np.array(at)
    return Skeleton(segments, tuple(map(str, range(12))), 10.0)


def pixels_of(picture, colour, tolerance=6):
    """Return whether each pixel has a colour, (height, width)."""
    return (np.abs(picture[..., :3] - np.round(np.array(to_rgb(colour)) * 255)) <= tolerance).all(
        axis=-1
    )


@pytest.mark.parametrize(
    ("view", "right", "up"),
    [("side", (1, 0, 0), (0, 0, 1)), ("top", (1, 0, 0), (0, 1, 0)), ("iso", (1, 0, 0), (0, 0, 1))],
)
def test_forward_is_to_the_right_and_up_is_up(view, right, up):
    points, _ = camera(view).project(np.array([(0, 0, 0), right, up], float))
    assert np.allclose(points[0], (320, 240))
    assert points[1, 0] > points[0, 0] + 30
    assert points[2, 1] > points[0, 1] + 30


@pytest.mark.parametrize("view", VIEWS)
def test_the_scale_applies_at_the_target_and_nearer_objects_are_larger(view):
    seen = camera(view)
    assert np.allclose(np.stack([seen.right, seen.up, seen.ahead]) @ seen.right, (1, 0, 0))
    points, depth = seen.project(np.stack([0 * seen.right, seen.right, seen.right - seen.ahead]))
    assert depth.tolist() == pytest.approx([7, 7, 6])
    assert np.allclose(points[1] - points[0], (100, 0))
    assert np.allclose(points[2] - points[0], (100 * 7 / 6, 0))


def test_the_camera_follows_a_steady_walk_exactly_and_smooths_a_trembling_one():
    walk = np.outer(np.arange(50), (0.1, 0.0, 0.0))
    assert np.allclose(smooth_path(walk, 30.0), walk)
    trembling = walk + 0.05 * (-1.0) ** np.arange(50)[:, None]
    assert np.abs(np.diff(smooth_path(trembling, 30.0)[10:-10], axis=0) - (0.1, 0, 0)).max() < 0.005
    assert np.array_equal(smooth_path(walk[:1], 30.0), walk[:1])


def test_poses_are_interpolated_between_frames():
    skeleton = walker()
    clip = Clip(skeleton)
    assert np.allclose(clip.at(0.05).segments, skeleton.segments[:2].mean(axis=0))
    assert np.array_equal(clip.at(0.3).segments, skeleton.segments[3])
    assert np.array_equal(clip.at(9.0).segments, skeleton.segments[-1])
    assert np.allclose(clip.at(0.25).trail[[0, -1], 0], (0.0, 0.125))


def test_a_closed_loop_is_a_plate_and_a_box_is_a_solid():
    table = anatomy(walker())
    assert [len(plate) for plate in table.plates] == [4]
    assert table.limbs.tolist() == [4, 5, 6, 7]
    assert (table.radii[:, 0] > table.radii[:, 1]).all()  # thin at the foot
    box = anatomy(cuboid())
    assert not len(box.limbs)
    assert not box.plates
    (faces,) = box.solids
    ends = cuboid().segments[0].reshape(-1, 3)
    assert len(faces) == 6
    for face in faces:
        corners = ends[list(face)]
        assert np.unique(corners, axis=0).shape == (4, 3)
        outwards = np.cross(corners[1] - corners[0], corners[2] - corners[1])
        assert outwards @ (corners.mean(axis=0) - ends.mean(axis=0)) > 0


def filled_share(picture, colour):
    """Return the share of a colour's pixels that are not at the rim of a mark."""
    where = pixels_of(picture, colour, 40)
    inner = where[1:-1, 1:-1] & where[:-2, 1:-1] & where[2:, 1:-1] & where[1:-1, :-2]
    return inner.sum() / where.sum()


@pytest.mark.parametrize("view", ["iso", "top"])
def test_feet_on_the_ground_are_marked_and_span_the_support(view):
    colours = THEMES["light"]
    stands = draw(walker(), 1.0, view=view, size=(640, 480))[40:440]
    lifted = draw(walker(lifted=True), 1.0, view=view, size=(640, 480))[40:440]
    for side in (colours.left, colours.right):
        assert pixels_of(stands, side).sum() > 20
        assert pixels_of(lifted, side).sum() > 10
        assert filled_share(stands, side) > 1.5 * filled_share(lifted, side)  # a ring is hollow


HILLS = np.array([[-10.0, 0.0], [0.03, 0.0], [0.33, 0.2], [0.61, 0.1], [20.0, 0.1]])


def test_lines_bend_at_the_corners_of_uneven_ground():
    clip = Clip(replace(walker(), ground=HILLS))
    seen = Camera(np.array([0.3, 0.2, 0.1]), *axes(-58, 27), 7.0, 300.0, np.zeros(2))
    ends, _ = grid(seen, 1.0, 900.0, 1.0, clip.corners)
    on = clip.on_ground(ends)
    assert np.array_equal(on[..., :2], ends[..., :2])
    assert on[..., 2].max() == pytest.approx(0.2)
    middle = clip.on_ground(ends.mean(axis=1))  # no piece crosses a corner
    assert np.allclose(middle, on.mean(axis=1))


def test_feet_shadow_and_path_are_on_uneven_ground():
    level, high = (
        Scene([Clip(replace(walker(), ground=ground))], (640, 480), "side", "light").world
        for ground in (None, np.array([[0.0, 0.1]]))
    )
    for world in (level, high):
        world.show(1.0)
    for name in ("stance", "support", "shadow", "trail"):
        below, above = (
            np.concatenate([path.vertices for path in getattr(world.runners[0], name).get_paths()])
            for world in (level, high)
        )
        assert len(below) > 3
        assert (above - below)[:, 1].mean() == pytest.approx(0.1 * level.scale, rel=0.05)


@pytest.mark.parametrize(
    "ground", [np.zeros(3), np.zeros((0, 2)), np.array([[1.0, 0], [0, 0]]), np.full((1, 2), np.nan)]
)
def test_invalid_ground_is_rejected(ground):
    with pytest.raises(ValueError, match=r"Skeleton\.ground"):
        replace(walker(), ground=ground)


def test_the_body_stays_in_the_middle_and_the_ground_moves():
    scene = Scene([Clip(walker())], (640, 480), "side", "light")
    one, other = scene.draw(0.4), scene.draw(1.13)
    body = np.round(scene.world.runners[0]._colours["body_light"], 3)
    assert pixels_of(one, body, 40).sum() > 2000
    agree = pixels_of(one, body, 40) == pixels_of(other, body, 40)
    assert agree.mean() > 0.999
    assert (one[260:400] != other[260:400]).any(axis=-1).mean() > 0.02


def test_a_flying_body_has_an_altitude_and_the_ground_below():
    rising = cuboid(at=(0.0, 0.0, 0.5))
    assert Clip(rising).floor == 0.0
    falling = Clip(cuboid(at=(0.0, 0.0, -0.5)))
    assert falling.floor == -10.0
    assert falling.at(2.0).segments[..., 2].min() == 0.0
    moment = labels.format_moment(falling, falling.at(2.0), 2.0)
    assert moment == "2.00 s   distance 0.00 m   altitude −9.50 m"


@pytest.mark.parametrize(
    "segments",
    [
        np.zeros((1, 1, 2, 3)),
        np.zeros((4, 3, 2, 3)),
        np.random.default_rng(0).normal(size=(2, 1, 2, 3)) * 1e-9,
        np.random.default_rng(0).normal(size=(2, 1, 2, 3)) * 1e6,
    ],
)
def test_degenerate_bodies_are_drawn(segments):
    centre = np.zeros((len(segments), 3))
    names = tuple(map(str, range(segments.shape[1])))
    contacts, touching = np.zeros((len(segments), 2, 3)), np.ones((len(segments), 2), bool)
    for feet in ({}, {"contacts": contacts, "touching": touching}):
        draw(Skeleton(segments, names, 1.0, centre=centre, **feet), 0.5, size=(320, 240))


def flier(climb, span=0.3):
    """Return a bar that climbs `climb` metres in 2 s."""
    segments = np.zeros((FRAMES, 1, 2, 3))
    segments[:, 0, :, 1] = span / 2, -span / 2
    segments[..., 2] += np.linspace(0, climb, FRAMES)[:, None, None]
    return Skeleton(segments, ("bar",), 10.0)


def planar(far):
    """Return a walker in the plane y = 0."""
    flat = walker(far=far)
    segments, contacts = flat.segments.copy(), flat.contacts.copy()
    segments[..., 1] = contacts[..., 1] = 0
    return replace(flat, segments=segments, contacts=contacts)


@pytest.mark.parametrize("body", [walker, planar])
def test_bodies_race_in_lanes_on_one_ground(body):
    race = Race([Clip(body(far=far)) for far in (0.2, 2.0, 1.0)], leader=1, angles=VIEWS["iso"])
    poses = [clip.at(2.0) for clip in race.clips]
    assert [
        pose.middle[0] - clip.path[0, 0] for pose, clip in zip(poses, race.clips, strict=True)
    ] == (pytest.approx([0.2, 2.0, 1.0]))
    lanes = [clip.path[0, 1] for clip in race.clips]
    assert lanes[0] > lanes[1] > lanes[2]
    edges = [(p.segments[..., 1].min(), p.segments[..., 1].max()) for p in poses]
    assert all(left[0] > right[1] for left, right in itertools.pairwise(edges))
    for pose in poses:
        assert np.ptp(np.concatenate([pose.contacts, pose.segments[4:, 1]]), axis=0).max() < 1
    assert race.aim(poses)[0] == pytest.approx(
        np.mean([min(p.aim[0] for p in poses), max(p.aim[0] for p in poses)])
    )


@pytest.mark.parametrize("view", ["iso", "side"])
@pytest.mark.parametrize("body", [walker(far=2.0), planar(far=2.0), flier(1)])
def test_bodies_and_their_tags_do_not_overlap_at_the_start_of_a_race(view, body):
    scene = Scene([Clip(body, tag="generation 1")] * 3, (640, 480), view, "light")
    scene.draw(0.0)
    bodies = [
        np.concatenate([path.vertices for path in runner.body.get_paths()])
        for runner in scene.world.runners
    ]
    tags = [runner.tag.get_paths()[0].vertices for runner in scene.world.runners]
    hulls = [Path(hull(points)) for points in bodies]
    for farther, nearer, tag in zip(hulls, hulls[1:], tags[1:], strict=False):
        assert not farther.intersects_path(nearer)
        assert not farther.contains_points(tag).any()


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("bodies", [(walker(far=0.2), walker(far=3.0)), (flier(-2), flier(1))])
def test_the_whole_race_is_in_the_picture(view, bodies):
    scene = Scene([Clip(body, "name", tag="1") for body in bodies], (640, 480), view, "light")
    for seconds in (0.0, 1.0, 2.0):
        scene.draw(seconds)
        for runner in scene.world.runners:
            corners = np.concatenate([path.vertices for path in runner.body.get_paths()])
            assert (corners > 0).all()
            assert (corners < (640, 480)).all()


def test_a_planar_body_is_seen_from_the_side_instead_of_from_above():
    seen = [
        Scene([Clip(planar(1.0))], (320, 240), view, "light").draw(1.0) for view in ("top", "side")
    ]
    assert np.array_equal(*seen)
    assert not Clip(walker()).planar


@pytest.mark.parametrize("name", ["n" * 300, "w o r d s " * 20, "short", "名前 \t $a_{b$ \x07"])
@pytest.mark.parametrize("size", [(120, 120), (320, 240), (1280, 720)])
def test_texts_stay_inside_the_picture(name, size):
    figure = Figure((size[0] / DPI, size[1] / DPI), dpi=DPI)
    canvas = FigureCanvasAgg(figure)
    clip = Clip(walker(), name, f"generation 1000000   score −0.0001   {name}")
    heading = (clip.title, clip.details)
    made = Labels(figure, size, [clip], THEMES["light"], ["#009e73"], 0.05, heading)
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in made.still]
    made.set_clock([clip.at(2.0)], 2.0)
    boxes.append(made.clock.get_paths()[0].get_extents())
    for box in boxes:
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= size[0]
        assert box.y1 <= size[1]
    title, clock = boxes[0], boxes[-1]
    assert title.y0 > clock.y1


def coverage(*lines, width=1.0, size=(40, 30)):
    """Return the share of black in each pixel of black lines on white, from the lowest row up."""
    picture = np.full((size[1], size[0], 4), 255, dtype=np.uint8)
    rule(picture, np.array(lines, dtype=float), np.zeros((len(lines), 3), np.float32), width)
    assert (picture[..., 3] == 255).all()
    return 1 - picture[::-1, :, 0] / 255


@pytest.mark.parametrize(
    "end", [(30.0, 5.0), (30.0, 20.0), (12.0, 25.0), (5.0, 25.0), (-9.0, 14.0)]
)
@pytest.mark.parametrize("width", [0.6, 1.0, 2.5])
def test_a_line_covers_its_area(end, width):
    start = np.array([10.2, 5.3])
    clipped = np.clip(end, 0, None)  # the part inside the picture
    share = (clipped[0] - start[0]) / (end[0] - start[0]) if end[0] < 0 else 1.0
    length = share * np.hypot(*(end - start))
    assert coverage((start, end), width=width).sum() == pytest.approx(width * length, rel=0.07)

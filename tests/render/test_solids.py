"""Rasterised solids, compared with closed forms and with hulls of points."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from gaitsim.contracts import Skeleton, Solid
from gaitsim.errors import RunError
from gaitsim.render.film import write_still
from gaitsim.render.scene import THEMES, Clip, Scene, draw
from gaitsim.render.scene.camera import Camera, axes
from gaitsim.render.scene.raster import raster
from gaitsim.render.scene.solids import FINE, Surfaces, interpolate_poses, rotations

LIGHT = np.array([0.0, 0.0, 1.0])
TURNED = (0.1, -0.2, 0.05, *np.array([0.8, 0.3, -0.4, 0.2]) / np.sqrt(0.93))
AT_ZERO = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def rasterised(solids, poses, angles=(-58.0, 27.0), size=(400, 300)):
    """Return solids rasterised from a distance of 7 m, at 100 pixels per metre."""
    camera = Camera(np.zeros(3), *axes(*angles), 7.0, 100.0, np.array(size) / 2)
    return raster(camera, Surfaces(solids), np.array(poses, float), LIGHT, size, 2)


def whole(drawn, size=(400, 300)):
    """Return the nearness over the whole picture."""
    picture = np.zeros((size[1] * FINE, size[0] * FINE))
    rows, columns = drawn.nearness.shape
    bottom, left = drawn.bottom * FINE, drawn.left * FINE
    picture[bottom : bottom + rows, left : left + columns] = drawn.nearness
    return picture


def test_the_depth_and_outline_of_a_sphere_are_exact():
    drawn = whole(rasterised([Solid("ball", "sphere", (0.5,))], [AT_ZERO]))
    assert drawn.max() == pytest.approx(1 / 6.5, rel=1e-4)
    radius = 7 * 100 * FINE * 0.5 / np.sqrt(7**2 - 0.5**2)
    assert (drawn > 0).sum() == pytest.approx(np.pi * radius**2, rel=0.003)


def surface_points(shape):
    """Return points on a solid's surface, whose hull deviates from it by at most 1 part in 200."""
    turn, height = np.meshgrid(
        np.linspace(0, 2 * np.pi, 49), np.sin(np.linspace(-np.pi / 2, np.pi / 2, 25))
    )
    across = np.sqrt(1 - height**2)
    ball = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=-1).reshape(-1, 3)
    ends = np.array([[[0.0, 0.0, -0.6]], [[0.0, 0.0, 0.6]]])
    ring = ball[np.abs(ball[:, 2]) < 1e-9]
    return {
        "sphere": 0.4 * ball,
        "ellipsoid": ball * (0.3, 0.5, 0.9),
        "capsule": (0.3 * ball + ends).reshape(-1, 3),
        "cylinder": (0.3 * ring + ends).reshape(-1, 3),
        "box": np.sign(ball + 1e-9) * (0.3, 0.5, 0.9),
    }[shape]


SIZES = {
    "sphere": (0.4,),
    "ellipsoid": (0.3, 0.5, 0.9),
    "capsule": (0.3, 0.6),
    "cylinder": (0.3, 0.6),
    "box": (0.3, 0.5, 0.9),
}


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("angles", [(-58.0, 27.0), (-90.0, 90.0)])
@pytest.mark.parametrize("pose", [AT_ZERO, TURNED], ids=["straight", "turned"])
def test_each_shape_looks_like_the_hull_of_its_surface_points(shape, angles, pose):
    exact = whole(rasterised([Solid("", shape, SIZES[shape])], [pose], angles))
    about = whole(rasterised([Solid("", "mesh", vertices=surface_points(shape))], [pose], angles))
    assert ((exact > 0) != (about > 0)).sum() < 0.03 * (exact > 0).sum()
    both = (exact > 0) & (about > 0)
    away = np.abs(1 / exact[both] - 1 / about[both])
    assert np.quantile(away, 0.99) < 0.04  # the others graze the surface


def test_the_nearer_of_intersecting_solids_is_visible_everywhere():
    solids = [Solid("", "box", (0.9, 0.2, 0.1)), Solid("", "capsule", (0.15, 0.8))]
    poses = [AT_ZERO, TURNED]
    each = [whole(rasterised([one], [pose])) for one, pose in zip(solids, poses, strict=True)]
    together = rasterised(solids, poses)
    assert np.allclose(whole(together), np.maximum(*each), rtol=2e-4)
    assert set(np.unique(together.paint // 64)) == {0, 1, 2}


def test_solids_behind_the_camera_or_outside_the_picture_are_not_drawn():
    ball = Solid("", "sphere", (0.5,))
    behind = -9.0 * axes(-58.0, 27.0)[2]
    assert not rasterised([ball, ball], [AT_ZERO, (*behind, 1, 0, 0, 0)]).paint.max() // 64 > 1
    assert rasterised([ball], [(0, 0, 50, 1, 0, 0, 0)]) is None


def test_a_flat_mesh_is_a_sheet():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    drawn = whole(rasterised([Solid("", "mesh", vertices=square)], [AT_ZERO], (-90.0, 90.0)))
    assert (drawn > 0).sum() == pytest.approx((100 * FINE) ** 2, rel=0.03)


def test_rotations_and_interpolation_of_quaternions():
    quaternions = np.random.default_rng(1).normal(size=(5, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    known = Rotation.from_quat(quaternions[:, [1, 2, 3, 0]]).as_matrix()
    assert np.allclose(rotations(quaternions), known)
    one, other = np.array([AT_ZERO]), -np.array([[0, 0, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)]])
    half = interpolate_poses(one, other, 0.5)  # −q is the same rotation: 45° is half of 90°
    assert np.allclose(half[0, 3:], (np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)))


def robot(touching=True):
    """Return a trunk on two legs that moves by 1 m; one leg may be lifted."""
    solids = (
        Solid("trunk", "box", (0.3, 0.1, 0.1)),
        Solid("L1 leg", "capsule", (0.05, 0.2)),
        Solid("R1 leg", "cylinder", (0.05, 0.2)),
    )
    places = np.array([[0, 0, 0.5], [0, 0.3, 0.25], [0, -0.3, 0.25]])
    along = np.outer(np.linspace(0, 1, 11), (1.0, 0, 0))[:, None]
    poses = np.concatenate([places + along, np.tile((1.0, 0, 0, 0), (11, 3, 1))], axis=-1)
    feet = places[1:] * (1, 1, 0) + along
    return Skeleton(
        np.stack([feet, feet + np.array([0, 0, 0.45])], axis=2),
        ("L1 leg", "R1 leg"),
        10.0,
        feet,
        np.full((11, 2), touching),
        ("L1", "R1"),
        places[0] + along[:, 0],
        solids=solids,
        poses=poses,
    )


@pytest.mark.parametrize("theme", THEMES)
def test_legs_have_the_colour_of_their_side_and_feet_on_the_ground_more_of_it(theme):
    trunk, *sides = (
        np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], float)
        for colour in (THEMES[theme].body(0), THEMES[theme].left, THEMES[theme].right)
    )
    stands, lifted = (
        draw(robot(touching), 0.5, size=(320, 240), theme=theme)[20:210, :, :3].astype(float)
        for touching in (True, False)
    )

    def near(picture, colour):
        """Return whether each pixel has nearly the hue of a colour."""
        hue = (picture - picture.mean(axis=-1, keepdims=True)) @ (colour - colour.mean())
        norms = np.linalg.norm(picture - picture.mean(axis=-1, keepdims=True), axis=-1)
        return hue > 0.95 * np.maximum(norms, 25.0) * np.linalg.norm(colour - colour.mean())

    assert near(stands, trunk).sum() > 300
    for side in sides:
        one, other = near(stands, side), near(lifted, side)
        vivid, pale = np.ptp(stands[one], axis=-1), np.ptp(lifted[other], axis=-1)
        assert np.median(vivid) > 1.3 * np.median(pale) > 0


def test_a_still_shows_the_front_and_marks_pins(tmp_path, monkeypatch):
    def picture(**marks):
        write_still(robot(), tmp_path / "still.png", size=(320, 240), **marks)
        return np.array(Image.open(tmp_path / "still.png")).astype(int)

    plain, marked = picture(), picture(pins=np.zeros((1, 3)))
    assert (marked == 255).all(axis=-1).sum() > (plain == 255).all(axis=-1).sum() + 20
    monkeypatch.setattr("gaitsim.render.scene.world.ARROW", 1e-6)
    changed = np.nonzero((picture() - plain).any(axis=-1))
    assert changed[1].min() > 160  # the arrow and its word, at the right
    assert changed[0].min() > 120


def test_a_still_names_the_feet_and_has_no_clock(tmp_path):
    write_still(robot(), tmp_path / "still.png", "A robot", size=(320, 240))
    named = np.array(Image.open(tmp_path / "still.png")).astype(int)
    assert named.shape == (240, 320, 3)
    plain = Clip(
        replace(
            robot(),
            segments=robot().segments[5:6],
            poses=robot().poses[5:6],
            contacts=robot().contacts[5:6],
            touching=robot().touching[5:6],
            centre=robot().centre[5:6],
        ),
        "A robot",
    )
    unnamed = Scene([plain], (320, 240), "iso", "light").draw(0.0)[..., :3]
    rows = np.nonzero((np.abs(named - unnamed) > 60).any(axis=-1))[0]
    assert len(rows) > 20  # the letters, above the legend
    assert rows.max() < 215
    with pytest.raises(RunError, match=r"still\.png"):
        write_still(robot(), tmp_path / "no" / "still.png")

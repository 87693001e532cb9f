"""The motion in a page is the motion of the individual."""

import json

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as arrays

from gaitsim.contracts import Skeleton, Solid
from gaitsim.errors import GaitsimError
from gaitsim_page.clips import _solids, clip_data
from gaitsim_page.packing import pack, unpack


@given(
    arrays.arrays(
        np.float64,
        arrays.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=6),
        elements=st.floats(-2e4, 2e4),
    ),
    st.sampled_from([1e-5, 1e-3, 0.3]),
)
def test_unpacking_inverts_packing_within_half_a_step(values, step):
    found = unpack(json.loads(json.dumps(pack(values, step))))
    assert found.shape == values.shape
    assert np.abs(found - values).max(initial=0) <= step / 2 * (1 + 1e-6)


def test_numbers_that_cannot_be_stored_are_rejected():
    for bad in (np.nan, np.inf, 1e9):
        with pytest.raises(GaitsimError, match="cannot be stored"):
            pack([0.0, bad], 1e-5)


def test_a_clip_is_the_motion_of_the_individual(spider_run):
    spider = spider_run.individual()
    clip, skeleton = clip_data(spider), spider.skeleton
    step = clip["points"]["step"]
    points = unpack(clip["points"])[:, clip["ends"]].reshape(skeleton.segments.shape)
    assert points.shape[0] == clip["frames"] == 300
    assert len(set(clip["ends"])) < len(clip["ends"])  # joints are shared
    for found, original in (
        (points, skeleton.segments),
        (unpack(clip["feet"]["points"]), skeleton.contacts),
        (unpack(clip["centre"]), skeleton.path),
    ):
        assert np.abs(found - original).max() <= step * 0.55
    assert (unpack(clip["feet"]["touching"]) == skeleton.touching).all()
    angles = unpack(clip["angles"]["values"])
    assert np.abs(angles - spider.joint_angles).max() <= 5.01e-7
    assert clip["angles"]["names"] == list(spider.experiment.organism.joint_names())
    assert clip["score"] == spider.score
    assert {one["name"]: one["value"] for one in clip["terms"]} == dict(spider.scored_terms)
    # The term 'yaw' is a part of the score; the measure 'yaw' is an angle.
    assert {one["unit"] for one in clip["terms"]} == {clip["unit"]}


@pytest.mark.parametrize("height", [3.0, 0.0])
def test_meshes_are_triangles_seen_from_outside(height):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, height)], float)
    hidden = np.array([[0.5, 1.0, height / 2]])
    solid = Solid("L1 tibia", "mesh", vertices=np.concatenate([hidden, corners]))
    poses = np.tile([0.0, 0, 0, 1, 0, 0, 0], (2, 1, 1))
    body = Skeleton(np.zeros((2, 1, 2, 3)), ("a",), 1.0, solids=(solid,), poses=poses)
    (found,) = _solids(body, poses, 1e-5)["solids"]
    vertices = np.array(found["vertices"])
    a, b, c = (vertices[[face[i] for face in found["faces"]]] for i in range(3))
    assert found["side"] == "left"
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(
        2 * (height or 4e-3),
        rel=0.01,  # the volume; a flat mesh is a thin sheet
    )

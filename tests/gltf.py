"""A reader of GLB files for tests: checks the structure, and evaluates the animation."""

import json
import struct

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

SIZES = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
TYPES = {5126: "<f4", 5123: "<u2", 5125: "<u4"}


class Gltf:
    """A GLB file with a verified structure."""

    def __init__(self, data):
        magic, number, length = struct.unpack_from("<4sII", data)
        assert (magic, number, length) == (b"glTF", 2, len(data))
        assert length % 4 == 0
        head, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON"
        self.tree = json.loads(data[20 : 20 + head])
        body, kind = struct.unpack_from("<I4s", data, 20 + head)
        assert kind == b"BIN\0"
        self.binary = data[28 + head :]
        assert len(self.binary) == body == self.tree["buffers"][0]["byteLength"]
        assert head % 4 == body % 4 == 0
        self.accessors = [self._accessor(one) for one in self.tree["accessors"]]
        self.nodes = self.tree["nodes"]
        self.tracks = {}
        for animation in self.tree.get("animations", []):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                assert sampler["interpolation"] == "LINEAR"
                times, values = (self.accessors[sampler[end]] for end in ("input", "output"))
                assert times[0] >= 0
                assert len(times) == len(values)
                assert (np.diff(times) > 0).all()
                target = channel["target"]
                assert (target["node"], target["path"]) not in self.tracks
                self.tracks[target["node"], target["path"]] = times, values.astype(np.float64)
        self._check()

    def _accessor(self, one):
        view = self.tree["bufferViews"][one["bufferView"]]
        kind, width = np.dtype(TYPES[one["componentType"]]), SIZES[one["type"]]
        start, size = one["byteOffset"], one["count"] * width * kind.itemsize
        assert start % kind.itemsize == view["byteOffset"] % 4 == 0
        assert start + size <= view["byteLength"]
        assert view["byteOffset"] + view["byteLength"] <= len(self.binary)
        assert view.get("byteStride", 12) == 12
        start += view["byteOffset"]
        values = np.frombuffer(self.binary[start : start + size], kind)
        values = values.reshape(-1, width) if width > 1 else values
        assert np.isfinite(values).all()
        for bound, found in (("min", values.min(axis=0)), ("max", values.max(axis=0))):
            assert np.array_equal(one.get(bound, found), np.atleast_1d(found)) or bound not in one
        return values

    def _check(self):
        seen = [child for node in self.nodes for child in node.get("children", [])]
        assert sorted(seen) == list(range(1, len(self.nodes)))  # a tree below node 0
        used = {node["mesh"] for node in self.nodes if "mesh" in node}
        assert used == set(range(len(self.tree["meshes"])))
        for mesh in self.tree["meshes"]:
            for primitive in mesh["primitives"]:
                points = self.accessors[primitive["attributes"]["POSITION"]]
                triangles = self.accessors[primitive["indices"]].reshape(-1, 3)
                assert triangles.max() < len(points)
                assert primitive["material"] < len(self.tree["materials"])
                if "NORMAL" in primitive["attributes"]:
                    normals = self.accessors[primitive["attributes"]["NORMAL"]]
                    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)
                    corners = points[triangles]
                    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
                    assert ((faces[:, None] * normals[triangles]).sum(axis=2) > 0).all()
        for (node, path), (_, values) in self.tracks.items():
            if path == "rotation":
                assert np.allclose(np.linalg.norm(values, axis=1), 1, atol=1e-5)
                assert ((values[1:] * values[:-1]).sum(axis=1) > 0).all(), self.nodes[node]

    def numbers(self, name):
        """Return the numbers of the nodes with a name."""
        return [i for i, node in enumerate(self.nodes) if node["name"] == name]

    def value(self, node, path, time):
        """Return a node's translation, rotation or scale at a time."""
        usual = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}[path]
        if (node, path) not in self.tracks:
            return np.array(self.nodes[node].get(path, usual), float)
        times, values = self.tracks[node, path]
        time = np.clip(time, times[0], times[-1])
        if path == "rotation" and len(times) > 1:
            before = min(int(np.searchsorted(times, time, "right")) - 1, len(times) - 2)
            two = slice(before, before + 2)
            return Slerp(times[two], Rotation.from_quat(values[two]))(time).as_quat()
        return np.array([np.interp(time, times, column) for column in values.T])

    def placed(self, node, points, time):
        """Return the positions of points of a node's mesh at a time, in gaitsim's axes."""
        for number in (node, 0):
            move, turn, scale = (
                self.value(number, path, time) for path in ("translation", "rotation", "scale")
            )
            points = Rotation.from_quat(turn).apply(np.asarray(points, float) * scale) + move
        return points[:, [2, 0, 1]]  # glTF's z is forward, its x left, its y up

    def points(self, node):
        """Return the points of a node's mesh."""
        primitive = self.tree["meshes"][self.nodes[node]["mesh"]]["primitives"][0]
        return self.accessors[primitive["attributes"]["POSITION"]]

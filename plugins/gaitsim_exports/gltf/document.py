"""A glTF 2.0 document with its binary buffer (Khronos Group, ISO/IEC 12113:2022).

No package makes this module shorter: trimesh does not export animations, and pygltflib only
mirrors the JSON and leaves accessors, their bounds and the alignment of the buffer to the caller.
"""

import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.plugin.pictures import Colour, Mesh, Points

STILL = 1e-6
"""Largest change of a translation (m), quaternion or scale that does not count as movement."""

_FLOAT, _SHORT, _INT = 5126, 5123, 5125
_VERTICES, _TRIANGLES, _TRACKS = range(3)
_VIEWS: tuple[dict[str, int], ...] = ({"byteStride": 12, "target": 34962}, {"target": 34963}, {})
_REST = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0,) * 3}


class Document:
    """A scene under one root node, with one animation.

    Args:
        times: ascending times of the frames, (frames,) s.
        root: name of the root node.
        rotation: rotation of the root node, a unit quaternion (x, y, z, w).
    """

    def __init__(self, times: Points, root: str, rotation: Sequence[float]) -> None:
        self._buffers = bytearray(), bytearray(), bytearray()
        self._accessors: list[dict[str, Any]] = []
        self._meshes: list[dict[str, Any]] = []
        self._materials: list[dict[str, Any]] = []
        self._nodes: list[dict[str, Any]] = [
            {"name": root, "rotation": list(rotation), "children": []}
        ]
        self._samplers: list[dict[str, Any]] = []
        self._channels: list[dict[str, Any]] = []
        self._times, self._input = times, -1

    def add_material(self, name: str, colour: Colour, thin: bool = False) -> int:
        """Add a matt material; return its index.

        Args:
            name: name of the material.
            colour: sRGB colour, (3,), 0 to 1.
            thin: whether the back of surfaces is visible.
        """
        # glTF has linear colours, converted here from sRGB as defined by IEC 61966-2-1.
        linear = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
        self._materials.append(
            {
                "name": name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*np.round(linear, 6).tolist(), 1.0],
                    "metallicFactor": 0.0,
                    "roughnessFactor": 0.8,
                },
                **({"doubleSided": True} if thin else {}),
            }
        )
        return len(self._materials) - 1

    def add_shape(self, mesh: Mesh) -> dict[str, Any]:
        """Store a mesh; return it as a primitive without a material."""
        attributes = {"POSITION": self._vectors(mesh.points)}
        if mesh.normals is not None:
            attributes["NORMAL"] = self._vectors(mesh.normals)
        return {"attributes": attributes, "indices": self._indices(mesh.triangles)}

    def add_triangles(
        self, shape: Mapping[str, Any], triangles: NDArray[np.intp]
    ) -> dict[str, Any]:
        """Store more triangles between the points of a shape; return them as a primitive."""
        return {**shape, "indices": self._indices(triangles)}

    def add_mesh(self, name: str, shapes: Mapping[int, Mapping[str, Any]]) -> int:
        """Add a mesh of shapes, given by the index of their material; return its index."""
        primitives = [{**shape, "material": material} for material, shape in shapes.items()]
        self._meshes.append({"name": name, "primitives": primitives})
        return len(self._meshes) - 1

    def add_node(self, name: str, mesh: int | None = None, **tracks: Points) -> None:
        """Add a node below the root, with its pose in the first frame and its animation.

        Args:
            name: name of the node.
            mesh: index of the mesh; None for an empty node.
            tracks: `translation` (frames, 3) m, `rotation` (frames, 4) as unit quaternions
                (x, y, z, w) and `scale` (frames, 3), in the frame of the root. Constant tracks
                are not animated.
        """
        node: dict[str, Any] = {"name": name} if mesh is None else {"name": name, "mesh": mesh}
        number = len(self._nodes)
        for path, values in tracks.items():
            exact = np.ascontiguousarray(values, dtype="<f4")
            if np.abs(exact[0] - _REST[path]).max() > STILL:
                node[path] = exact[0].tolist()
            if np.abs(exact - exact[0]).max() > STILL:
                self._channel(number, path, exact)
        self._nodes.append(node)
        self._nodes[0]["children"].append(number)

    def _channel(self, node: int, path: str, values: NDArray[np.float32]) -> None:
        if self._input < 0:
            times = np.ascontiguousarray(self._times, dtype="<f4")
            bounds = {"min": [float(times[0])], "max": [float(times[-1])]}
            self._input = self._accessor(_TRACKS, times, _FLOAT, "SCALAR", bounds)
        output = self._accessor(_TRACKS, values, _FLOAT, f"VEC{values.shape[1]}")
        target = {"node": node, "path": path}
        self._channels.append({"sampler": len(self._samplers), "target": target})
        self._samplers.append({"input": self._input, "output": output, "interpolation": "LINEAR"})

    def _vectors(self, values: Points) -> int:
        exact = np.ascontiguousarray(values, dtype="<f4")
        bounds = {"min": exact.min(axis=0).tolist(), "max": exact.max(axis=0).tolist()}
        return self._accessor(_VERTICES, exact, _FLOAT, "VEC3", bounds)

    def _indices(self, triangles: NDArray[np.intp]) -> int:
        small = int(triangles.max()) < 0xFFFF
        exact = triangles.ravel().astype("<u2" if small else "<u4")
        return self._accessor(_TRIANGLES, exact, _SHORT if small else _INT, "SCALAR")

    def _accessor(
        self,
        view: int,
        values: NDArray[Any],
        component: int,
        kind: str,
        bounds: Mapping[str, Any] | None = None,
    ) -> int:
        buffer = self._buffers[view]
        self._accessors.append(
            {
                "bufferView": view,
                "byteOffset": len(buffer),
                "componentType": component,
                "count": len(values),
                "type": kind,
                **(bounds or {}),
            }
        )
        buffer += values.tobytes()
        buffer += bytes(-len(buffer) % 4)
        return len(self._accessors) - 1

    def to_glb(self, animation: str, generator: str, title: str, extras: Any) -> bytes:
        """Return the document as a GLB file.

        Args:
            animation: name of the animation.
            generator: name of the program that writes the file.
            title: name of the scene.
            extras: additional data of the scene, as JSON values.
        """
        used = [view for view, buffer in enumerate(self._buffers) if buffer]
        starts = np.cumsum([0, *(len(self._buffers[view]) for view in used)]).tolist()
        views = [
            {"buffer": 0, "byteOffset": start, "byteLength": len(self._buffers[view])}
            | _VIEWS[view]
            for view, start in zip(used, starts, strict=False)
        ]
        accessors = [one | {"bufferView": used.index(one["bufferView"])} for one in self._accessors]
        tree: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": generator},
            "scene": 0,
            "scenes": [{"name": title, "nodes": [0], "extras": extras}],
            "nodes": self._nodes,
            "meshes": self._meshes,
            "materials": self._materials,
            "accessors": accessors,
            "bufferViews": views,
            "buffers": [{"byteLength": starts[-1]}],
        }
        if self._channels:
            tree["animations"] = [
                {"name": animation, "samplers": self._samplers, "channels": self._channels}
            ]
        text = json.dumps(tree, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        head = text.encode("utf-8", "replace")
        head += b" " * (-len(head) % 4)
        body = b"".join(self._buffers)
        length = 12 + 8 + len(head) + 8 + len(body)
        return b"".join(
            [
                struct.pack("<4sII", b"glTF", 2, length),
                struct.pack("<I4s", len(head), b"JSON") + head,
                struct.pack("<I4s", len(body), b"BIN\0") + body,
            ]
        )

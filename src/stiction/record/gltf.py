"""A recording as an animation in glTF 2.0 (one binary file), for Blender, three.js and whatever else plays it.

Every body is a node with its mesh and, if it moves, tracks of translation and rotation. Keys in which nothing changes
are left out, so that bodies at rest cost nothing. glTF has y up; a node above all others turns z up into that.

Khronos Group, "glTF 2.0 Specification", 2021 (ISO/IEC 12113:2022).
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiction._version import __version__
from stiction.record.frames import Frames
from stiction.shapes import Plane, Shape
from stiction.view.meshes import Mesh, solid

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

FLOAT, UNSIGNED = 5126, 5125
ARRAY_BUFFER, ELEMENT_BUFFER = 34962, 34963
MAGIC, VERSION = 0x46546C67, 2
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
PLANE_MARGIN = 3.0
"""m of a plane that are drawn beyond the bodies."""
COLORS = ("#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#76b7b2", "#edc948", "#b07aa1", "#9c755f")
"""Of materials, in the order in which bodies bring them."""
FIXED_COLOR = "#b9bfc5"
HIDDEN = 1e-6
"""Scale of a body where it is not there; readers may refuse 0."""


def write_glb(frames: Frames, path: str | Path, on_progress: Progress | None = None) -> None:
    """Write frames as a binary glTF file.

    Args:
        frames: at least one. path: of the ``.glb`` file.
        on_progress: called with the bodies done and the bodies there are.
    """
    builder = _Builder(frames)
    for number in range(len(frames.bodies)):
        builder.add_body(number)
        if on_progress is not None:
            on_progress(number + 1, len(frames.bodies))
    Path(path).write_bytes(builder.file())


class _Builder:
    """The JSON and the bytes of one file."""

    def __init__(self, frames: Frames) -> None:
        self._frames = frames
        self._bytes: list[bytes] = []
        self._length = 0
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._meshes: list[dict[str, Any]] = []
        self._materials: list[dict[str, Any]] = []
        self._known_meshes: dict[tuple[bytes, int], int] = {}
        self._known_materials: dict[tuple[str, bool], int] = {}
        self._known_times: dict[bytes, int] = {}
        half = math.sqrt(0.5)
        self._nodes: list[dict[str, Any]] = [{"name": "z up", "rotation": [-half, 0.0, 0.0, half], "children": []}]
        self._channels: list[dict[str, Any]] = []
        self._samplers: list[dict[str, Any]] = []
        # a player's clock begins at 0
        self._times = (frames.times - frames.times[0] if len(frames) else frames.times).astype(np.float32)
        there = frames.positions[np.isfinite(frames.positions).all(axis=2)]
        self._reach = float(np.abs(there[:, :2]).max(initial=1.0)) + PLANE_MARGIN

    def add_body(self, number: int) -> None:
        """A node for a body, and its tracks."""
        frames = self._frames
        body = frames.bodies[number]
        positions, orientations = frames.positions[:, number], frames.orientations[:, number]
        there = np.asarray(np.isfinite(positions).all(axis=1))
        node: dict[str, Any] = {
            "name": body.name,
            "mesh": self._mesh(body.shape, self._material(body.material, body.fixed)),
        }
        self._nodes[0]["children"].append(len(self._nodes))
        self._nodes.append(node)
        if not there.any():
            node["scale"] = [HIDDEN] * 3
            return
        first = int(np.argmax(there))
        # where it is not there it stays as it was, or will be, and is too small to see
        filled = np.maximum.accumulate(np.where(there, np.arange(len(there)), first))
        positions, turns = positions[filled], _xyzw(orientations[filled])
        node["translation"], node["rotation"] = positions[first].tolist(), turns[first].tolist()
        self._track(len(self._nodes) - 1, "translation", positions.astype(np.float32), "LINEAR")
        self._track(len(self._nodes) - 1, "rotation", turns.astype(np.float32), "LINEAR")
        if not there.all():
            scale = np.repeat(np.where(there, 1.0, HIDDEN)[:, None], 3, axis=1)
            self._track(len(self._nodes) - 1, "scale", scale.astype(np.float32), "STEP")

    def file(self) -> bytes:
        """The file."""
        binary = b"".join(self._bytes)
        data: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"stiction {__version__}"},
            "scene": 0,
            "scenes": [{"name": self._frames.title, "nodes": [0]}],
            "nodes": self._nodes,
            "meshes": self._meshes,
            "materials": self._materials,
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": len(binary)}],
        }
        if self._channels:
            data["animations"] = [{"name": self._frames.title, "channels": self._channels, "samplers": self._samplers}]
        # the specification has no empty lists
        data = {key: value for key, value in data.items() if value != []}
        if not binary:
            del data["buffers"]
        if not self._nodes[0]["children"]:
            del self._nodes[0]["children"]
        text = json.dumps(data, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
        if binary:
            chunks += struct.pack("<II", len(binary), BINARY_CHUNK) + binary
        return struct.pack("<III", MAGIC, VERSION, 12 + len(chunks)) + chunks

    # --- pieces -------------------------------------------------------------------------------------------------------

    def _track(self, node: int, path: str, values: NDArray[np.float32], interpolation: str) -> None:
        """Keys of one quantity of a node, unless it never changes."""
        changes = (values[1:] != values[:-1]).any(axis=1)
        if not changes.any():
            return
        keep = np.zeros(len(values), np.bool_)
        keep[1:] |= changes
        keep[:-1] |= changes
        keep[0] = True
        times, kept = self._times[keep], values[keep]
        key = times.tobytes()
        if key not in self._known_times:
            self._known_times[key] = self._accessor(times, "SCALAR", None, limits=True)
        kind = "VEC4" if values.shape[1] == 4 else "VEC3"
        sampler = {
            "input": self._known_times[key], "output": self._accessor(kept, kind, None), "interpolation": interpolation
        }  # fmt: skip
        self._channels.append({"sampler": len(self._samplers), "target": {"node": node, "path": path}})
        self._samplers.append(sampler)

    def _material(self, name: str, fixed: bool) -> int:
        key = (name, fixed)
        if key not in self._known_materials:
            names = list(dict.fromkeys(body.material for body in self._frames.bodies if not body.fixed))
            color = FIXED_COLOR if fixed else COLORS[names.index(name) % len(COLORS)]
            self._known_materials[key] = len(self._materials)
            self._materials.append(
                {
                    "name": f"{name}, fixed" if fixed else name,
                    "pbrMetallicRoughness": {
                        "baseColorFactor": [*(_linear(int(color[k : k + 2], 16) / 255) for k in (1, 3, 5)), 1.0],
                        "metallicFactor": 0.0,
                        "roughnessFactor": 0.8,
                    },
                }
            )
        return self._known_materials[key]

    def _mesh(self, shape: Shape, material: int) -> int:
        mesh = _plane(shape, self._reach) if isinstance(shape, Plane) else solid(shape)
        corners = mesh.vertices[mesh.faces].astype(np.float32)
        key = (corners.tobytes(), material)
        if key not in self._known_meshes:
            vertices, indices, normals = _flat_or_smooth(mesh)
            self._known_meshes[key] = len(self._meshes)
            attributes = {
                "POSITION": self._accessor(vertices, "VEC3", ARRAY_BUFFER, limits=True),
                "NORMAL": self._accessor(normals, "VEC3", ARRAY_BUFFER),
            }
            index = self._accessor(indices, "SCALAR", ELEMENT_BUFFER)
            primitive = {"attributes": attributes, "indices": index, "material": material}
            self._meshes.append({"name": shape.kind, "primitives": [primitive]})
        return self._known_meshes[key]

    def _accessor(self, values: NDArray[Any], kind: str, target: int | None, *, limits: bool = False) -> int:
        data = np.ascontiguousarray(values)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": self._length, "byteLength": data.nbytes}
        self._views.append(view | ({"target": target} if target is not None else {}))
        self._bytes.append(data.tobytes() + bytes(-data.nbytes % 4))
        self._length += data.nbytes + -data.nbytes % 4
        component = UNSIGNED if data.dtype == np.uint32 else FLOAT
        accessor = {
            "bufferView": len(self._views) - 1, "componentType": component, "count": len(data), "type": kind
        }  # fmt: skip
        if limits:
            rows = data.reshape(len(data), -1)
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self._accessors.append(accessor)
        return len(self._accessors) - 1


def _xyzw(orientations: Array) -> Array:
    """Quaternions as glTF has them, w last, each on the same side as the one before, so that players turn the short
    way."""
    dots = np.sum(orientations[1:] * orientations[:-1], axis=1)
    signs = np.concatenate([[1.0], np.cumprod(np.where(dots < 0.0, -1.0, 1.0))])
    result: Array = (orientations * signs[:, None])[:, [1, 2, 3, 0]]
    return result


def _linear(value: float) -> float:
    """A channel of a screen colour as light (sRGB, IEC 61966-2-1)."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def _flat_or_smooth(mesh: Mesh) -> tuple[NDArray[np.float32], NDArray[np.uint32], NDArray[np.float32]]:
    """Vertices, indices and normals; corners that the mesh shares are smooth, the others are sharp."""
    corners = mesh.vertices[mesh.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(normals, mesh.faces[:, k], area)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.tile([0.0, 0.0, 1.0], (len(normals), 1)), where=length > 0.0)
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32).ravel(), normals.astype(np.float32)


def _plane(shape: Plane, reach: float) -> Mesh:
    """A square of a plane, around the point of it that is nearest to the origin."""
    n = np.array(shape.normal)
    u = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    middle = n * shape.offset
    corners = [middle + reach * (a * u + b * v) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]]))

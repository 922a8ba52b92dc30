"""Contact points of a run: their coefficients, their axes, and the faces that they make up."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiction.plot.points import Points, contact_points, faces, loaded
from stiction.record.frames import CONTACT_DTYPE, BodyInfo, Frames
from stiction.shapes import Box, Plane


def pairs(a: str, b: str) -> Any:
    static = {("concrete", "wood"): 0.5, ("concrete", "steel"): 0.3, ("steel", "wood"): 0.2}[tuple(sorted((a, b)))]  # type: ignore[index]  # a pair, sorted
    return SimpleNamespace(static=static, dynamic=static / 2)


def make_frames(rows: list[tuple[Any, ...]], offsets: list[int]) -> Frames:
    """A floor, a crate of wood and a lid of steel with these contacts."""
    bodies = [
        BodyInfo("floor", Plane(), "concrete", math.inf, True),
        BodyInfo("crate", Box((1, 1, 1)), "wood", 2.0, False),
        BodyInfo("lid", Box((1, 1, 1)), "steel", 2.0, False),
    ]
    f = len(offsets) - 1
    still = np.zeros((f, 3, 3))
    orientations = np.zeros((f, 3, 4))
    orientations[..., 0] = 1.0
    motion = np.zeros((f, 3), np.uint8)
    times = 0.1 * np.arange(f)
    contacts = np.array(rows, CONTACT_DTYPE)
    return Frames("t", 0.1, bodies, times, still, orientations, still, still, motion, contacts, np.array(offsets))


def row(a: int, b: int, *, point: Any = (0, 0, 0), n: Any = (0, 0, 1), load: float = 1.0, friction: Any = (0, 0, 0),
        held: bool = True) -> tuple[Any, ...]:  # fmt: skip
    return (a, b, point, n, 0.0, load, friction, held)


def test_points_know_their_frame_and_the_coefficients_of_their_materials() -> None:
    frames = make_frames([row(0, 1), row(1, 2), row(0, 2)], [0, 1, 1, 3])
    points = contact_points(frames, pairs)
    assert points.frame.tolist() == [0, 2, 2]
    np.testing.assert_allclose(points.coefficients, [[0.5, 0.25], [0.2, 0.1], [0.3, 0.15]])
    of_lid = contact_points(frames, pairs, [2])
    assert of_lid.frame.tolist() == [2, 2]
    assert len(contact_points(make_frames([], [0, 0]), pairs)) == 0


def test_friction_on_a_level_floor_is_seen_from_above_and_keeps_its_size_on_any_plane(rng: np.random.Generator) -> None:
    flat = contact_points(make_frames([row(0, 1, friction=(3.0, 4.0, 0.0))], [0, 1]), pairs)
    np.testing.assert_allclose(flat.tangential, [[3.0, 4.0]])
    normals = rng.normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[0] = (1.0, 0.0, 0.0)
    tangents = np.cross(normals, rng.normal(size=(50, 3)))
    made = [row(0, 1, n=n, friction=t) for n, t in zip(normals, tangents, strict=True)]
    seen = contact_points(make_frames(made, [0, 50]), pairs).tangential
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), np.linalg.norm(tangents, axis=1))


def test_a_face_is_the_sum_of_its_points() -> None:
    rows = [
        row(0, 1, point=(0, 0, 0), load=1.0, friction=(0.2, 0, 0)),
        row(0, 1, point=(4, 0, 0), load=3.0, friction=(0.3, 0.1, 0), held=False),
        row(1, 2, load=2.0),
        row(0, 1, load=5.0, friction=(0, 1, 0)),
        row(1, 2, load=0.0),
    ]
    made = faces(contact_points(make_frames(rows, [0, 3, 5]), pairs))
    assert [(int(f), int(r["body_a"]), int(r["body_b"])) for f, r in zip(made.frame, made.rows, strict=True)] == [
        (0, 0, 1), (0, 1, 2), (1, 0, 1),
    ]  # fmt: skip
    np.testing.assert_allclose(made.rows["normal_impulse"], [4.0, 2.0, 5.0])
    np.testing.assert_allclose(made.rows["friction_impulse"][0], [0.5, 0.1, 0.0])
    np.testing.assert_allclose(made.rows["point"][0], [3.0, 0.0, 0.0])
    assert made.rows["sticking"].tolist() == [False, True, True]
    np.testing.assert_allclose(made.coefficients[:, 0], [0.5, 0.2, 0.5])


def test_the_normal_of_a_face_is_that_of_its_load() -> None:
    rows = [row(0, 1, n=(1, 0, 0), load=1.0), row(0, 1, n=(0, 1, 0), load=3.0)]
    made = faces(contact_points(make_frames(rows, [0, 2]), pairs))
    np.testing.assert_allclose(made.rows["normal"][0], np.array([1, 3, 0]) / math.sqrt(10))


def test_a_face_whose_normals_cancel_takes_one_of_them() -> None:
    rows = [row(0, 1, n=(1, 0, 0)), row(0, 1, n=(-1, 0, 0))]
    made = faces(contact_points(make_frames(rows, [0, 2]), pairs))
    assert np.abs(made.rows["normal"][0]).tolist() == [1.0, 0.0, 0.0]


def test_what_only_brushes_is_left_out() -> None:
    rows = np.array([row(0, 1, load=load) for load in (1.0, 1.0, 1e-6)], CONTACT_DTYPE)
    points = Points(rows, np.zeros(3, np.int64), np.ones((3, 2)))
    assert loaded(points).rows["normal_impulse"].tolist() == [1.0, 1.0]
    assert len(loaded(points[:0])) == 0
    assert loaded(points[[2]]).rows["normal_impulse"] == pytest.approx([1e-6]), "small is no matter of newtons"

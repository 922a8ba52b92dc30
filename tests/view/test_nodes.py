"""Nodes of viser's tree: each body is drawn where it is, and what stays is not sent again."""

from __future__ import annotations

from typing import Any

import numpy as np

import stiction as st
from stiction.record.recorder import capture
from stiction.view.instances import upright
from stiction.view.overlays import MOST_CONTACTS
from stiction.view.server import Viewer
from stiction.view.session import LiveSession
from stiction.view.stage import _follower


def test_bodies_of_a_shape_are_drawn_where_they_are_whatever_was_added_between_them() -> None:
    world = st.World(gravity=(0, 0, 0))
    # spheres one after another, boxes with capsules between them
    for k in range(4):
        world.add(st.Sphere(0.5), position=(2 * k, 0, 0))
    for k in range(3):
        world.add(st.Box((1, 1, 1)), position=(2 * k, 2, 0), velocity=(0, 0, k))
        world.add(st.Capsule(0.3, 1.0), position=(2 * k, 4, 0), orientation=(1, 0.1 * k, 0, 0))
    with Viewer(LiveSession(world), port=0) as viewer, viewer.lock:
        # no step: among many boxes it would take another kernel
        world.positions[:] += np.arange(10)[:, None]
        viewer._publish()
        drawn = [batch.index.tolist() for batch in viewer._batches]
        assert drawn == [[0, 1, 2, 3], [4, 6, 8], [5, 7, 9]]
        for batch in viewer._batches:
            for handle in (batch.solid, batch._edges):
                np.testing.assert_array_equal(handle.batched_positions, world.positions[batch.index].astype(np.float32))
                np.testing.assert_array_equal(handle.batched_wxyzs, world.orientations[batch.index].astype(np.float32))


def test_of_many_contact_points_those_with_the_largest_load_are_drawn() -> None:
    world = st.World()
    side = 65
    for k in range(side**2):
        # each a little heavier than the one before
        world.add(st.Sphere(0.5), mass=1.0 + 1e-3 * k, position=(2 * (k % side), 2 * (k // side), 0.4999))
    world.add(st.Plane(), static=True)
    world.step(3)
    with Viewer(LiveSession(world), port=0) as viewer, viewer.lock:
        viewer._publish()
        overlays, rows = viewer._overlays, viewer._frame.contacts
        assert len(rows) == side**2
        assert overlays.hidden == side**2 - MOST_CONTACTS
        assert len(overlays.rows) == MOST_CONTACTS
        assert overlays.rows["normal_impulse"].min() >= np.sort(rows["normal_impulse"])[overlays.hidden]
        drawn = overlays.dots.handle.batched_positions
        np.testing.assert_array_equal(drawn, overlays.rows["point"].astype(np.float32))
        tips = overlays._normals.handle.points[:, 1]
        np.testing.assert_array_equal(np.sign(tips - drawn)[:, 2], np.sign(overlays.rows["normal"][:, 2]))


class Node:
    """Counts how often its place is set."""

    def __init__(self) -> None:
        self.places: list[Any] = []

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "position":
            self.places.append(value.tolist())
        object.__setattr__(self, name, value)


def test_a_ground_is_sent_again_only_when_it_has_moved() -> None:
    world = st.World()
    floor = world.add(st.Plane(), kinematic=True, velocity=(0, 0, 1))
    world.add(st.Sphere(0.5), position=(0, 0, 0.5))
    node = Node()
    update = _follower(node, floor.index)
    update(capture(world))
    update(capture(world))
    assert node.places == [[0.0, 0.0, 0.0]]
    floor.position = (0, 0, 2)
    update(capture(world))
    assert node.places == [[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]


def test_what_is_not_turned_is_upright() -> None:
    assert upright(2).tolist() == [[1, 0, 0, 0], [1, 0, 0, 0]]

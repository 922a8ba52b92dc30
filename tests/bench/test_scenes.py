"""The geometry of benchmark scenes: counts, nothing overlapping at the start, and things that must touch touching."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from stiction.bench import SCENES, geometry, granular, make, masonry, rotations, stacks
from stiction.bench.scene import BenchBody, BenchScene, ground
from stiction.errors import InvalidInputError
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Sphere

SMALL = {"pile": 40, "heap": 60, "heap-simple": 60, "spheres": 60, "hopper": 200, "drum": 60}


@pytest.mark.parametrize("name", SCENES)
def test_nothing_overlaps_at_the_start(name: str) -> None:
    scene = make(name, SMALL.get(name))
    overlap = geometry.overlap(scene, scene.positions, scene.orientations)
    assert overlap is None if name == "arch" else overlap is not None and overlap < 1e-9
    low = geometry.lowest(scene, scene.positions, scene.orientations)
    assert low[scene.dynamic].min() > scene.floor - 1e-9


@pytest.mark.parametrize("name", [name for name, entry in SCENES.items() if entry.size <= 1000])
def test_a_scene_has_as_many_dynamic_bodies_as_the_list_says(name: str) -> None:
    scene = make(name)
    assert scene.n == SCENES[name].size
    assert scene.name == name
    assert len(scene.positions) == len(scene.orientations) == len(scene.bodies)
    assert np.allclose(np.linalg.norm(scene.orientations, axis=1), 1.0)


@pytest.mark.parametrize("name", ["heap", "heap-simple", "spheres", "hopper", "drum", "tower-uneven"])
def test_a_seed_makes_the_same_scene_again_and_another_seed_another(name: str) -> None:
    size = SMALL.get(name)
    first, again, other = make(name, size, 3), make(name, size, 3), make(name, size, 4)
    assert np.array_equal(first.positions, again.positions)
    assert np.array_equal(first.orientations, again.orientations)
    assert not np.array_equal(first.positions, other.positions)


def test_mixed_bodies_of_a_heap_are_apart_by_their_bounding_spheres() -> None:
    scene = granular.heap(200, seed=1)
    assert set(scene.kinds) == set(granular.MIXED)
    moving = [(body.position, geometry.reach(body.shape)) for body in scene.bodies if body.dynamic]
    places, reaches = np.array([m[0] for m in moving]), np.array([m[1] for m in moving])
    near = cKDTree(places).query_pairs(2.0 * reaches.max(), output_type="ndarray")
    apart = np.linalg.norm(places[near[:, 0]] - places[near[:, 1]], axis=1) - reaches[near].sum(axis=1)
    assert apart.min(initial=1.0) > 0.0
    assert set(granular.heap(50, kinds=granular.SIMPLE).kinds) == {"box", "sphere"}


def test_hulls_have_their_centre_of_mass_at_the_origin() -> None:
    bodies = [*granular.heap(100).bodies, *masonry.arch().bodies]
    hulls = [body.shape for body in bodies if isinstance(body.shape, ConvexHull)]
    assert len(hulls) > 20
    assert max(np.abs(hull.mass_properties.center_of_mass).max() for hull in hulls) < 1e-12


def test_a_pile_keeps_the_height_of_its_columns() -> None:
    for n in (100, 400):
        scene = stacks.pile(n)
        assert scene.rest is not None
        assert scene.rest[:, 2].max() == 9.5
        assert len(np.unique(scene.positions[1:, :2], axis=0)) == n // 10
    assert stacks.pile(1000).n == 1000


def test_a_pyramid_has_rows_that_touch() -> None:
    scene = stacks.pyramid(10)
    assert scene.n == 55
    assert sorted(set(scene.positions[1:, 2])) == [0.5 + k for k in range(10)]
    assert stacks.pyramid_of(1000).n == 990


def test_towers_are_what_their_names_say() -> None:
    uneven = make("tower-uneven")
    shifts = uneven.positions[1:, :2]
    assert 0.001 < shifts.std() < 0.01
    heavy = make("tower-heavy")
    assert heavy.bodies[-1].density == 100.0 * (heavy.bodies[1].density or 0.0)


@pytest.mark.parametrize("lean", [math.radians(15.0), math.radians(20.0), math.radians(30.0)])
def test_cards_touch_their_partners_and_what_is_above_and_below(lean: float) -> None:
    """A leaning card's lowest corner is on its floor, its highest at the flat cards, its inner one at its partner."""
    scene = masonry.card_house(lean=lean)
    assert scene.n == 40
    length, thickness = 1.0, 0.02
    height = length * math.cos(lean) + thickness * math.sin(lean)
    for left, right in _pairs_of_leaning_cards(scene):
        corners = _corners(left), _corners(right)
        for one in corners:
            storey = (one[:, 2].min() + 1e-9) // (height + thickness)
            assert one[:, 2].min() == pytest.approx(storey * (height + thickness), abs=1e-12)
            assert np.ptp(one[:, 2]) == pytest.approx(height, abs=1e-12)
        assert corners[0][:, 0].max() == pytest.approx(corners[1][:, 0].min(), abs=1e-12)
    # a hair closer, and they would overlap; a hair apart, and nothing would touch
    assert _depth(scene, scene.positions) < 1e-9
    assert _depth(scene, scene.positions * (1.0, 1.0, 0.999)) > 1e-4


def test_feet_of_a_card_house_stand_on_flat_cards_and_tips_carry_them() -> None:
    scene = masonry.card_house()
    flats = [body for body in scene.bodies[1:] if body.orientation == (1.0, 0.0, 0.0, 0.0)]
    assert len(flats) == 10
    pairs = _pairs_of_leaning_cards(scene)
    for left, right in pairs[5:]:  # above the ground
        feet = [_corners(card)[_corners(card)[:, 2].argmin()] for card in (left, right)]
        for foot in feet:
            below = [f for f in flats if abs(f.position[2] + 0.01 - foot[2]) < 1e-9]
            assert any(abs(foot[0] - f.position[0]) < 0.5 * _size(f)[0] for f in below)
    for flat in flats:
        tips = [
            corner
            for pair in pairs
            for card in pair
            for corner in _corners(card)
            if abs(corner[2] - (flat.position[2] - 0.01)) < 1e-9
            and abs(corner[0] - flat.position[0]) < _size(flat)[0] / 2
        ]
        assert {math.copysign(1.0, tip[0] - flat.position[0]) for tip in tips} == {-1.0, 1.0}, "held at both ends"


def test_stones_of_an_arch_share_their_faces() -> None:
    scene = masonry.arch()
    stones = [body for body in scene.bodies if isinstance(body.shape, ConvexHull)]
    assert len(stones) == 21
    clouds = [_corners(stone) for stone in stones]
    for one, other in itertools.pairwise(clouds):
        distances = np.linalg.norm(one[:, None] - other[None], axis=2)
        assert (distances.min(axis=1) < 1e-12).sum() == 4, "four corners are the neighbour's too"
    for cloud in (clouds[0], clouds[-1]):
        assert np.sort(cloud[:, 2])[:4] == pytest.approx(np.zeros(4), abs=1e-12), "flat on the abutment"
    radii = np.hypot(np.concatenate(clouds)[:, 0], np.concatenate(clouds)[:, 2])
    assert (radii.min(), radii.max()) == pytest.approx((4.5, 5.5))


def test_an_arch_is_a_half_circle_from_abutment_to_abutment() -> None:
    scene = masonry.arch()
    first, last = scene.bodies[3].position, scene.bodies[-1].position
    assert first[0] == pytest.approx(-last[0])
    assert first[2] == pytest.approx(last[2])
    blocks = [body for body in scene.bodies if body.density is None]
    assert [block.position[0] for block in blocks[1:]] == [-5.0, 5.0]


def test_a_drum_turns_about_its_axis() -> None:
    scene = granular.drum(20)
    start = scene.driven_at(0.0)
    assert len(start) == 24
    for index, position, orientation in start:
        assert position == pytest.approx(np.array(scene.bodies[index].position))
        assert abs(orientation @ np.array(scene.bodies[index].orientation)) == pytest.approx(1.0)
    moment = 1e-6
    for index, position, _ in scene.driven_at(moment):
        speed = (position - np.array(scene.bodies[index].position)) / moment
        assert speed == pytest.approx(np.array(scene.bodies[index].velocity), abs=1e-4)


def test_spheres_of_a_hopper_are_inside_and_above_the_outlet() -> None:
    scene = make("hopper", 500)
    places = scene.positions[scene.dynamic]
    plates = scene.positions[~scene.dynamic][1:]
    assert np.abs(places[:, :2]).max() < np.abs(plates[:, :2]).max()
    assert places[:, 2].min() > 2.0


def test_a_small_copy_keeps_every_kind_and_all_that_is_fixed() -> None:
    scene = make("heap", 200)
    small = scene.small(2)
    assert small.kinds == scene.kinds
    assert small.n == 10
    assert (~small.dynamic).sum() == (~scene.dynamic).sum()


def test_a_scene_of_one_size_says_so_and_names_are_corrected() -> None:
    with pytest.raises(InvalidInputError, match="must be 21, it comes in no other"):
        make("arch", 50)
    with pytest.raises(InvalidInputError, match="did you mean 'pyramid'"):
        make("pyramidd")


# --- the yardstick ----------------------------------------------------------------------------------------------------


def _scene_of(*bodies: BenchBody) -> BenchScene:
    return BenchScene("two", (ground(), *bodies))


def _overlap(*bodies: BenchBody) -> float:
    scene = _scene_of(*bodies)
    return _depth(scene, scene.positions)


def _depth(scene: BenchScene, positions: np.ndarray) -> float:
    depth = geometry.overlap(scene, positions, scene.orientations)
    assert depth is not None
    return depth


def test_overlaps_are_as_deep_as_they_were_made() -> None:
    cube, ball = Box((1.0, 1.0, 1.0)), Sphere(0.5)
    turn = tuple(rotations.about((0.0, 0.0, 1.0), math.pi / 4.0))
    assert _overlap(BenchBody(cube, (0, 0, 2.0)), BenchBody(cube, (0.2, 0.1, 2.9))) == pytest.approx(0.1)
    assert _overlap(BenchBody(ball, (0, 0, 2.0)), BenchBody(ball, (0.0, 0.0, 2.95))) == pytest.approx(0.05)
    assert _overlap(BenchBody(cube, (0, 0, 2.0)), BenchBody(ball, (0.0, 0.0, 2.97))) == pytest.approx(0.03)
    assert _overlap(BenchBody(cube, (0, 0, 2.0)), BenchBody(ball, (0.1, 0.0, 2.1))) == pytest.approx(0.9)
    # corner of a turned cube against a face of the other: 0.5 + sqrt(0.5) would just touch
    reach = 0.5 + math.sqrt(0.5)
    assert _overlap(BenchBody(cube, (0, 0, 2.0)), BenchBody(cube, (reach - 0.01, 0, 2.0), turn)) == pytest.approx(0.01)
    assert _overlap(BenchBody(cube, (0, 0, 2.0)), BenchBody(cube, (reach + 0.01, 0, 2.0), turn)) == 0.0
    assert _overlap(BenchBody(cube, (0, 0, 0.45))) == pytest.approx(0.05), "in the ground"


def test_lowest_points_of_all_shapes() -> None:
    lying = tuple(rotations.about((0.0, 1.0, 0.0), math.pi / 2.0))
    pyramid = ConvexHull([(0, 0, -0.3), (1, 0, 0.7), (-1, 1, 0.7), (-1, -1, 0.7)])
    shapes = [
        (Sphere(0.2), lying, 0.2),
        (Box((1.0, 2.0, 3.0)), lying, 0.5),
        (Capsule(0.2, 1.0), (1.0, 0.0, 0.0, 0.0), 0.7),
        (Capsule(0.2, 1.0), lying, 0.2),
        (Cylinder(0.3, 1.0), (1.0, 0.0, 0.0, 0.0), 0.5),
        (Cylinder(0.3, 1.0), lying, 0.3),
        (Ellipsoid((0.2, 0.3, 0.4)), (1.0, 0.0, 0.0, 0.0), 0.4),
        (Ellipsoid((0.2, 0.3, 0.4)), lying, 0.2),
        (pyramid, (1.0, 0.0, 0.0, 0.0), 0.3),
    ]
    bodies = [BenchBody(shape, (0.0, 0.0, 5.0), turn) for shape, turn, _ in shapes]  # type: ignore[arg-type]  # a mixed list
    scene = _scene_of(*bodies)
    low = geometry.lowest(scene, scene.positions, scene.orientations)
    assert low[1:] == pytest.approx([5.0 - depth for *_, depth in shapes])


# --- helpers ----------------------------------------------------------------------------------------------------------


def _size(body: BenchBody) -> tuple[float, float, float]:
    assert isinstance(body.shape, Box)
    return body.shape.size


def _corners(body: BenchBody) -> np.ndarray:
    if isinstance(body.shape, ConvexHull):
        local = np.array(body.shape.points)
    else:
        signs = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, -1).T
        local = signs * np.array(_size(body))
    return local @ rotations.matrix(body.orientation).T + np.array(body.position)


def _pairs_of_leaning_cards(scene: BenchScene) -> list[tuple[BenchBody, BenchBody]]:
    leaning = [body for body in scene.bodies[1:] if body.orientation != (1.0, 0.0, 0.0, 0.0)]
    assert len(leaning) == 30
    return list(zip(leaning[::2], leaning[1::2], strict=True))

"""What the pages are made of: meshes that close, a camera that sees all, colours that stay apart."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere
from stiction.view import camera, meshes, style
from stiction.view.survey import corners, matrices, quaternion, round_length

SHAPES: list[Shape] = [
    Sphere(0.7),
    Box((1.0, 2.0, 0.5)),
    Capsule(0.3, 1.1),
    Cylinder(0.6, 0.4),
    Ellipsoid((0.9, 0.3, 0.5)),
    ConvexHull(np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1.5], [1, 1, 1]])),
]

# Machado, Oliveira, Fernandes, "A physiologically-based model for simulation of color vision deficiency", 2009,
# severity 1: what linear RGB looks like to those who miss one kind of cone.
SIGHT = {
    "full": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def volume(mesh: meshes.Mesh) -> float:
    """Enclosed volume by the divergence theorem: positive if every face looks outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def open_edges(mesh: meshes.Mesh) -> int:
    """Edges that not exactly as many faces run along one way as the other; corners at one place count as one."""
    _, place = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    balance: dict[tuple[int, int], int] = {}
    for face in place.reshape(-1)[mesh.faces].tolist():
        for i, j in ((0, 1), (1, 2), (2, 0)):
            p, q = face[i], face[j]
            if p != q:
                balance[min(p, q), max(p, q)] = balance.get((min(p, q), max(p, q)), 0) + (1 if p < q else -1)
    return sum(count != 0 for count in balance.values())


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_solids_are_closed_look_outwards_and_fill_the_shape(shape: Shape) -> None:
    mesh = meshes.solid(shape)
    assert open_edges(mesh) == 0
    # a circle of 40 corners has 0.4 % less area than a round one, a ball of such circles 0.8 % less volume
    assert volume(mesh) == pytest.approx(shape.mass_properties.volume, rel=0.012)
    low, high = meshes.bounds(shape)
    assert mesh.vertices.min(axis=0) == pytest.approx(low)
    assert mesh.vertices.max(axis=0) == pytest.approx(high)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_edges_are_closed_bars_that_hardly_stand_out(shape: Shape) -> None:
    mesh = meshes.edges(shape)
    low, high = meshes.bounds(shape)
    size = float((high - low).mean())
    assert open_edges(mesh) == 0
    assert volume(mesh) > 0
    assert (mesh.vertices >= low - 0.02 * size).all()
    assert (mesh.vertices <= high + 0.02 * size).all()


def test_edges_of_a_hull_skip_the_diagonals_of_flat_faces() -> None:
    cube = ConvexHull(list(itertools.product((0.0, 1.0), repeat=3)))
    bar = len(meshes.edges(Box((1, 1, 1))).faces) / 12
    assert len(meshes.edges(cube).faces) == 12 * bar


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_height_is_that_of_the_highest_vertex(shape: Shape, rng: np.random.Generator) -> None:
    q = rng.normal(size=4)
    rotation = matrices(q / np.linalg.norm(q))
    highest = float((meshes.solid(shape).vertices @ rotation.T)[:, 2].max())
    low, high = meshes.bounds(shape)
    assert highest == pytest.approx(meshes.height(shape, rotation), abs=0.005 * float((high - low).max()))


def test_planes_have_no_mesh_of_their_own() -> None:
    for make in (meshes.solid, meshes.bounds):
        with pytest.raises(TypeError, match="Plane"):
            make(Plane())


def test_prism_is_closed() -> None:
    top = np.array([[0.0, 0, 2], [3, 0, 1], [3, 2, 1], [0, 2, 2]])
    block = meshes.prism(top, top * (1, 1, 0))
    assert open_edges(block) == 0
    assert volume(block) == pytest.approx(3 * 2 * 1.5)


def test_quaternions_and_matrices_agree(rng: np.random.Generator) -> None:
    for q in rng.normal(size=(50, 4)):
        unit = q / np.linalg.norm(q)
        rotation = matrices(unit)
        assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
        assert abs(float(quaternion(rotation) @ unit)) == pytest.approx(1.0)
    quarter = np.array([math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)])
    assert matrices(quarter) @ (1.0, 0.0, 0.0) == pytest.approx([0.0, 1.0, 0.0])


@pytest.mark.parametrize(
    ("length", "nice"), [(0.9, 1.0), (1.3, 1.0), (3.6, 5.0), (0.017, 0.02), (80.0, 100.0), (0.0, 1.0)]
)
def test_grids_have_round_cells(length: float, nice: float) -> None:
    assert round_length(length) == pytest.approx(nice)


# --- camera -----------------------------------------------------------------------------------------------------------


def _picture(view: camera.Camera, points: np.ndarray) -> np.ndarray:
    """Where points are in the picture: -1 to 1 across and upwards."""
    forward = (view.look_at - view.position) / np.linalg.norm(view.look_at - view.position)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    relative = points - view.position
    depth = relative @ forward
    assert (depth > 0).all()
    tan = math.tan(view.field_of_view / 2)
    up = np.cross(right, forward)
    return np.column_stack([relative @ right / (depth * tan * camera.ASPECT), relative @ up / (depth * tan)])


def test_camera_sees_every_point_and_comes_as_near_as_it_can(rng: np.random.Generator) -> None:
    for _ in range(10):
        points = rng.normal(size=(40, 3)) * rng.uniform(0.1, 10.0, 3) + rng.normal(size=3) * 50
        view = camera.place(points, points[None, :5], np.full(5, 0.1), np.full(5, 0.05), np.array([[0.0, 0.0, 1.0]]))
        seen = _picture(view, points)
        sides = np.array([1 - camera.MARGIN_SIDE, 1 - camera.MARGIN_TOP])
        low = np.array([1 - camera.MARGIN_SIDE, 1 - camera.MARGIN_BOTTOM])
        assert (seen <= sides + 1e-9).all()
        assert (seen >= -low - 1e-9).all()
        touched = np.isclose(seen.max(axis=0), sides) & np.isclose(seen.min(axis=0), -low)
        assert touched.any()
        assert view.position[2] > view.look_at[2]


def test_camera_looks_at_a_row_from_the_side_and_at_a_slope_from_above() -> None:
    row = np.zeros((1, 9, 3))
    row[0, :, 1] = 1.8 * np.arange(9)
    radii, cores = np.full(9, 0.87), np.full(9, 0.5)
    points = (row[0][:, None] + corners(np.full(3, -0.5), np.full(3, 0.5))).reshape(-1, 3)
    level = camera.place(points, row, radii, cores, np.array([[0.0, 0.0, 1.0]]))
    back = (level.position - level.look_at) / np.linalg.norm(level.position - level.look_at)
    assert abs(back[0]) > abs(back[1])
    for angle in (-0.5, 0.5):
        normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
        view = camera.place(points, row, radii, cores, normal[None])
        back = (view.position - view.look_at) / np.linalg.norm(view.position - view.look_at)
        assert float(back @ normal) >= camera.LEAST_FACING


# --- colours ----------------------------------------------------------------------------------------------------------


def _lab(color: str, sight: np.ndarray) -> np.ndarray:
    """CIE 1976 L*a*b* of an sRGB colour as seen with a kind of sight."""
    screen = np.array(style.rgb(color)) / 255
    linear = np.where(screen > 0.04045, ((screen + 0.055) / 1.055) ** 2.4, screen / 12.92)
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = xyz @ np.clip(sight @ linear, 0, 1) / (0.9505, 1.0, 1.089)
    f = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("kind", SIGHT)
def test_colours_of_motion_stay_apart_for_every_kind_of_sight(kind: str) -> None:
    sight = np.array(SIGHT[kind])
    for one, other in itertools.combinations(style.MOTION_COLORS.values(), 2):
        # 2.3 is just noticeable, 20 is plain
        assert float(np.linalg.norm(_lab(one, sight) - _lab(other, sight))) > 20, (one, other)


def test_surfaces_keep_the_hue_and_the_order_of_brightness() -> None:
    red, green, blue = style.surface("#e8590c").tolist()
    assert red > green > blue
    greys = [int(style.surface(f"#{value:02x}{value:02x}{value:02x}")[1]) for value in range(0, 256, 16)]
    assert greys == sorted(greys)
    assert greys[0] == 0

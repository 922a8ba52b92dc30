"""Still pictures: bodies are where they are, the nearer one covers the farther one, and bad input is one sentence."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import stiction as st
from stiction import InvalidInputError, Motion, plot
from stiction.plot import painter
from stiction.plot.still import View
from stiction.shapes import Shape

SHAPES: list[Shape] = [
    st.Box((1, 1, 1)), st.Sphere(0.5), st.Cylinder(0.5, 1), st.Capsule(0.3, 0.6), st.Ellipsoid((0.9, 0.4, 0.2)),
    st.ConvexHull([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]),
]  # fmt: skip


def pixels(world: st.World, view: View, **options: object) -> np.ndarray:
    """(300, 300, 3) of the square of 2 m about the origin."""
    figure = Figure(figsize=(3, 3), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    plot.bodies(axes, world, view, **options)  # type: ignore[arg-type]  # passed on
    axes.set(xlim=(-1, 1), ylim=(-1, 1))
    axes.set_axis_off()
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].astype(int)


def reddish(rgb: np.ndarray) -> np.ndarray:
    return (rgb[..., 0] > 100) & (rgb[..., 1] < 140) & (rgb[..., 2] < 140) & (rgb[..., 0] > rgb[..., 2] + 40)


@pytest.mark.parametrize("view", ["side", "front", "top", (-55.0, 28.0), (130.0, 10.0)], ids=str)
@pytest.mark.parametrize("near, far", list(itertools.product(SHAPES, SHAPES)), ids=lambda shape: shape.kind)
def test_the_nearer_body_comes_later(near: Shape, far: Shape, view: View) -> None:
    directions = painter.axes_of(view)
    upright = np.array([1.0, 0, 0, 0])
    first = painter.place(near, directions[2], upright, "#d01010")
    second = painter.place(far, -directions[2], upright, "#1010d0")
    assert painter.in_order([first, second], directions) == [1, 0]
    assert painter.in_order([second, first], directions) == [0, 1]


@pytest.mark.parametrize("near", SHAPES, ids=lambda shape: shape.kind)
def test_the_nearer_body_covers_the_farther_one(near: Shape) -> None:
    view = (-55.0, 28.0)
    toward = painter.axes_of(view)[2]
    world = st.World(gravity=(0, 0, 0))
    world.add(near, position=toward, name="near")
    world.add(st.Box((1, 1, 1)), position=-toward, name="far")
    middle = pixels(world, view, colors={"near": "#d01010", "far": "#1010d0"})[135:165, 135:165]
    assert reddish(middle).mean() > 0.8


def test_a_long_body_in_front_of_a_near_one_is_seen_though_its_middle_is_farther() -> None:
    world = st.World(gravity=(0, 0, 0))
    world.add(st.Box((0.5, 0.5, 0.5)), position=(0, 0, 0), name="small")
    world.add(st.Box((0.4, 9.0, 0.4)), position=(0, 3.0, 0.6), name="long")  # above; most of it far behind
    rgb = pixels(world, (-90.0, 60.0), colors={"small": "#1010d0", "long": "#d01010"})
    where = plot.project((0, 0, 0.8), (-90.0, 60.0))
    row, column = round(150 - 150 * where[1]), round(150 + 150 * where[0])
    assert reddish(rgb[row, column])


def test_a_body_is_drawn_where_project_says() -> None:
    world = st.World()
    world.add(st.Sphere(0.2), position=(0.3, 5.0, -0.4), name="ball")
    rgb = pixels(world, "side", colors="#d01010")
    rows, columns = np.nonzero(reddish(rgb))
    x, y = plot.project((0.3, 5.0, -0.4))
    assert (columns.mean() - 150) / 150 == pytest.approx(x, abs=0.02)
    assert (150 - rows.mean()) / 150 == pytest.approx(y, abs=0.02)
    assert (np.ptp(columns) + 1) / 300 == pytest.approx(0.2, abs=0.02)


def test_colours_say_what_bodies_do() -> None:
    world = st.World()
    world.add(st.Plane(), static=True)
    world.add(st.Box((0.4, 0.4, 0.4)), position=(-0.5, 0, 0.2), name="rests")
    world.add(st.Box((0.4, 0.4, 0.4)), position=(0.2, 0, 0.2), velocity=(1, 0, 0), name="slides")
    world.step(5)
    figure = plot.picture(world, "side", title="two boxes")
    assert figure.get_suptitle() == "two boxes"
    from stiction.plot.still import _colors
    from stiction.view.style import MOTION_COLORS

    assert _colors(world, None)["rests"] == MOTION_COLORS[Motion.STICKING]
    assert _colors(world, None)["slides"] == MOTION_COLORS[Motion.SLIDING]


def test_every_face_of_a_box_is_one_polygon_and_a_cap_is_round() -> None:
    assert sorted(len(face) for face in painter.outline(st.Box((1, 2, 3))).faces) == [4] * 6
    cylinder = painter.outline(st.Cylinder(1, 2))
    assert sorted(len(face) for face in cylinder.faces) == [4] * painter.ROUND + [painter.ROUND] * 2
    assert cylinder.creases.sum() == 2 * painter.ROUND  # both rims, and no line along the side


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"view": "behind"}, "view must be one of"),
        ({"view": (1.0, float("nan"))}, "view must be"),
        ({"view": 3}, "view must be one of 'side', 'front', 'top' or two angles in degrees"),
        ({"only": ["crat"]}, "no body is called 'crat' (did you mean 'crate'?)"),
        ({"alpha": 2.0}, "alpha must be 1 or less"),
        ({"edge": -1.0}, "edge must be"),
        ({"colors": {"crate": "greenish"}}, "colors must be colours"),
        ({"colors": {"crat": "#123456"}}, "no body is called 'crat'"),
    ],
)
def test_bad_input_is_one_sentence(options: dict[str, object], sentence: str) -> None:
    world = st.World()
    world.add(st.Box((1, 1, 1)), name="crate")
    with pytest.raises(InvalidInputError) as caught:
        plot.picture(world, **options)  # type: ignore[arg-type]  # wrong on purpose
    assert sentence in str(caught.value)


def test_a_body_of_another_world_is_refused() -> None:
    world, other = st.World(), st.World()
    stranger = other.add(st.Box((1, 1, 1)), name="crate")
    world.add(st.Box((1, 1, 1)), name="crate")
    with pytest.raises(InvalidInputError, match="of this world"):
        plot.picture(world, only=[stranger])

"""Every kind of figure: it can be drawn, says what its axes are, fits its sheet, and refuses what it cannot show."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

import stiction as st
from stiction import InvalidInputError
from stiction.plot import KINDS, Track, draw, observe, save
from stiction.plot.track import thinned

UNITS = {
    "run": ["(m/s)", "(N)", "(s)"],
    "pull": ["pulling force (N)", "friction force (N)"],
    "load": ["(N)", "(N)"],
    "cone": ["N s)", r"\mu_s g_n"],
    "hodograph": ["(m/s)", "(m/s)"],
    "raster": ["(%)", "time (s)"],
    "energy": ["energy (J)", "time (s)"],
    "phase": ["speed (m/s)", "place (m)"],
    "network": ["across (m)", "height (m)"],
}


@functools.cache
def small_run() -> Track:
    """A crate that slides and turns until it stops, with a ball on its way and a box on a box that stay."""
    world = st.World(dt=0.02, materials=st.MaterialTable.lecture())
    world.add(st.Plane(), static=True, material="concrete", name="floor")
    crate = {"material": "wood", "mass": 5.0}
    world.add(st.Box((0.4, 0.4, 0.2)), position=(0, 0, 0.1), velocity=(1.5, 0, 0), angular_velocity=(0, 0, 3),
              name="crate", **crate)  # fmt: skip
    world.add(st.Sphere(0.1), position=(0, 1, 0.1), velocity=(1, 0, 0), name="ball", **crate)
    world.add(st.Box((0.4, 0.4, 0.2)), position=(0, 2, 0.1), name="lower", **crate)
    world.add(st.Box((0.3, 0.3, 0.2)), position=(0, 2, 0.3), name="upper", **crate)
    return observe(world, 1.0, title="Small things")


@pytest.mark.parametrize("kind", KINDS)
def test_a_figure_names_its_axes_with_units_and_fits_its_sheet(kind: str, tmp_path: Path) -> None:
    from PIL import Image

    figure = draw(kind, small_run())
    assert "Small things" in figure.get_suptitle()
    labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel())]
    for unit in UNITS[kind]:
        assert any(unit in label for label in labels), labels
    with Image.open(save(figure, tmp_path / "a.png")) as picture:
        pixels = np.asarray(picture.convert("RGB"))
    inked = (pixels != 255).any(axis=2)
    assert 0.005 < inked.mean() < 0.98
    edge = np.concatenate([inked[:2].ravel(), inked[-2:].ravel(), inked[:, :2].ravel(), inked[:, -2:].ravel()])
    assert not edge.any(), "something is cut off at the edge"


@pytest.mark.parametrize("kind", [kind for kind in KINDS if KINDS[kind].most != 0])
def test_bodies_are_chosen_by_name_and_a_wrong_one_is_told(kind: str) -> None:
    draw(kind, small_run(), bodies=["crate"])
    with pytest.raises(InvalidInputError, match=r"'crat' \(did you mean 'crate'\?\)"):
        draw(kind, small_run(), bodies=["crat"])
    with pytest.raises(InvalidInputError, match="bodies must be 1 to"):
        draw(kind, small_run(), bodies=[])


def test_a_kind_that_is_not_there_or_shows_no_bodies_is_told() -> None:
    with pytest.raises(InvalidInputError, match=r"kind must be one of .*, got 'con' \(did you mean 'cone'\?\)"):
        draw("con", small_run())
    with pytest.raises(InvalidInputError, match="bodies must be left out for a figure of kind 'energy'"):
        draw("energy", small_run(), bodies=["crate"])


@pytest.mark.parametrize("kind", KINDS)
def test_one_frame_is_enough_and_none_is_too_few(kind: str) -> None:
    whole = small_run()
    first = thinned(whole.frames, 10**6)
    one = Track(first, whole.pairs, whole.gravity, np.zeros((2, 9)))
    draw(kind, one)
    one.frames.times = one.frames.times[:1]
    for name in ("positions", "orientations", "velocities", "angular_velocities", "motion"):
        setattr(one.frames, name, getattr(one.frames, name)[:1])
    one.frames.contacts, one.frames.contact_offsets = one.frames.contacts[:0], np.zeros(2, np.int64)
    draw(kind, Track(one.frames, whole.pairs, whole.gravity, np.zeros((1, 9))))
    one.frames.times = one.frames.times[:0]
    with pytest.raises(InvalidInputError, match="at least one frame"):
        draw(kind, one)


def test_figures_leave_the_global_state_of_matplotlib_alone() -> None:
    import matplotlib as mpl
    from matplotlib import _pylab_helpers

    before = dict(mpl.rcParams)
    for kind in KINDS:
        draw(kind, small_run())
    assert dict(mpl.rcParams) == before
    assert not _pylab_helpers.Gcf.get_all_fig_managers()

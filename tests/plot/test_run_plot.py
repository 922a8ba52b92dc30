"""The figure of a run: forces that add up as they should, axes that show them, a file that can be looked at."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiction.errors import InvalidInputError, OutputError
from stiction.motion import Motion
from stiction.plot.run import BodyForces, body_forces, phases, plot_run, run_figure
from stiction.record.frames import CONTACT_DTYPE, BodyInfo, Frames
from stiction.shapes import Box, Plane
from stiction.view import style

DT = 1 / 100
G = 9.81
STATIC, DYNAMIC = 0.5, 0.3
MASS = 20.0
PUSH = 2.0
STOP = PUSH / (DYNAMIC * G)
"""A crate pushed to 2 m/s stops after v / (mu_d g) = 0.68 s."""


def pairs(a: str, b: str) -> Any:
    """Coefficients that tell which pair was asked for."""
    table = {("concrete", "wood"): (STATIC, DYNAMIC), ("steel", "wood"): (0.2, 0.1), ("concrete", "steel"): (0.9, 0.8)}
    static, dynamic = table[tuple(sorted((a, b)))]  # type: ignore[index]  # a pair, sorted
    return SimpleNamespace(static=static, dynamic=dynamic)


def make_run(crates: int = 1, *, steps: int = 120, mass: float = MASS) -> Frames:
    """Crates on a level floor, given 2 m/s or a tenth of that: they slide and stop, in closed form."""
    times = np.arange(steps, dtype=np.float64) * DT
    bodies = [BodyInfo("floor", Plane(), "concrete", math.inf, True)]
    bodies += [BodyInfo(f"crate {n}", Box((1, 1, 1)), "wood", mass, False) for n in range(crates)]
    shape = (steps, len(bodies), 3)
    positions, velocities = np.zeros(shape), np.zeros(shape)
    motion = np.zeros(shape[:2], dtype=np.uint8)
    orientations = np.zeros((*shape[:2], 4))
    orientations[..., 0] = 1.0
    rows, offsets = [], [0]
    for k, t in enumerate(times):
        for n in range(1, len(bodies)):
            speed = max(0.0, (PUSH if n % 2 else PUSH / 10) - DYNAMIC * G * t)
            velocities[k, n, 0] = speed
            motion[k, n] = Motion.SLIDING if speed else Motion.STICKING
            positions[k, n] = [0.0, 2.0 * n, 0.5]
            normal = mass * G * DT / 4
            drag = DYNAMIC * normal if speed else 0.0
            for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
                point = (x, 2.0 * n + y, 0.0)
                rows.append((0, n, point, (0, 0, 1), 0.0, normal, (-drag, 0, 0), not speed))
        offsets.append(len(rows))
    contacts = np.array(rows, dtype=CONTACT_DTYPE)
    spins = np.zeros(shape)
    return Frames(
        "Push and release", DT, bodies, times, positions, orientations, velocities, spins, motion, contacts,
        np.array(offsets),
    )  # fmt: skip


# --- forces -----------------------------------------------------------------------------------------------------------


def test_friction_lies_on_the_dynamic_limit_until_the_crate_stops() -> None:
    run = make_run()
    forces = body_forces(run, pairs, 1)
    slides = run.times < STOP
    assert forces.static_limit == pytest.approx(STATIC * MASS * G)
    assert forces.dynamic_limit == pytest.approx(DYNAMIC * MASS * G)
    assert forces.friction[slides] == pytest.approx(DYNAMIC * MASS * G)
    assert forces.friction[~slides] == pytest.approx(0.0)
    assert forces.coefficients == {(STATIC, DYNAMIC)}


def test_forces_add_as_vectors_with_the_sign_of_the_side_and_limits_with_their_own_pair() -> None:
    run = make_run(steps=2)
    run.bodies.append(BodyInfo("lid", Box((1, 1, 1)), "steel", 5.0, False))
    rows = [
        (0, 1, (0, 0, 0), (0, 0, 1), 0.0, 8.0 * DT, (3.0 * DT, 0, 0), False),  # on the crate as it stands
        (1, 2, (0, 0, 1), (0, 0, 1), 0.0, 5.0 * DT, (0, 4.0 * DT, 0), False),  # on the lid, so reversed on the crate
    ]
    run.contacts = np.array(rows, dtype=CONTACT_DTYPE)
    run.contact_offsets = np.array([0, 2, 2])
    crate = body_forces(run, pairs, 1)
    assert crate.friction == pytest.approx([5.0, 0.0])
    assert crate.static_limit == pytest.approx([STATIC * 8 + 0.2 * 5, 0.0])
    assert crate.dynamic_limit == pytest.approx([DYNAMIC * 8 + 0.1 * 5, 0.0])
    assert crate.coefficients == {(STATIC, DYNAMIC), (0.2, 0.1)}
    lid = body_forces(run, pairs, 2)
    assert lid.friction == pytest.approx([4.0, 0.0])
    assert lid.static_limit == pytest.approx([1.0, 0.0])

    run.contacts["friction_impulse"][1] = run.contacts["friction_impulse"][0]
    assert body_forces(run, pairs, 1).friction == pytest.approx([0.0, 0.0])


def test_a_body_that_touches_nothing_feels_nothing() -> None:
    run = make_run(steps=3)
    run.contacts, run.contact_offsets = run.contacts[:0], np.zeros(4, dtype=np.int64)
    nothing = body_forces(run, pairs, 1)
    assert isinstance(nothing, BodyForces)
    assert [nothing.friction.tolist(), nothing.static_limit.tolist(), nothing.coefficients] == [[0.0] * 3] * 2 + [set()]
    assert len(run_figure(run, pairs).axes) == 2


def test_phases_are_the_stretches_and_the_last_frame_has_no_length() -> None:
    times = np.array([0.0, 0.1, 0.2, 0.4, 0.5])
    assert phases(times, np.array([True, True, False, True, True])) == [(0.0, 0.2), (0.4, pytest.approx(0.1))]
    assert phases(times, np.zeros(5, dtype=bool)) == []


# --- figure -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("crates", [1, 2, 4, 5, 9])
def test_every_body_has_two_axes_and_all_share_one_legend(crates: int) -> None:
    figure = run_figure(make_run(crates, steps=40), pairs)
    assert len(figure.axes) == 2 * crates
    assert [axes.get_title(loc="left") for axes in figure.axes[::2]] == [f"crate {n}" for n in range(crates)]
    assert all(axes.get_legend() is None for axes in figure.axes)
    (legend,) = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    assert words[:2] == ["speed", "friction force"]
    assert set(words[4:]) <= {"sticking", "sliding"}
    assert figure.get_suptitle() == "Push and release"


def test_axes_show_speed_force_limits_and_phases_with_their_units() -> None:
    run = make_run()
    upper, lower = run_figure(run, pairs).axes
    assert upper.get_ylabel() == "speed\n(m/s)"
    assert lower.get_ylabel() == "friction\n(N)"
    assert lower.get_xlabel() == "time (s)"
    assert upper.get_lines()[0].get_ydata() == pytest.approx(run.velocities[:, 1, 0])
    friction, static, dynamic = (np.asarray(line.get_ydata()) for line in lower.get_lines())
    assert friction[0] == pytest.approx(DYNAMIC * MASS * G)
    assert static == pytest.approx(STATIC * MASS * G)
    assert dynamic == pytest.approx(DYNAMIC * MASS * G)
    assert lower.get_ylim()[1] > STATIC * MASS * G
    assert "0.5" in upper.get_title(loc="right")
    for axes in (upper, lower):
        colors = [tuple(np.round(255 * np.asarray(c.get_facecolor())[0, :3]).astype(int)) for c in axes.collections]
        assert colors == [style.rgb(style.MOTION_COLORS[m]) for m in (Motion.STICKING, Motion.SLIDING)]
        sliding = np.asarray(axes.collections[1].get_paths()[0].vertices)
        assert sliding[:, 0].max() == pytest.approx(STOP, abs=DT)


def test_large_forces_are_in_kilonewtons() -> None:
    lower = run_figure(make_run(mass=5000.0), pairs).axes[1]
    assert lower.get_ylabel() == "friction\n(kN)"
    assert np.asarray(lower.get_lines()[1].get_ydata()) == pytest.approx(STATIC * 5.0 * G)


def test_an_impact_does_not_flatten_the_rest() -> None:
    run = make_run()
    run.contacts["normal_impulse"][:4] *= 500
    lower = run_figure(run, pairs).axes[1]
    assert STATIC * MASS * G < lower.get_ylim()[1] < 3 * STATIC * MASS * G


def test_at_most_nine_bodies_are_shown_and_the_title_says_so() -> None:
    figure = run_figure(make_run(12, steps=5), pairs)
    assert len(figure.axes) == 18
    assert "9 of 12" in figure.get_suptitle()
    chosen = run_figure(make_run(12, steps=5), pairs, bodies=["crate 11", "crate 3"])
    assert [axes.get_title(loc="left") for axes in chosen.axes[::2]] == ["crate 11", "crate 3"]


# --- file -------------------------------------------------------------------------------------------------------------


def test_picture_fits_a_slide_and_is_not_empty(tmp_path: Path) -> None:
    from PIL import Image

    path = plot_run(make_run(3, steps=60), pairs, tmp_path / "run.png")
    assert path == tmp_path / "run.png"
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB"))
    height, width, _ = pixels.shape
    assert width / height == pytest.approx(16 / 9, rel=0.01)
    assert width >= 1900
    share = (pixels != 255).any(axis=2).mean()
    assert 0.3 < share < 0.98
    # nothing is drawn up to the very edge, so nothing is cut off
    frame = np.concatenate([pixels[:3].reshape(-1, 3), pixels[-3:].reshape(-1, 3), pixels[:, :3].reshape(-1, 3)])
    assert (frame == 255).all()


def test_the_ending_chooses_the_format(tmp_path: Path) -> None:
    path = plot_run(make_run(steps=5), pairs, tmp_path / "run.svg")
    assert "<svg" in path.read_text(encoding="utf-8")[:1000]


def test_plots_leave_the_global_state_of_matplotlib_alone(tmp_path: Path) -> None:
    import matplotlib as mpl
    from matplotlib import _pylab_helpers

    before = dict(mpl.rcParams)
    plot_run(make_run(steps=5), pairs, tmp_path / "run.png")
    assert dict(mpl.rcParams) == before
    assert not _pylab_helpers.Gcf.get_all_fig_managers()


def test_an_unwritable_path_is_told_before_any_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stiction.plot.run.run_figure", lambda *_, **__: pytest.fail("work was begun"))
    for path in (tmp_path / "no" / "run.png", tmp_path / "run.exe", tmp_path / "run"):
        with pytest.raises(OutputError, match=r"^path must .+, got .+\.$"):
            plot_run(make_run(steps=3), pairs, path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("bodies", "words"),
    [
        ([], "bodies must be 1 to 9 names, got 0"),
        ([f"crate {n}" for n in range(10)], "bodies must be 1 to 9 names, got 10"),
        (["crat 1"], "'crat 1' (did you mean 'crate 1'?)"),
    ],
)
def test_bad_names_are_refused(bodies: list[str], words: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        run_figure(make_run(12, steps=3), pairs, bodies=bodies)
    assert words in str(caught.value)


def test_runs_without_frames_or_movers_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="at least one frame"):
        run_figure(make_run(steps=0), pairs)
    with pytest.raises(InvalidInputError, match="not fixed"):
        run_figure(make_run(0, steps=3), pairs)

"""The live view of a scene in a browser: what a reader does there reaches the world, and comes back as a picture."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from stiction.view.open import open_scene
from stiction.view.panel import MOST_SUBSTEPS
from stiction.view.server import Viewer
from stiction.view.session import LiveSession
from stiction.view.style import CONTACT_RADIUS
from stiction.view.survey import matrices

from .browsers import CANVAS, Tab, chromium, differing
from .test_session import crate_world

CRATE, PAIR = "performance tire on concrete", ("concrete", "performance tire")

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as one:
        yield one


TRIES = 12
"""Times that the mouse takes hold of something."""


def comes(condition: Callable[[], bool], seconds: float, tab: Tab | None = None) -> bool:
    """Whether something comes in that time, in which the page of ``tab`` may ask for what it needs."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        if tab is None:
            time.sleep(0.02)
        else:
            tab.page.wait_for_timeout(20)
    return True


def until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    """Waits for something that must come; the limit is there for what never comes."""
    assert comes(condition, seconds), "it never came"


def control_of(tab: Tab, label: str) -> Any:
    """What the label beside it belongs to, scrolled into view."""
    one = tab.page.locator(f'[id="{tab.page.get_by_text(label, exact=True).first.get_attribute("for")}"]')
    one.scroll_into_view_if_needed()
    return one


def pull(
    tab: Tab,
    label: str,
    share: float,
    arrived: Callable[[], bool],
    thumb: str = ".mantine-Slider-thumb",
    which: int = 0,
) -> None:
    """Drag a thumb of the slider beside a label with the mouse to a share of its track, until that has arrived.

    As a reader would: where the panel moves while the hand is on its way, the thumb is missed, and taken again.
    """
    for _ in range(TRIES):
        slider = control_of(tab, label)
        start, track = slider.locator(thumb).nth(which).bounding_box(), slider.bounding_box()
        tab.page.mouse.move(start["x"] + start["width"] / 2, start["y"] + start["height"] / 2)
        tab.page.mouse.down()
        wanted = track["x"] + min(max(share * track["width"], 2), track["width"] - 2)
        tab.page.mouse.move(wanted, start["y"] + start["height"] / 2, steps=3)
        tab.page.mouse.up()
        if comes(arrived, 5.0, tab):
            return
    pytest.fail(f"the slider of {label} could not be pulled")


def choose(tab: Tab, label: str, option: str, arrived: Callable[[], bool]) -> None:
    """Take an option of the list beside a label, until that has arrived."""
    wanted = tab.page.get_by_role("option", name=option, exact=True)
    for _ in range(TRIES):
        if not wanted.is_visible():
            control_of(tab, label).click()
        if comes(wanted.is_visible, 5.0, tab):
            wanted.click()
            if comes(arrived, 5.0, tab):
                return
    pytest.fail(f"{option} could not be chosen as {label}")


def pixel_of(viewer: Viewer, tab: Tab, point: np.ndarray) -> tuple[int, int]:
    """Column and row of a point (3,) of the world, in m, in the picture that the reader has of it."""
    camera = next(iter(viewer._server.get_clients().values())).camera
    x, y, z = matrices(np.asarray(camera.wxyz)).T @ (point - camera.position)  # right, down, forward
    area = tab.page.locator(CANVAS).bounding_box()
    height = 2.0 * z * np.tan(camera.fov / 2.0)  # m that the picture shows at that distance
    return round(area["width"] / 2 + x / height * area["height"]), round((0.5 + y / height) * area["height"])


def sliding(session: LiveSession) -> set[str]:
    """Names of the bodies that move by more than 0.2 m/s."""
    speeds = np.linalg.norm(session.world.velocities, axis=1)
    return {body.name for body, speed in zip(session.world, speeds, strict=True) if speed > 0.2}


def test_a_ramp_is_paused_polished_and_tilted_until_its_crates_slide(browser: Any) -> None:
    session = open_scene("ramp")
    assert isinstance(session, LiveSession)
    with Viewer(session, port=0) as viewer:
        tab = Tab(browser, 620, 360)
        tab.open(viewer.url)
        page, crate = tab.page, session.world[CRATE]
        play, reset = (page.get_by_role("button", name=name) for name in ("play / pause", "reset"))
        before = tab.wait_for_picture(lambda seen: len(np.unique(seen.reshape(-1, 3), axis=0)) > 12)

        play.click()
        until(lambda: session.world.steps > 10)
        play.click()
        until(lambda: not session.playing)
        steps = session.world.steps
        tab.wait_for_picture(lambda seen: differing(seen, before) > 50)
        assert session.world.steps == steps
        assert np.linalg.norm(crate.velocity) < 1e-3

        until(lambda: PAIR in session.pairs)
        for which, name in enumerate(("dynamic", "static")):
            arrived = partial(lambda name: getattr(session.world.materials.pair(*PAIR), name) < 0.05, name)
            pull(tab, " on ".join(PAIR), 0.0, arrived, ".multi-slider-thumb", which)
        play.click()
        until(lambda: bool(np.linalg.norm(crate.velocity) > 0.5))

        reset.click()
        until(lambda: session.world[CRATE] is not crate)
        pull(tab, "tilt [°]", 0.12, lambda: session.gravity[1] > 0.05)
        # towards +x, which is down the slope: for the crates it is as steep as both angles together
        slope = math.tan(math.radians(30.0) + session.gravity[1])
        pair, crates = session.world.materials.pair, [body.name for body in session.world if body.mobility == "dynamic"]
        static = {name: pair(*name.split(" on ")).static for name in crates}
        slide, hold = ({name for name in crates if (static[name] < slope) == slides} for slides in (True, False))
        assert "wet rubber on concrete" in slide, "which holds at 30 degrees"
        assert "rubber on concrete" in hold
        until(lambda: sliding(session) >= slide)
        assert not sliding(session) & hold
        assert session.trouble == ""
        assert tab.errors == []
        assert tab.requests == []
        page.close()


def test_solver_and_substeps_are_chosen_as_it_runs_and_a_click_on_a_contact_shows_its_cone(browser: Any) -> None:
    for solver in ("micro", "soft"):
        crate_world(solver=solver).step()  # loads the kernels, or makes them, which no deadline allows for
    session = LiveSession(crate_world())
    world = session.world
    with Viewer(session, port=0) as viewer:
        tab = Tab(browser, 620, 300)
        tab.open(viewer.url)
        page, play = tab.page, tab.page.get_by_role("button", name="play / pause")
        play.click()
        until(lambda: world.steps > 3)
        pull(tab, "substeps", 1.0, lambda: world.substeps == MOST_SUBSTEPS)
        for solver in ("micro", "soft"):
            choose(tab, "solver", solver, partial(lambda solver: world.solver == solver, solver))
            steps = world.steps
            until(partial(lambda steps: world.steps > steps + 3, steps))
        assert session.playing
        assert session.trouble == ""
        play.click()
        until(lambda: not session.playing)

        # the contact that is nearest to the reader, where its dot lies beside the crate: only the dot is there to hit
        rows = session.frame().contacts
        eye = next(iter(viewer._server.get_clients().values())).camera.position
        contact = rows["point"][np.argmin(np.linalg.norm(rows["point"] - eye, axis=1))]
        away = contact - world["crate"].position
        beside = contact + 0.5 * CONTACT_RADIUS * away / np.linalg.norm(away) * (1.0, 1.0, 0.0)
        column, row = pixel_of(viewer, tab, beside)

        def is_green(seen: np.ndarray) -> bool:
            red, green, _ = seen[row, column].tolist()
            return bool(green > red + 40)

        def ring(seen: np.ndarray) -> int:
            red, green, blue = np.moveaxis(seen.astype(int), 2, 0)
            return int(((red > green + 80) & (red > blue + 80)).sum())

        plain = tab.wait_for_picture(is_green)
        assert session.picked is None
        assert ring(plain) == 0
        area = page.locator(CANVAS).bounding_box()
        page.mouse.click(area["x"] + column, area["y"] + row)
        until(lambda: session.picked == world["crate"].index)
        until(lambda: bool(viewer._overlays._cone._mesh.visible))
        assert viewer._overlays._cone._mesh.position == pytest.approx(contact, abs=1e-6)
        # the orange ring of dynamic friction: nothing else in this picture is of its colour
        tab.wait_for_picture(lambda seen: ring(seen) > 10)
        assert tab.errors == []
        assert tab.requests == []
        page.close()

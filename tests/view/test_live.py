"""The live view of a scene in a browser: what a reader does there reaches the world, and comes back as a picture."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from stiction.view.open import open_scene
from stiction.view.server import Viewer
from stiction.view.session import LiveSession

from .browsers import Tab, chromium, differing

CRATE, PAIR = "performance tire on concrete", ("concrete", "performance tire")

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as one:
        yield one


def until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    """Waits for something that must come; the limit is there for what never comes."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.02)


def pull_to_zero(tab: Tab, label: str, which: int) -> None:
    """Drag a thumb of the slider beside a label to the left end of its track."""
    slider = tab.page.locator(f'[id="{tab.page.get_by_text(label, exact=True).first.get_attribute("for")}"]')
    slider.scroll_into_view_if_needed()
    thumb, track = slider.locator(".multi-slider-thumb").nth(which).bounding_box(), slider.bounding_box()
    tab.page.mouse.move(thumb["x"] + thumb["width"] / 2, thumb["y"] + thumb["height"] / 2)
    tab.page.mouse.down()
    tab.page.mouse.move(track["x"] + 2, track["y"] + track["height"] / 2, steps=3)
    tab.page.mouse.up()


def test_a_ramp_is_paused_polished_and_slides_and_a_picked_contact_shows_its_cone(browser: Any) -> None:
    session = open_scene("ramp")
    assert isinstance(session, LiveSession)
    with Viewer(session, port=0) as viewer:
        tab = Tab(browser, 900, 500)
        tab.open(viewer.url)
        page, crate = tab.page, session.world[CRATE]
        play = page.get_by_role("button", name="play / pause")
        before = tab.wait_for_picture(lambda seen: len(np.unique(seen.reshape(-1, 3), axis=0)) > 12)

        play.click()
        until(lambda: session.world.steps > 10)
        play.click()
        until(lambda: not session.playing)
        steps = session.world.steps
        tab.wait_for_picture(lambda seen: differing(seen, before) > 50)
        # what was sent last may still have to be drawn; from then on it stays
        tab.wait_for_picture(lambda seen: differing(seen, tab.picture()) == 0)
        assert session.world.steps == steps
        assert np.linalg.norm(crate.velocity) < 1e-3

        until(lambda: PAIR in session.pairs)
        for which in (0, 1):
            pull_to_zero(tab, " on ".join(PAIR), which)
        until(lambda: session.world.materials.pair(*PAIR).static < 0.05)
        play.click()
        until(lambda: bool(np.linalg.norm(crate.velocity) > 0.5))
        play.click()
        until(lambda: not session.playing)

        plain = tab.picture()
        cone = viewer._overlays._cone._mesh
        assert not cone.visible
        viewer._mail.put("pick", lambda: session.pick(session.world["metal on metal"].index))
        until(lambda: bool(cone.visible))
        tab.wait_for_picture(lambda seen: differing(seen, plain) > 50)
        assert tab.errors == []
        assert tab.requests == []
        page.close()

"""The page of every built-in scene, opened from its file in a browser that reaches no network."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stiction.record.recorder import Recorder
from stiction.record.run import run
from stiction.scene import Simulation, builtin_names, load
from stiction.view.html import write_html

from .browsers import Tab, chromium, differing

SECONDS = 1.0
"""Every scene is cut off after that time."""
FRAME_SECONDS = 0.1
COLORS = 12
"""A picture with fewer colours than this shows nothing."""

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as one:
        yield one


@pytest.mark.parametrize("name", builtin_names())
def test_the_page_of_a_scene_plays_offline(name: str, browser: Any, tmp_path: Path) -> None:
    simulation = Simulation(load(name, [f"duration={SECONDS}"]))
    recorder = Recorder(simulation.world, name, every=max(1, round(FRAME_SECONDS / simulation.world.dt)))
    run(simulation, recorder=recorder)
    page = write_html(recorder.frames(), tmp_path / "page.html")
    tab = Tab(browser, 480, 320)
    try:
        tab.page.context.set_offline(True)
        tab.open(page.as_uri())
        clock = tab.page.locator("input").first
        started = clock.input_value()
        tab.page.wait_for_function("value => document.querySelector('input').value !== value", arg=started)
        tab.page.keyboard.press("Space")  # it ran; paused, it leaves the processor to the pictures
        first = tab.wait_for_picture(lambda seen: len(np.unique(seen.reshape(-1, 3), axis=0)) > COLORS)
        # that picture may be of any time: its clock runs ahead of a browser that draws slowly; so both ends are tried
        ends = cycle(["0.00", f"{SECONDS:.2f}"])

        def moved(seen: NDArray[np.uint8]) -> bool:
            clock.fill(next(ends))
            clock.press("Enter")
            return differing(seen, first) > 20

        tab.wait_for_picture(moved)
        assert tab.errors == []
        assert tab.requests == []
    finally:
        tab.page.close()

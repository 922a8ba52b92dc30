"""A headless Chromium for the tests that look at pages, and its picture as an array."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
ARGUMENTS = (
    "--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()
PATIENCE = 90
"""s at least until a page is given up: on a busy machine one picture may take seconds."""
CANVAS = "canvas[data-engine]"


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser; the test is skipped where there is none, or nothing to drive it."""
    playwright = pytest.importorskip("playwright.sync_api", reason="Playwright drives the browser")
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine")
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


class Tab:
    """A page of a browser, which notes what went wrong in it and what it asked the network for.

    Attributes:
        page: Playwright's.
        errors: exceptions and errors on the console. requests: addresses beyond this file and this machine.
    """

    def __init__(self, browser: Any, width: int, height: int) -> None:
        self.page = browser.new_page(viewport={"width": width, "height": height})
        self.page.set_default_timeout(PATIENCE * 1000.0)
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda line: self.errors.append(line.text) if line.type == "error" else None)
        self.page.route("**/*", self._filter)

    def _filter(self, route: Any) -> None:
        url = route.request.url
        if url.startswith(("file:", "data:", "blob:", "http://127.0.0.1:")):
            route.continue_()
        else:
            self.requests.append(url)
            route.abort()

    def open(self, url: str) -> None:
        """Go there, and wait until the picture has faded in."""
        self.page.goto(url)
        self.page.wait_for_function(
            f"() => {{ const c = document.querySelector('{CANVAS}'); return c && getComputedStyle(c).opacity === '1' }}"
        )

    def picture(self) -> NDArray[np.uint8]:
        """The canvas as it is now, (height, width, 3)."""
        from PIL import Image

        area = self.page.locator(CANVAS).bounding_box()
        return np.asarray(Image.open(io.BytesIO(self.page.screenshot(clip=area))).convert("RGB"))

    def wait_for_picture(self, expected: Any) -> NDArray[np.uint8]:
        """The first picture for which ``expected(picture)`` holds; drawing without a graphics card takes its time."""
        for _ in range(5 * PATIENCE):
            picture = self.picture()
            if expected(picture):
                return picture
            self.page.wait_for_timeout(200)
        pytest.fail("the picture that was expected never came")


def differing(a: NDArray[np.uint8], b: NDArray[np.uint8]) -> int:
    """Pixels that differ by more than what smooth edges do."""
    return int((np.abs(a.astype(int) - b.astype(int)).max(axis=2) > 24).sum())

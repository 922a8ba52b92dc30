"""Takes the picture of the live view that docs/view.md shows: the ramp shortly after its start, one contact picked.

    python docs/make_view_picture.py

needs Chromium and Playwright's Python package.
"""

from __future__ import annotations

import shutil
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

from stiction.view.open import open_scene
from stiction.view.server import Viewer

TARGET = Path(__file__).parent / "_static" / "view.png"
ARGUMENTS = (
    "--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()
STEPS = 20
PATIENCE = 60.0
"""s that the browser may take to draw everything."""


def main() -> None:
    """Take the picture."""
    chromium = next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
    )
    if chromium is None:
        sys.exit("make docs-pictures needs Chromium, and there is none on this machine.")
    session = open_scene("ramp")
    session.pick([body.name for body in session.bodies].index("performance tire on concrete"))
    for _ in range(STEPS):
        session.step()
        session.frame()
    with Viewer(session, port=0) as viewer, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 1360, "height": 800})
        page.goto(viewer.url)
        page.wait_for_selector("canvas", timeout=1000 * PATIENCE)
        page.get_by_text("sliding").first.wait_for(timeout=1000 * PATIENCE)
        time.sleep(6.0)  # the picture is drawn some time after the panel, and nothing in the page says when
        page.screenshot(path=TARGET, timeout=1000 * PATIENCE)
        browser.close()


if __name__ == "__main__":
    main()

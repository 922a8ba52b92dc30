"""Takes the pictures of the live view that docs/view.md shows, from the view itself in a browser.

    python docs/make_view_picture.py [NAME ...]

needs Chromium and Playwright's Python package.
"""

from __future__ import annotations

import shutil
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

from playwright.sync_api import sync_playwright

from stiction.view.open import open_scene
from stiction.view.overlays import SHOWN
from stiction.view.server import Viewer

FOLDER = Path(__file__).parent / "_static"


class Picture(NamedTuple):
    """A picture: its file, the scene, steps before it is taken, who is picked, and what is shown."""

    name: str
    scene: str
    steps: int
    picked: str | None
    layers: tuple[str, ...]


PICTURES = (
    Picture("view", "ramp", 20, "performance tire on concrete", SHOWN),
    Picture("view-heap", "heap", 150, None, ("contacts", "friction", "patches")),
    Picture("view-dominoes", "dominoes", 240, None, ("contacts", "normals")),
    Picture("view-billiards", "billiards", 560, None, ("contacts", "trails")),
    Picture("view-pull", "pull", 90, "crate", SHOWN),
)
ARGUMENTS = (
    "--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync"
).split()
PATIENCE = 60.0
"""s that the browser may take to draw everything."""


def take(picture: Picture, browser: Any) -> None:
    """Take one picture."""
    session = open_scene(picture.scene)
    names = [body.name for body in session.bodies]
    if picture.picked is not None:
        session.pick(names.index(picture.picked))
    with Viewer(session, port=0) as viewer:
        with viewer.lock:
            viewer._overlays.shown = set(picture.layers)
            every = max(1, picture.steps // 140)
            for step in range(picture.steps):
                session.step()
                if step % every == 0 or step == picture.steps - 1:
                    viewer._publish()
        page = browser.new_page(viewport={"width": 1200, "height": 700})
        page.goto(viewer.url)
        page.wait_for_selector("canvas", timeout=1000 * PATIENCE)
        page.get_by_text("sliding").first.wait_for(timeout=1000 * PATIENCE)
        time.sleep(6.0)  # the picture is drawn some time after the panel, and nothing in the page says when
        page.screenshot(path=FOLDER / f"{picture.name}.png", timeout=1000 * PATIENCE)
        page.close()


def main() -> None:
    """Take the pictures, all or those whose names are given."""
    chromium = next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
    )
    if chromium is None:
        sys.exit("make docs-pictures needs Chromium, and there is none on this machine.")
    wanted = [picture for picture in PICTURES if picture.name in sys.argv[1:] or len(sys.argv) == 1]
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        for number, picture in enumerate(wanted, 1):
            print(f"{number} of {len(wanted)}: {picture.name}", flush=True)
            take(picture, browser)
        browser.close()


if __name__ == "__main__":
    main()

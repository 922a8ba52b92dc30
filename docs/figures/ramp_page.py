"""The picture of the README: the page that `stiction run ramp --html` writes, as headless Chromium shows it.

Needs Playwright's Python package and a Chromium, whose path may be given as the first argument.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

TARGET = Path(__file__).parent.parent / "_static" / "ramp.png"
AT = "1.2"
"""Time of the run that is shown, s."""


def main(chromium: str) -> None:
    """Run the scene, open its page, stop it at that time, and take the picture."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page_file = Path(folder) / "ramp.html"
        command = [sys.executable, "-m", "stiction.cli.main", "run", "ramp", "--html", str(page_file)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=chromium, args=flags)
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(page_file.as_uri())
        canvas = "document.querySelector('canvas[data-engine]')"
        page.wait_for_function(f"{canvas} !== null && getComputedStyle({canvas}).opacity == 1")
        page.keyboard.press("Space")
        field = page.locator("input").first
        field.fill(AT)
        field.press("Enter")
        page.wait_for_timeout(3000)
        page.screenshot(path=TARGET)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "/usr/bin/chromium")

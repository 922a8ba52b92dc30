"""The page: what is written, what the recording in it says, and what a browser without a network shows."""

from __future__ import annotations

import base64
import colorsys
import io
import math
import re
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiction import outputs
from stiction.errors import InvalidInputError, OutputError
from stiction.motion import Motion
from stiction.record.frames import CONTACT_DTYPE, BodyInfo, Frames
from stiction.shapes import Box, Plane, Sphere
from stiction.view import html, recording, style

from .browsers import ARGUMENTS, CHROMIUM

DT = 1 / 60
STEPS = 90
SLOPE = math.radians(30.0)
TITLE = 'Three lanes & a ball <on a "ramp">'


def make_ramp(*, steps: int = STEPS) -> Frames:
    """Lanes side by side down a slope of 30 degrees: a crate that holds, one that slides, one that is pushed and stops,
    and a ball that rolls. A point mass a lane, semi-implicit Euler, Coulomb's law with two coefficients."""
    normal = np.array([math.sin(SLOPE), 0.0, math.cos(SLOPE)])
    down = np.array([math.cos(SLOPE), 0.0, -math.sin(SLOPE)])
    side = np.array([0.0, 1.0, 0.0])
    tilt = np.array([math.cos(SLOPE / 2), 0.0, math.sin(SLOPE / 2), 0.0])
    lanes = [("holds", 0.7, 0.6, 0.0), ("slides", 0.3, 0.2, 0.0), ("stops", 1.0, 0.9, 2.0)]
    bodies = [BodyInfo("ramp", Plane(normal), "concrete", math.inf, True)]
    bodies += [BodyInfo(name, Box((1.0, 0.8, 0.6)), "wood", 10.0, False) for name, *_ in lanes]
    bodies += [BodyInfo("ball/1", Sphere(0.4), "rubber", 5.0, False)]

    shape = (steps, len(bodies), 3)
    positions, velocities, spins = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    orientations = np.zeros((steps, len(bodies), 4))
    orientations[:, 0, 0] = 1.0
    motion = np.zeros(shape[:2], dtype=np.uint8)
    rows: list[tuple[Any, ...]] = []
    offsets = [0]
    travelled = np.zeros(len(bodies))
    speed = np.array([0.0, *(push for *_, push in lanes), 0.0])
    for k in range(steps):
        for n in range(1, len(bodies)):
            ball = n == len(bodies) - 1
            pull, press = 9.81 * math.sin(SLOPE), 9.81 * math.cos(SLOPE)
            if ball:
                friction, slides = 2.0 / 7.0 * pull, False
            else:
                _, static, dynamic, _ = lanes[n - 1]
                slides = speed[n] > 0.0 or static * press < pull
                friction = dynamic * press if slides else pull
                # never past zero slip
                friction = min(friction, pull + speed[n] / DT)
            speed[n] += (pull - friction) * DT
            speed[n] = speed[n] if speed[n] > 1e-9 else 0.0
            travelled[n] += speed[n] * DT
            radius = 0.4 if ball else 0.3
            foot = down * travelled[n] + side * (1.4 * n)
            positions[k, n] = foot + radius * normal
            velocities[k, n] = speed[n] * down
            half = travelled[n] / radius / 2
            orientations[k, n] = [math.cos(half), 0.0, math.sin(half), 0.0] if ball else tilt
            motion[k, n] = Motion.ROLLING if ball else Motion.SLIDING if slides else Motion.STICKING
            mass = bodies[n].mass
            corners = [(0.0, 0.0)] if ball else [(a, b) for a in (-0.5, 0.5) for b in (-0.4, 0.4)]
            for a, b in corners:
                point = foot + a * down + b * side
                share = mass * DT / len(corners)
                rows.append((0, n, point, normal, 0.0, press * share, -friction * share * down, not slides))
        offsets.append(len(rows))
    times = np.arange(steps, dtype=np.float64) * DT
    contacts = np.array(rows, dtype=CONTACT_DTYPE)
    return Frames(
        TITLE, DT, bodies, times, positions, orientations, velocities, spins, motion, contacts, np.array(offsets)
    )


@pytest.fixture(scope="module")
def ramp() -> Frames:
    return make_ramp()


@pytest.fixture(scope="module")
def page(ramp: Frames, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return html.write_html(ramp, tmp_path_factory.mktemp("page") / "ramp.html")


def decode(page: Path) -> dict[str, Any]:
    """The recording in a page: length, zstandard, length, MessagePack, arrays."""
    msgpack = pytest.importorskip("msgspec", reason="reads what viser has packed").msgpack
    zstandard = pytest.importorskip("zstandard", reason="reads what viser has packed")
    found = re.search(r'__VISER_EMBED_DATA__="([^"]+)"', page.read_text(encoding="utf-8"))
    assert found
    raw = base64.b64decode(found.group(1))
    inner = zstandard.ZstdDecompressor().decompress(raw[8:], max_output_size=int.from_bytes(raw[:8], "little"))
    size = int.from_bytes(inner[:8], "little")
    content: dict[str, Any] = msgpack.decode(inner[8 : 8 + size])
    return content


def updates(content: dict[str, Any], node: str, prop: str) -> list[float]:
    """Times at which a property of a node is sent."""
    return [
        when
        for when, message in content["messages"]
        if message["type"] == "SceneNodeUpdateMessage" and node in message["name"] and prop in message["updates"]
    ]


# --- the file ---------------------------------------------------------------------------------------------------------


def test_page_is_one_small_file_that_names_no_other_host(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert len(text) < 1_500_000
    assert not re.findall(r"""(?:src|href|action)\s*=\s*["']?(?:https?:)?//""", text)
    assert not re.findall(r"@import|url\(\s*['\"]?https?:", text)


def test_title_is_text_and_never_markup(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "<title>Three lanes &amp; a ball &lt;on a &quot;ramp&quot;&gt;</title>" in text
    assert "<h1>Three lanes &amp; a ball &lt;on a &quot;ramp&quot;&gt;</h1>" in text
    assert TITLE not in text


def test_legend_names_what_occurs_and_nothing_else(page: Path) -> None:
    items = re.findall(r"<li>(.*?)</li>", page.read_text(encoding="utf-8"))
    words = [re.sub("<.*?>", "", item) for item in items]
    assert words == ["sticking", "sliding", "rolling", "contact point", "normal"]
    for item, motion in zip(items, (Motion.STICKING, Motion.SLIDING, Motion.ROLLING), strict=False):
        assert style.MOTION_COLORS[motion] in item


def test_sixty_bodies_of_different_size_stay_small(tmp_path: Path, rng: np.random.Generator) -> None:
    steps, count = 60, 60
    bodies = [BodyInfo(f"box {n}", Box(rng.uniform(0.3, 0.9, 3)), "wood", 1.0, False) for n in range(count)]
    positions = rng.uniform(-5, 5, (1, count, 3)) + np.cumsum(rng.normal(0, 0.02, (steps, count, 3)), axis=0)
    orientations = rng.normal(size=(steps, count, 4))
    orientations /= np.linalg.norm(orientations, axis=2, keepdims=True)
    frames = Frames(
        "Sixty",
        DT,
        bodies,
        np.arange(steps) / 30,
        positions,
        orientations,
        np.zeros_like(positions),
        np.zeros_like(positions),
        rng.integers(1, 5, (steps, count)).astype(np.uint8),
        np.zeros(0, dtype=CONTACT_DTYPE),
        np.zeros(steps + 1, dtype=np.int64),
    )
    assert html.write_html(frames, tmp_path / "sixty.html").stat().st_size < 2_500_000


# --- the recording ----------------------------------------------------------------------------------------------------


def test_recording_runs_in_real_time_and_holds_the_last_picture(page: Path, ramp: Frames) -> None:
    content = decode(page)
    assert content["durationSeconds"] == pytest.approx(ramp.times[-1] + recording.HOLD)
    sent = updates(content, "/bodies/", "batched_positions")
    # the last frame may follow sooner, since it is always shown
    assert np.diff(np.unique(np.round(sent, 6)))[:-1].min() >= 1 / html.MOST_FPS - 1e-3


def test_colours_are_sent_when_the_state_changes_and_only_then(page: Path, ramp: Frames) -> None:
    picked = html.pick_frames(ramp.times, html.MOST_FPS)
    boxes = ramp.motion[picked][:, 2:4]
    changed = np.flatnonzero((boxes[1:] != boxes[:-1]).any(axis=1)) + 1
    assert len(changed) == 1  # the crate that stops
    sent = updates(decode(page), "1 box/solid", "batched_colors")
    assert sent == pytest.approx(ramp.times[picked[changed]].tolist())


def test_every_part_of_the_scene_is_there(page: Path) -> None:
    made = {message["name"]: message["type"] for _, message in decode(page)["messages"] if "props" in message}
    assert made["/ground/ramp/block"] == made["/contacts/points"] == "BatchedMeshesMessage"
    assert made["/ground/ramp/grid"] == "GridMessage"
    assert made["/contacts/normals"] == "ArrowMessage"
    assert {name.split("/")[2] for name in made if name.startswith("/bodies/") and name.count("/") == 3} == {
        "0 box",  # the one that never moves, sent once
        "1 box",
        "2 sphere",
    }
    assert {name for name in made if name.startswith("/names/")} == {
        "/names/holds",
        "/names/slides",
        "/names/stops",
        "/names/ball\u22151",
    }


def test_contacts_change_from_frame_to_frame(page: Path) -> None:
    content = decode(page)
    assert len(updates(content, "/contacts/points", "batched_positions")) > 0.9 * STEPS / 2
    assert len(updates(content, "/contacts/normals", "points")) > 0.9 * STEPS / 2
    # two colours: at the start, and when the crate stops
    assert len(updates(content, "/contacts/points", "batched_colors")) == 2


def test_one_frame_is_a_picture_that_does_not_run(tmp_path: Path) -> None:
    assert decode(html.write_html(make_ramp(steps=1), tmp_path / "one.html"))["durationSeconds"] == 0.0


def test_frames_without_bodies_are_a_page_too(tmp_path: Path) -> None:
    empty = np.zeros((2, 0, 3))
    frames = Frames(
        "Nothing",
        DT,
        [],
        np.array([0.0, DT]),
        empty,
        np.zeros((2, 0, 4)),
        empty,
        empty,
        np.zeros((2, 0), dtype=np.uint8),
        np.zeros(0, dtype=CONTACT_DTYPE),
        np.zeros(3, dtype=np.int64),
    )
    assert "Nothing" in html.write_html(frames, tmp_path / "nothing.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("rate", "fps", "count"),
    [(60, 30.0, 31), (60, 60.0, 61), (60, 25.0, 26), (240, 30.0, 31), (10, 30.0, 11), (60, 7.0, 8)],
)
def test_frames_are_thinned_evenly(rate: int, fps: float, count: int) -> None:
    times = np.arange(rate + 1) / rate
    picked = html.pick_frames(times, fps)
    assert len(picked) == count
    assert (picked[0], picked[-1]) == (0, rate)
    assert np.ptp(np.diff(picked)) <= 1


def test_the_last_frame_is_always_shown() -> None:
    assert html.pick_frames(np.array([0.0, 0.01, 0.02, 0.03]), 30.0).tolist() == [0, 3]


# --- how it is made ---------------------------------------------------------------------------------------------------


def test_progress_rises_from_0_to_1_and_nothing_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    shares: list[float] = []
    html.write_html(make_ramp(steps=12), tmp_path / "a.html", progress=shares.append)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert shares == sorted(shares)
    assert len(shares) > 5
    assert capfd.readouterr() == ("", "")


def test_the_server_listens_here_only_and_is_gone_afterwards(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import viser

    seen: list[tuple[str, int]] = []
    original = viser.ViserServer.__init__

    def spy(self: Any, **options: Any) -> None:
        original(self, **options)
        seen.append((self.get_host(), self.get_port()))

    monkeypatch.setattr(viser.ViserServer, "__init__", spy)
    before = set(threading.enumerate())

    def interrupt(share: float) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        html.write_html(make_ramp(steps=12), tmp_path / "a.html", progress=interrupt)
    html.write_html(make_ramp(steps=2), tmp_path / "b.html")
    assert [host for host, _ in seen] == ["127.0.0.1"] * 2
    assert all(port > 0 for _, port in seen)
    deadline = time.monotonic() + 10.0
    while (left := set(threading.enumerate()) - before) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not left
    assert not (tmp_path / "a.html").exists()


def test_an_unwritable_path_is_told_before_any_work(
    tmp_path: Path, ramp: Frames, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording, "record", lambda *_: pytest.fail("work was begun"))
    (tmp_path / "file").write_text("x")
    for path in (tmp_path / "no" / "page.html", tmp_path, tmp_path / "file" / "page.html"):
        with pytest.raises(OutputError, match=r"path must be a file that can be written, got '.+' \(.+\)\.$") as caught:
            html.write_html(ramp, path)
        assert isinstance(caught.value, OSError)
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_a_disk_that_fills_up_is_an_output_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OutputError, match="No space left on device"):
        html.write_html(make_ramp(steps=1), tmp_path / "a.html")


def test_a_file_that_is_there_survives_the_check(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text("old")
    outputs.writable("path", path)
    assert path.read_text() == "old"


@pytest.mark.parametrize("fps", [0, -1.0, math.nan, math.inf, "fast"])
def test_a_bad_rate_is_refused(tmp_path: Path, ramp: Frames, fps: Any) -> None:
    with pytest.raises(InvalidInputError, match=r"^fps must be .+, got .+\.$"):
        html.write_html(ramp, tmp_path / "a.html", fps=fps)
    assert not list(tmp_path.iterdir())


def test_no_frames_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="at least one frame"):
        html.write_html(make_ramp(steps=0), tmp_path / "a.html")


# --- in a browser -----------------------------------------------------------------------------------------------------


def _count_like(pixels: np.ndarray, color: str) -> int:
    """Pixels with the hue of a colour that are strong enough to have one."""
    hue = colorsys.rgb_to_hsv(*(c / 255 for c in style.rgb(color)))[0]
    close = 0
    values, counts = np.unique(pixels.reshape(-1, 3), axis=0, return_counts=True)
    for value, count in zip(values / 255.0, counts, strict=True):
        h, s, _ = colorsys.rgb_to_hsv(*value)
        if s > 0.35 and min(abs(h - hue), 1 - abs(h - hue)) < 0.035:
            close += int(count)
    return close


@pytest.mark.browser
@pytest.mark.skipif(CHROMIUM is None, reason="needs a Chromium to open the page in")
def test_page_plays_without_a_network(page: Path) -> None:
    sync_api = pytest.importorskip("playwright.sync_api", reason="needs Playwright to drive the browser")
    requests: list[str] = []
    errors: list[str] = []

    def block(route: Any) -> None:
        requests.append(route.request.url)
        if route.request.url.startswith("file:"):
            route.continue_()
        else:
            route.abort()

    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        try:
            tab = browser.new_page(viewport={"width": 560, "height": 360})
            tab.on("pageerror", lambda error: errors.append(str(error)))
            tab.route("**/*", block)
            tab.goto(page.as_uri())
            clock = tab.locator("input").first
            clock.wait_for()
            started = clock.input_value()
            tab.wait_for_function("value => document.querySelector('input').value !== value", arg=started)
            tab.keyboard.press("Space")  # it ran; paused, it takes a time to go to, and leaves the processor alone
            # the player fades the picture in
            tab.wait_for_function(
                "() => getComputedStyle(document.querySelector('canvas[data-engine]')).opacity === '1'"
            )

            assert tab.title() == TITLE
            assert tab.locator("#stiction h1").is_visible()
            assert tab.locator("#stiction h1").inner_text() == TITLE
            assert tab.locator("#stiction li").count() == 5
            assert all(item.is_visible() for item in tab.locator("#stiction li").all())
            # two crates slide at first, one at the end; the other way round for sticking
            early = _picture_at(tab, 0.2, lambda seen: min(seen.values()) > 100)
            late = _picture_at(
                tab,
                (STEPS - 1) * DT,
                lambda seen: (
                    seen[Motion.STICKING] > 1.3 * early[Motion.STICKING]
                    and 1.3 * seen[Motion.SLIDING] < early[Motion.SLIDING]
                ),
            )
        finally:
            browser.close()

    assert not errors
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
    assert late[Motion.ROLLING] > 100


def _picture_at(tab: Any, when: float, expected: Callable[[dict[Motion, int]], bool]) -> dict[Motion, int]:
    """Pixels in the colour of every state at a time of the run, once they are as expected.

    Software rendering takes its time, and the picture of the moment before stays until it is done.
    """
    from PIL import Image

    clock = tab.locator("input").first
    clock.fill(f"{when:.2f}")
    clock.press("Enter")
    assert float(clock.input_value()) == pytest.approx(when, abs=0.05)
    area = tab.locator("canvas[data-engine]").bounding_box()
    seen: dict[Motion, int] = {}
    for _ in range(60):
        picture = np.asarray(Image.open(io.BytesIO(tab.screenshot(clip=area))).convert("RGB"))
        seen = {
            motion: _count_like(picture, style.MOTION_COLORS[motion])
            for motion in (Motion.STICKING, Motion.SLIDING, Motion.ROLLING)
        }
        if expected(seen):
            return seen
        tab.wait_for_timeout(500)
    pytest.fail(f"pixels by colour at {when} s: {seen}")

"""The live view's server: its port, its loop, slow and hostile clients; and what a browser shows."""

from __future__ import annotations

import secrets
import socket
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stiction as st
from stiction.cli import main as cli
from stiction.errors import InvalidInputError
from stiction.view.server import Viewer, free_port
from stiction.view.session import LiveSession

from .browsers import ARGUMENTS, CHROMIUM

websockets = pytest.importorskip("websockets.sync.client", reason="viser brings it")


def until(condition: Callable[[], bool], seconds: float = 30.0) -> None:
    """Waits for something that must come; the limit is there for what never comes."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.01)


def a_world(count: int = 1) -> st.World:
    world = st.World()
    world.materials.set_pair("wood", "concrete", static=0.5, dynamic=0.3)
    world.add(st.Plane(), static=True, material="concrete", name="floor")
    for k in range(count):
        place = (2.0 * (k % 40), 2.0 * (k // 40), 0.5)
        # among many boxes boxes could meet, which takes another kernel
        shape = st.Box((1, 1, 1)) if count == 1 else st.Sphere(0.5)
        world.add(shape, material="wood", mass=10.0, position=place, name=f"crate {k}")
    return world


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    session = LiveSession(a_world())
    session.playing = True
    with Viewer(session, port=0) as one:
        yield one


def connect(viewer: Viewer, *, greet: bool = True, **options: Any) -> Any:
    """A client: viser counts one as soon as it has told where its camera is."""
    import msgspec
    import viser
    from viser._messages import ViewerCameraMessage

    client = websockets.connect(
        f"ws://127.0.0.1:{viewer.port}",
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
        ping_interval=None,
        **options,
    )
    if greet:
        camera = ViewerCameraMessage((1, 0, 0, 0), (5, 5, 5), 0.8, 0.01, 100.0, 480, 640, (0, 0, 0), (0, 0, 1))
        client.send(msgspec.msgpack.encode(camera.as_serializable_dict()))
    return client


# --- the port ---------------------------------------------------------------------------------------------------------


def test_it_listens_on_this_machine_alone(viewer: Viewer) -> None:
    assert viewer.url == f"http://127.0.0.1:{viewer.port}"
    with urllib.request.urlopen(viewer.url) as answer:
        assert b"<title>" in answer.read()
    assert viewer._server.get_host() == "127.0.0.1"


def test_a_taken_port_is_replaced_by_a_free_one() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        other = free_port("127.0.0.1", port)
        assert other not in (0, port)
        with Viewer(LiveSession(a_world()), port=port) as viewer:
            assert viewer.port != port
            with urllib.request.urlopen(viewer.url) as answer:
                assert answer.status == 200


@pytest.mark.parametrize(
    ("host", "port", "message"),
    [
        ("203.0.113.7", 8080, "host must be an address of this machine"),
        ("", 8080, "host must be an address"),
        ("127.0.0.1", -1, "port must be"),
        ("127.0.0.1", 70000, "port must be 65535 or less, got 70000"),
    ],
)
def test_bad_addresses_are_refused(host: str, port: int, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        free_port(host, port)


def test_no_client_can_open_a_tunnel(viewer: Viewer) -> None:
    assert viewer._server.request_share_url() is None


# --- the loop ---------------------------------------------------------------------------------------------------------


def test_time_runs_only_while_someone_looks(viewer: Viewer) -> None:
    until(lambda: viewer.sent >= 1)
    assert viewer.session.world.steps == 0  # type: ignore[attr-defined]  # a live session
    with connect(viewer):
        until(lambda: viewer.session.world.steps > 5)  # type: ignore[attr-defined]  # a live session
    until(lambda: viewer.clients == 0)


def test_stop_closes_the_port_and_ends_the_thread() -> None:
    viewer = Viewer(LiveSession(a_world()), port=0)
    viewer.stop()
    viewer.stop()
    assert not viewer._thread.is_alive()
    with pytest.raises(OSError, match="refused"), socket.create_connection(("127.0.0.1", viewer.port), timeout=2.0):
        pass


def test_garbage_from_200_clients_neither_ends_the_view_nor_stays_in_memory(
    viewer: Viewer, rng: np.random.Generator
) -> None:
    resource = pytest.importorskip("resource", reason="tells the memory of a process, on Unix alone")
    settled = 0
    for k in range(200):
        with connect(viewer, greet=k % 2 == 0) as client:
            client.send(rng.bytes(int(rng.integers(1, 2000))) if k % 3 else "no bytes but a text")
        if k == 20:
            settled = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(5):
        with socket.create_connection(("127.0.0.1", viewer.port)) as raw:
            raw.sendall(secrets.token_bytes(200))
    until(lambda: viewer.clients == 0)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 1.05 * settled
    before = viewer.sent
    with connect(viewer) as client:
        assert client.recv(timeout=10.0)
        until(lambda: viewer.sent > before + 5)
    assert viewer.session.trouble == ""


def test_a_client_that_does_not_read_drops_frames_and_costs_no_memory() -> None:
    session = LiveSession(a_world(1500))
    # all on their way up for a second: each frame is new to the last number
    session.world.velocities[1:, 2] = 10.0
    session.speed = 0.05
    session.playing = True
    with Viewer(session, port=0) as viewer, socket.socket() as narrow:
        # hardly any room on the way, so that what is not read stays with the sender
        narrow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        narrow.connect(("127.0.0.1", viewer.port))
        stuck = connect(viewer, max_queue=1, sock=narrow)
        buffer = viewer._server._websock_server._broadcast_buffer
        until(lambda: viewer.sent >= 10)
        waiting, steps, sent = len(buffer.message_from_id), session.world.steps, viewer.sent
        with connect(viewer) as quick:
            for _ in range(10):
                assert quick.recv(timeout=10.0)
            until(lambda: viewer.sent >= sent + 30)
            until(lambda: buffer.message_counter - min(buffer.generator_cursors.values()) > 30)
            # far behind: the world went on, the quick client got news, and nothing piled up for the stuck one
            assert session.world.steps > steps
            assert len(buffer.message_from_id) <= waiting + 20
        stuck.close_socket()


def test_what_goes_wrong_in_a_letter_is_told_and_the_view_goes_on(viewer: Viewer) -> None:
    viewer._mail.put("bad", lambda: viewer.session.pick(99))
    until(lambda: viewer.session.trouble != "")
    assert "body must be the number" in viewer.session.trouble
    assert viewer._thread.is_alive()


# --- the command ------------------------------------------------------------------------------------------------------


def test_the_command_refuses_what_it_cannot_show(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("warnings.showwarning", lambda *_, **__: None)
    monkeypatch.setattr("warnings.simplefilter", lambda *_, **__: None)
    for arguments, words in (
        (["view", "rampp"], "did you mean"),
        (["view", "nowhere.h5"], "nowhere.h5"),
        (["view", "nowhere.h5", "--set", "world.dt=1"], "--set must be left out"),
    ):
        monkeypatch.setattr("sys.argv", ["stiction", *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
        assert end.value.code == 2
        assert words in capsys.readouterr().err


# --- a browser --------------------------------------------------------------------------------------------------------


@pytest.mark.browser
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_buttons_and_the_mouse_reach_the_world_from_a_browser(viewer: Viewer, tmp_path: Path) -> None:
    playwright = pytest.importorskip("playwright.sync_api", reason="drives the browser")
    world = viewer.session.world  # type: ignore[attr-defined]  # a live session
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 1000, "height": 640})
        page.goto(viewer.url)
        page.wait_for_selector("canvas")
        until(lambda: world.steps > 3)
        page.get_by_role("button", name="play / pause").click()
        until(lambda: not viewer.session.playing)
        steps = world.steps
        page.get_by_role("button", name="step", exact=True).click()
        until(lambda: world.steps == steps + 1)
        page.get_by_role("button", name="reset").click()
        until(lambda: world["crate 0"].position[2] == 0.5)
        page.get_by_role("button", name="play / pause").click()
        # the crate is in the middle of the picture: pull it to the side
        box = page.locator("canvas").first.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 60, y - 60, steps=5)
        until(lambda: viewer.session.grab is not None)  # type: ignore[attr-defined]  # a live session
        page.mouse.move(x + 160, y - 120, steps=5)
        until(lambda: bool(np.linalg.norm(world["crate 0"].position[:2]) > 0.2))
        page.mouse.up()
        until(lambda: viewer.session.grab is None)  # type: ignore[attr-defined]  # a live session
        page.mouse.click(x, y)
        page.screenshot(path=tmp_path / "view.png")
        browser.close()

"""The live view: a session in the browser, by viser. One thread steps and sends what there is to see.

A client that is slow does not hold anything up: what was not sent yet is replaced by what is newer, in viser's buffer,
which keeps one message for each property of each node.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from stiction import checks
from stiction.errors import InvalidInputError, StictionError
from stiction.record.recorder import Frame
from stiction.view.mailbox import Mailbox
from stiction.view.nodes import Batch, add_bodies, add_names
from stiction.view.overlays import Overlays, body_colors
from stiction.view.pacer import Pacer
from stiction.view.panel import Panel
from stiction.view.session import LiveSession, Session
from stiction.view.stage import add_grounds, first_view, quiet, set_stage
from stiction.view.survey import Survey, survey, world_corners

if TYPE_CHECKING:
    from viser import ViserServer

HOST = "127.0.0.1"
PORT = 8080
"""The usual port; another one that is free where it is taken."""
FRAMES_PER_SECOND = 30.0
SMOOTH = 0.2
"""Share of the newest frame in what a frame is expected to take: what is left of its time is there for steps."""
REFRESHES = 5.0
"""How often a second the panel is brought up to date."""
ROOM = 6.0
"""How far around the bodies the first picture reaches at most, in sizes of a typical one, if fixed bodies are there."""

AHEAD = 1.0
"""s that bodies are followed for, straight on, to see where a world that nobody has let run may go."""
CELL_HEIGHT = 420
"""Pixels, in a notebook: beside the panel a cell of usual width then leaves a picture that is no higher than wide."""
NARROWER = 1.35
"""How much farther away the reader stands than before the page, since the panel makes the picture narrower."""

log = logging.getLogger("stiction")


class Viewer:
    """A session in the browser.

    Args:
        session: what to show.
        host: address to listen at; only this machine can connect to 127.0.0.1.
        port: where; if it is taken, any that is free.

    Raises:
        InvalidInputError: the host is no address of this machine, or the port no number from 0 to 65535.
    """

    def __init__(self, session: Session, *, host: str = HOST, port: int = PORT) -> None:
        self.session = session
        self.sent = 0
        """Frames handed to viser so far."""
        self._mail = Mailbox()
        self._stopped = threading.Event()
        self._dirty = True
        self._note = ""
        self.lock = threading.RLock()
        """Held while the session is touched."""
        self._server = _serve(host, free_port(host, port))
        self.host = host
        self.port = int(self._server.get_port())
        frame = session.frame()
        self._frame = frame
        self._batches = self._put_up(frame)
        self._refresh()
        self._thread = threading.Thread(target=self._loop, name="stiction view", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Address for a browser."""
        host = "127.0.0.1" if self.host in ("0.0.0.0", "") else self.host
        return f"http://{host}:{self.port}"

    @property
    def clients(self) -> int:
        """Browsers that are connected."""
        return len(self._server.get_clients())

    def stop(self) -> None:
        """End the view and close its port; nothing happens if it is closed already."""
        if self._stopped.is_set():
            return
        self._stopped.set()
        self._thread.join(timeout=10.0)
        with quiet():
            self._server.stop()

    def wait(self) -> None:
        """Until the view is stopped."""
        while not self._stopped.wait(0.2):
            pass

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"<Viewer of {self.session.title!r} at {self.url}>"

    def _repr_html_(self) -> str:
        return (
            f'<iframe src="{self.url}" width="100%" height="{CELL_HEIGHT}" style="border:1px solid #dee2e6"></iframe>'
        )

    # --- the scene ----------------------------------------------------------------------------------------------------

    def _put_up(self, frame: Frame) -> list[Batch]:
        session, server = self.session, self._server
        frames = session.survey_frames()
        seen = survey(frames)
        if len(frames) == 1:
            seen = _with_room(frames, seen)
        view = first_view(frames, seen)
        back = view.look_at + NARROWER * (view.position - view.look_at)
        view = replace(view, position=back)
        set_stage(server, view)
        self._updates = add_grounds(server, frames, seen, view)
        static = np.array([body.fixed for body in session.bodies])
        if isinstance(session, LiveSession):
            static = np.array([body.mobility == "static" for body in session.world])
        batches = add_bodies(server, session.bodies, frame, static)
        self._updates += add_names(server, session.bodies, seen)
        self._overlays = Overlays(server, session.bodies, frame, seen.typical)
        self._panel = Panel(server, session, self._overlays, self._mail, self._overlays.forget)
        self._listen(batches)
        return batches

    def _listen(self, batches: list[Batch]) -> None:
        """Clicks pick, drags pull. The callbacks are coroutines, which viser calls in order."""
        for batch in batches:
            self._listen_to(batch)

        @self._overlays.dots.handle.on_click
        async def _(event: Any) -> None:
            self._mail.put("pick", lambda: self._pick_contact(event.instance_index))

    def _listen_to(self, batch: Batch) -> None:
        session = self.session

        @batch.solid.on_click
        async def _(event: Any) -> None:
            number = _number(batch, event.instance_index)
            origin, direction = np.array(event.ray_origin), np.array(event.ray_direction)
            self._mail.put("pick", lambda: self._pick_body(number, origin, direction))

        if not isinstance(session, LiveSession):
            return

        @batch.solid.on_drag("left")
        async def _(event: Any) -> None:
            number, live = _number(batch, event.instance_index), session
            start, end = np.array(event.start_position), np.array(event.end_position)
            if event.phase == "start":
                self._mail.put("seize", lambda: live.seize(number, start))
            elif event.phase == "end":
                self._mail.put("release", live.release)
            self._mail.put("drag", lambda: live.drag(end))

    def _pick_contact(self, index: int | None) -> None:
        if index is not None and index < len(self._overlays.rows):
            row = self._overlays.rows[index]
            a, b = int(row["body_a"]), int(row["body_b"])
            self.session.pick(a if self.session.bodies[b].fixed else b, row["point"])

    def _pick_body(self, body: int, origin: Any, direction: Any) -> None:
        """Pick a body, and of its contacts the one that the ray passes nearest."""
        rows = self._overlays.rows
        mine = rows[(rows["body_a"] == body) | (rows["body_b"] == body)]
        arms = mine["point"] - origin
        miss = np.linalg.norm(np.cross(arms, direction), axis=1)
        self.session.pick(body, mine["point"][np.argmin(miss)] if len(mine) else None)

    # --- the loop -----------------------------------------------------------------------------------------------------

    def _loop(self) -> None:
        pacer = Pacer(1.0 / FRAMES_PER_SECOND)
        then = time.perf_counter()
        simulated = 0.0
        showing = 0.0  # s that a frame takes, about
        while not self._stopped.is_set():
            elapsed = pacer.begin()
            letters = self._mail.take()
            # nobody sees a world that nobody looks at
            if self.clients or letters or self._dirty:
                with self.lock:
                    before = self._now()
                    self._act(letters)
                    moved = self.clients > 0 and self._tick(elapsed, pacer.left() - showing)
                    if moved or letters or self._dirty or self._stepped_elsewhere():
                        began = time.perf_counter()
                        self._guarded(self._publish)
                        showing += SMOOTH * (time.perf_counter() - began - showing)
                    simulated += max(0.0, self._now() - before)
                    now = time.perf_counter()
                    if now - then > 1.0 / REFRESHES:
                        self._note = _pace(simulated, now - then, self.session)
                        then, simulated = now, 0.0
                        self._guarded(self._refresh)
            else:
                then, simulated = time.perf_counter(), 0.0
            self._stopped.wait(pacer.rest())

    def _stepped_elsewhere(self) -> bool:
        """Whether a program has taken steps of the world since the last frame."""
        return isinstance(self.session, LiveSession) and self.session.world.time != self._frame.time

    def _now(self) -> float:
        session = self.session
        return session.world.time if isinstance(session, LiveSession) else 0.0

    def _tick(self, elapsed: float, room: float) -> bool:
        return bool(self._guarded(lambda: self.session.tick(elapsed, room)))

    def _act(self, letters: list[Any]) -> None:
        for letter in letters:
            self._guarded(letter)

    def _guarded(self, action: Any) -> Any:
        """What goes wrong is told to the reader and ends the play, but not the view."""
        try:
            return action()
        except StictionError as error:
            self.session.trouble, self.session.playing = str(error), False
        except Exception as error:
            log.exception("the view stumbled")
            self.session.trouble, self.session.playing = f"{type(error).__name__}: {error}", False
        return None

    def _publish(self) -> None:
        """Hand a frame to viser."""
        self._dirty = False
        frame = self.session.frame()
        colors = body_colors(frame, self.session.asleep())
        with self._server.atomic():
            for batch in self._batches:
                if not batch.rests:
                    batch.show(frame, colors)
            for update in self._updates:
                update(frame)
            self._overlays.show(frame, self.session)
        self._frame = frame
        self.sent += 1

    def _refresh(self) -> None:
        words = [note for note in (self.session.note, self._note) if note]
        if self._overlays.hidden:
            words.append(f"the {self._overlays.hidden} contact points with the least load are not shown")
        self._panel.refresh(self._frame.time, len(self._frame.contacts), "; ".join(words))


def _number(batch: Batch, instance: int | None) -> int:
    """Number of the body that is an instance of a batch."""
    return int(batch.index[instance or 0])


def _pace(simulated: float, elapsed: float, session: Session) -> str:
    """Says so if a world is slower than it should be."""
    if not (session.live and session.playing) or elapsed <= 0.0:
        return ""
    pace = simulated / elapsed
    return "" if pace > 0.8 * session.speed else f"slower than asked for: {pace:.2g} of {session.speed:g} x"


def _with_room(frames: Any, seen: Survey) -> Survey:
    """The survey with fixed bodies near those that move, and where these come if they go straight on along the ground:
    nobody knows yet where they will go.
    """
    fixed = [n for n, body in enumerate(frames.bodies) if body.fixed and body.shape.bounded]
    low, high = seen.points.min(axis=0), seen.points.max(axis=0)
    room = max(float((high - low).max()), ROOM * seen.typical)
    ahead = frames.positions[0, seen.moving] + AHEAD * frames.velocities[0, seen.moving] * (1.0, 1.0, 0.0)
    more = [ahead, *(world_corners(frames, n, 0) for n in fixed)]
    return replace(seen, points=np.concatenate([seen.points, *(np.clip(p, low - room, high + room) for p in more)]))


# --- the port ---------------------------------------------------------------------------------------------------------


def free_port(host: str, port: int) -> int:
    """The port if it is free at that address, or else another one.

    Raises:
        InvalidInputError: the host is no address of this machine, or the port no number from 0 to 65535.
    """
    port = checks.integer("port", port, minimum=0)
    if port > 65535:
        raise InvalidInputError(f"port must be 65535 or less, got {port!r}.")
    if not isinstance(host, str) or not host:
        raise InvalidInputError(f"host must be an address of this machine such as 127.0.0.1, got {host!r}.")
    for wanted in dict.fromkeys((port, 0)):
        try:
            family = socket.getaddrinfo(host, wanted, type=socket.SOCK_STREAM)[0][0]
            with socket.socket(family) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind((host, wanted))
                return int(probe.getsockname()[1])
        except (OSError, UnicodeError):
            continue
    raise InvalidInputError(f"host must be an address of this machine such as 127.0.0.1, got {host!r}.")


def _serve(host: str, port: int) -> ViserServer:
    import viser

    # a client whose messages make no sense is thrown out by an exception in its own task; its traceback helps nobody
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL)
    with quiet():
        server = viser.ViserServer(host=host, port=port, label="stiction", verbose=False)
    # any page in the browser could ask for a tunnel to the internet; a view of this machine opens none
    server.request_share_url = lambda *_, **__: None  # type: ignore[method-assign]  # on purpose, for this one server
    return server

"""The panel beside the picture: buttons, sliders, what is shown, and the charts. It only posts to the mailbox."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.motion import Motion
from stiction.view import style
from stiction.view.mailbox import Mailbox
from stiction.view.overlays import LAYERS, Overlays
from stiction.view.playback import Playback
from stiction.view.session import SPEEDS, LiveSession, Session
from stiction.world import SOLVERS

if TYPE_CHECKING:
    from viser import ViserServer

MOST_PAIRS = 16
"""Pairs of materials that get a slider, the first that touch."""
MOST_COEFFICIENT = 1.5
MOST_GRAVITY = 20.0
MOST_SUBSTEPS = 32
CHART_HEIGHT = 125
PLAY, STEP, RESET = "play / pause", "step", "reset"


class Panel:
    """Everything that the reader sets and reads beside the picture.

    Args:
        server: viser's.
        session: what is shown.
        overlays: the layers over the bodies.
        mail: where actions go.
        again: called after a reset or a jump in time.
    """

    def __init__(
        self, server: ViserServer, session: Session, overlays: Overlays, mail: Mailbox, again: Callable[[], None]
    ) -> None:
        self._gui = server.gui
        self._session = session
        self._overlays = overlays
        self._mail = mail
        self._again = again
        self._pairs: list[tuple[str, str]] = []
        self._materials: Any = None
        self._presses = 0
        self._top = 0.0
        self._gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        # docked, it leaves the whole of a smaller picture free
        self._gui.main_panel.dock_right()
        self._status = self._gui.add_html("")
        self._time: Any = None
        self._add_buttons()
        self._add_charts()
        if isinstance(session, LiveSession):
            self._add_world(session)
        with self._gui.add_folder("Show", expand_by_default=False):
            for name, label in LAYERS.items():
                box = self._gui.add_checkbox(label, name in overlays.shown)
                self._on(box, f"show {name}", self._switch(name))

    # --- parts --------------------------------------------------------------------------------------------------------

    def _add_buttons(self) -> None:
        session = self._session
        buttons = self._gui.add_button_group(" ", (PLAY, STEP, RESET))

        @buttons.on_click
        def _(event: Any) -> None:
            # presses are counted: two of them before the next frame are two steps
            self._presses += 1
            self._mail.put(f"button {self._presses}", lambda value=event.target.value: self._press(value))  # type: ignore[misc]  # the default binds the value of now

        speeds = sorted({*SPEEDS, session.speed})
        initial = f"{session.speed:g} x"
        speed = self._gui.add_dropdown("speed", [f"{s:g} x" for s in speeds], initial_value=initial)
        self._on(speed, "speed", lambda value: setattr(session, "speed", float(value.split()[0])))
        if isinstance(session, Playback):
            self._time = self._gui.add_slider(
                "time [s]", session.begin, max(session.end, session.begin + 1e-6), 1e-3, session.begin
            )
            self._on(self._time, "time", self._seek)

    def _press(self, button: str) -> None:
        session = self._session
        if button == PLAY:
            if session.playing:
                session.playing = False
            elif isinstance(session, Playback):
                if session.time >= session.end:
                    self._again()
                session.play()
            else:
                session.playing = True
        elif button == STEP:
            session.step()
        else:
            session.reset()
            self._again()

    def _seek(self, value: float) -> None:
        session = self._session
        if isinstance(session, Playback):
            session.playing = False
            if value < session.time:
                self._again()
            session.seek(value)

    def _switch(self, name: str) -> Callable[[Any], None]:
        def switch(wanted: bool) -> None:
            if wanted:
                self._overlays.shown.add(name)
            else:
                self._overlays.shown.discard(name)

        return switch

    def _add_world(self, session: LiveSession) -> None:
        with self._gui.add_folder("World"):
            magnitude, tilt, azimuth = session.gravity
            g = self._gui.add_slider("gravity [m/s²]", 0.0, max(MOST_GRAVITY, magnitude), 0.01, round(magnitude, 2))
            t = self._gui.add_slider("tilt [°]", 0.0, 90.0, 0.1, round(min(math.degrees(tilt), 90.0), 1))
            a = self._gui.add_slider("towards [°]", -180.0, 180.0, 1.0, round(math.degrees(azimuth)) + 0.0)

            def turn(_: Any) -> None:
                session.set_gravity(g.value, math.radians(t.value), math.radians(a.value))

            for handle in (g, t, a):
                self._on(handle, "gravity", turn)
            solver: Any = self._gui.add_dropdown("solver", SOLVERS, initial_value=session.world.solver)
            substeps: Any = self._gui.add_slider(
                "substeps", 1, MOST_SUBSTEPS, 1, min(session.world.substeps, MOST_SUBSTEPS)
            )

            def choose(value: Any) -> None:
                try:
                    session.set_solver(value)
                finally:
                    solver.value = session.world.solver
                    substeps.value = min(session.world.substeps, MOST_SUBSTEPS)

            def divide(value: Any) -> None:
                try:
                    session.set_solver(session.world.solver, int(value))
                finally:
                    substeps.value = min(session.world.substeps, MOST_SUBSTEPS)

            self._on(solver, "solver", choose)
            self._on(substeps, "substeps", divide)
        self._materials = self._gui.add_folder("Friction: dynamic and static")

    def _add_pairs(self, session: LiveSession) -> None:
        """A slider with two thumbs for every pair of materials that has touched: dynamic and static coefficient."""
        for pair in session.pairs[len(self._pairs) : MOST_PAIRS]:
            self._pairs.append(pair)
            properties = session.world.materials.pair(*pair)
            most = max(MOST_COEFFICIENT, properties.static)
            with self._materials:
                thumbs = self._gui.add_multi_slider(
                    f"{pair[0]} on {pair[1]}",
                    0.0,
                    most,
                    0.01,
                    (min(properties.dynamic, properties.static), properties.static),
                    hint="left: dynamic coefficient, right: static coefficient",
                )

            def set_pair(value: Any, pair: tuple[str, str] = pair) -> None:
                session.set_pair(*pair, dynamic=float(value[0]), static=float(value[1]))

            self._on(thumbs, f"pair {pair}", set_pair)

    def _add_charts(self) -> None:
        x = np.array([0.0, 1.0])
        axes = {"scale": "x", "label": "time [s]", "size": 40, "labelSize": 16}
        with self._gui.add_folder("Charts"):
            self._energy = self._gui.add_uplot(
                (x, x, x, x),
                (
                    {"label": "t"},
                    _line("kinetic", style.SERIES[0]),
                    _line("potential", style.SERIES[3]),
                    _line("dissipated", style.SERIES[1]),
                ),
                scales={"x": {"time": False}},
                axes=(axes, {"label": "energy [J]", "size": 68, "labelSize": 16}),  # type: ignore[arg-type]  # TypedDicts as plain ones
                legend={"live": False},
                height=CHART_HEIGHT + 30,
                padding=(10, 16, 0, 0),
                visible=False,
            )
            self._force = self._gui.add_uplot(
                (x, x),
                ({"label": "t"}, _line("friction", style.FRICTION)),
                scales={"x": {"time": False}},
                axes=(axes, {"label": "friction [N]", "size": 68, "labelSize": 16}),  # type: ignore[arg-type]  # see above
                legend={"show": False},
                height=CHART_HEIGHT,
                padding=(10, 16, 0, 0),
                visible=False,
            )

    # --- what changes -------------------------------------------------------------------------------------------------

    def refresh(self, time: float, contacts: int, note: str) -> None:
        """Bring status, time and charts to now; called a few times a second."""
        session = self._session
        if isinstance(session, LiveSession):
            self._add_pairs(session)
        elif isinstance(session, Playback) and self._time is not None:
            self._time.value = session.time
        state = "playing" if session.playing else "paused"
        words = [f"t = {time:.3f} s, {state}", f"{len(session.bodies)} bodies, {contacts} contact points"]
        if session.picked is not None:
            words.append(f"picked: {session.bodies[session.picked].name}")
        if note:
            words.append(note)
        text = "<br>".join(html.escape(word) for word in words)
        if session.trouble:
            text += f'<br><b style="color:#c92a2a">{html.escape(session.trouble)}</b>'
        self._status.content = (
            f"<style>{style.NO_NOTE}</style>"
            f'<div style="font:13px/1.45 {style.FONT_STACK};padding:2px 14px 0;overflow-wrap:anywhere">'
            f"<b>{html.escape(session.title)}</b><br>{_legend(session)}<br>{text}</div>"
        )
        if len(session.chart) > 1:
            t, kinetic, potential, dissipated, friction = np.array(session.chart).T
            # potential energy counts from the beginning of the chart: only its changes mean something
            self._energy.data = tuple(
                np.nan_to_num(column) for column in (t, kinetic, potential - potential[0], dissipated - dissipated[0])
            )
            # from zero: the chart must not blow rounding up to a zigzag
            top = _above(float(friction.max()))
            if top != self._top:
                self._top = top
                self._force.scales = {"x": {"time": False}, "y": {"range": (0.0, top)}}
            self._force.data = (t, friction)
            self._energy.visible = self._force.visible = True

    def _on(self, handle: Any, key: str, action: Callable[[Any], None]) -> None:
        """Post an action with the value that a reader has set."""

        @handle.on_update  # type: ignore[untyped-decorator]  # handles of all kinds have it
        def _(event: Any) -> None:
            if event.client is not None:  # and not this program itself
                value = event.target.value
                self._mail.put(key, lambda: action(value))


def _line(label: str, color: str) -> Any:
    return {"label": label, "stroke": color, "width": 2, "points": {"show": False}}


def _legend(session: Session) -> str:
    """What the colours of bodies mean."""
    colors = {motion.word: style.MOTION_COLORS[motion] for motion in Motion if motion is not Motion.FIXED}
    if session.live:
        colors["asleep"] = style.ASLEEP
    chip = '<span style="white-space:nowrap;margin-right:9px"><span style="color:{}">&#9632;</span> {}</span>'
    return " ".join(chip.format(color, word) for word, color in colors.items())


def _above(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten above a value that is not negative."""
    if not value > 0.0:
        return 1.0
    power = float(10.0 ** math.floor(math.log10(value)))
    return next(top for top in (power, 2 * power, 5 * power, 10 * power) if top > value)

"""A run as one page of HTML that plays offline: everything the browser needs is inside the file.

The page is viser's own player with a recording in it; title and legend are plain HTML over the picture.
"""

from __future__ import annotations

import html
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiction import checks, outputs
from stiction.errors import InvalidInputError
from stiction.motion import Motion
from stiction.record.frames import Frames
from stiction.view import style

MOST_FPS = 30.0
"""Pictures per second unless the caller asks for more."""


def write_html(
    frames: Frames,
    path: str | Path,
    *,
    fps: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Writes a page that plays a run in any browser, offline and in real time.

    Bodies are coloured by what they are doing, contact points and normals are shown, and the reader can turn, zoom,
    pause and step.

    Args:
        frames: the run.
        path: of the page; its folder must exist.
        fps: pictures per second at most; by default as many as ``frames`` has, up to 30.
        progress: called with the finished share, from 0 to 1.

    Returns:
        The path of the page.

    Raises:
        InvalidInputError: ``frames`` is empty or ``fps`` is not above 0.
        OutputError: the page cannot be written; found out before any work.
    """
    limit = _limit(frames, fps)
    target = outputs.writable("path", path)
    tell = progress if progress is not None else _ignore
    tell(0.0)
    page = page_of(frames, fps=limit, progress=lambda share: tell(0.95 * share))
    try:
        target.write_text(page, encoding="utf-8")
    except OSError as error:
        raise outputs.not_writable("path", target, error) from error
    tell(1.0)
    return target


def page_of(frames: Frames, *, fps: float | None = None, progress: Callable[[float], None] | None = None) -> str:
    """The page that :func:`write_html` writes, as a text.

    Raises:
        InvalidInputError: ``frames`` is empty or ``fps`` is not above 0.
    """
    limit = _limit(frames, fps)
    from stiction.view import recording
    from stiction.view.survey import survey

    seen = survey(frames)
    picked = pick_frames(frames.times, limit)
    page = recording.record(frames, picked, seen, progress if progress is not None else _ignore)
    return _with_overlay(page, frames, seen.cell)


def _limit(frames: Frames, fps: float | None) -> float:
    """Pictures per second at most, of frames that can be shown."""
    limit = MOST_FPS if fps is None else checks.positive("fps", fps, "1/s")
    if not len(frames):
        raise InvalidInputError("frames must hold at least one frame, got 0.")
    return limit


def pick_frames(times: NDArray[np.float64], fps: float) -> NDArray[np.int64]:
    """Numbers of the frames to show: all, or as many as ``fps`` allows, evenly spaced in time; the last one always.

    Args:
        times: (f,) in s, ascending.
        fps: frames per second at most.
    """
    # a thousandth of slack, so that 60 Hz thinned to 30 Hz takes every second frame in spite of rounding
    slots = np.floor((times - times[0]) * fps + 1e-3)
    first_of_slot = np.flatnonzero(np.diff(slots, prepend=-1.0) > 0)
    return np.union1d(first_of_slot, [len(times) - 1])


def _ignore(share: float) -> None:
    """No one wants to know."""


# --- title and legend -------------------------------------------------------------------------------------------------

_STYLE = f"""
<style>
  body {{ display: flex; flex-direction: column; }}
  #root {{ flex: 1; min-height: 0; }}
  canvas[data-engine] {{ background: linear-gradient({style.SKY_TOP}, {style.SKY_BOTTOM}); }}
  {style.NO_NOTE}
  #stiction {{
    flex: none; display: flex; flex-wrap: wrap; align-items: baseline; gap: 4px 32px; padding: 10px 18px;
    font: 14px/1.5 {style.FONT_STACK}; color: {style.INK}; background: {style.PAPER};
    border-bottom: 1px solid #e9ecef;
  }}
  #stiction h1 {{ margin: 0; font-size: 18px; line-height: 1.3; font-weight: 650; overflow-wrap: anywhere; }}
  #stiction ul {{ margin: 0; padding: 0; list-style: none; display: flex; flex-wrap: wrap; gap: 2px 18px; }}
  #stiction li {{ white-space: nowrap; }}
  #stiction i {{ display: inline-block; width: 12px; height: 12px; margin-right: 7px; border-radius: 3px; }}
  #stiction i.dot {{ width: 9px; height: 9px; border-radius: 50%; }}
  #stiction svg {{ width: 11px; height: 14px; margin-right: 6px; vertical-align: -2px; }}
  #stiction p {{ margin: 0 0 0 auto; font-size: 12.5px; color: {style.MUTED_INK}; }}
</style>
"""
_ARROW = f'<svg viewBox="0 0 11 14"><path d="M5.5 0 10 6.5H6.7V14H4.3V6.5H1z" fill="{style.NORMAL}"/></svg>'


def _with_overlay(page: str, frames: Frames, cell: float) -> str:
    """The page with its own title and background, and a strip with title and legend above the picture."""
    title = html.escape(frames.title)
    drawn = [n for n, body in enumerate(frames.bodies) if body.shape.bounded]
    occurs = set(np.unique(frames.motion[:, drawn]).tolist())
    items = [
        f'<li><i style="background:{style.MOTION_COLORS[motion]}"></i>{motion.word}</li>'
        for motion in Motion
        if motion in occurs
    ]
    if len(frames.contacts):
        colors = [style.MOTION_COLORS[motion] for motion in (Motion.STICKING, Motion.SLIDING)]
        halves = f"background:linear-gradient(90deg,{colors[0]} 50%,{colors[1]} 50%)"
        items += [f'<li><i class="dot" style="{halves}"></i>contact point</li>', f"<li>{_ARROW}normal</li>"]
    strip = f"""
<header id="stiction">
  <h1>{title}</h1>
  <ul>{"".join(items)}</ul>
  <p>grid {cell:g} m &middot; drag to turn, scroll to zoom, space to pause</p>
</header>
"""
    page = page.replace("<title>Viser</title>", f"<title>{title}</title>", 1)
    start = page.rindex('<div id="root">')
    return page[:start] + _STYLE + strip + page[start:]

"""Figures of a run: what friction did, as a teacher would draw it.

>>> import stiction as st
>>> from stiction import plot
>>> world = st.World()
>>> floor = world.add(st.Plane(), static=True)
>>> crate = world.add(st.Box((1, 1, 1)), position=(0, 0, 0.5), velocity=(1, 0, 0), name="crate")
>>> track = plot.observe(world, seconds=0.5, title="A crate stops")
>>> figure = plot.draw("energy", track)     # figure.savefig("energy.png"), or plot.save(figure, "energy.png")
"""

from __future__ import annotations

from stiction.plot.canvas import save
from stiction.plot.kinds import KINDS, Kind, draw
from stiction.plot.still import bodies, picture, project
from stiction.plot.track import Observer, Track, from_recording, observe

__all__ = [
    "KINDS",
    "Kind",
    "Observer",
    "Track",
    "bodies",
    "draw",
    "from_recording",
    "observe",
    "picture",
    "project",
    "save",
]

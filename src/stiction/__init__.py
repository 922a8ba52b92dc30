"""stiction: a rigid-body physics engine for Python in which friction is right."""

from __future__ import annotations

from stiction._version import __version__
from stiction.body import Body
from stiction.errors import (
    InvalidInputError,
    IterationLimitWarning,
    MaterialWarning,
    NotYetError,
    OutputError,
    SimulationError,
    StictionError,
    StictionWarning,
)
from stiction.events import ContactEvents, EventKind
from stiction.materials import MaterialTable, PairProperties
from stiction.motion import Motion
from stiction.queries import RayHit, RayHits
from stiction.reports import Energy, SolverReport
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Plane, Shape, Sphere
from stiction.world import World

__all__ = [
    "Body",
    "Box",
    "Capsule",
    "ContactEvents",
    "ConvexHull",
    "Cylinder",
    "Energy",
    "EventKind",
    "InvalidInputError",
    "IterationLimitWarning",
    "MaterialTable",
    "MaterialWarning",
    "Motion",
    "NotYetError",
    "OutputError",
    "PairProperties",
    "Plane",
    "RayHit",
    "RayHits",
    "Shape",
    "SimulationError",
    "SolverReport",
    "Sphere",
    "StictionError",
    "StictionWarning",
    "World",
    "__version__",
]

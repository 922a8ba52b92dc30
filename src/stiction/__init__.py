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
from stiction.materials import MaterialTable, PairProperties
from stiction.motion import Motion
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Plane, Shape, Sphere
from stiction.world import Energy, SolverReport, World

__all__ = [
    "Body",
    "Box",
    "Capsule",
    "ConvexHull",
    "Cylinder",
    "Energy",
    "InvalidInputError",
    "IterationLimitWarning",
    "MaterialTable",
    "MaterialWarning",
    "Motion",
    "NotYetError",
    "OutputError",
    "PairProperties",
    "Plane",
    "Shape",
    "SimulationError",
    "SolverReport",
    "Sphere",
    "StictionError",
    "StictionWarning",
    "World",
    "__version__",
]

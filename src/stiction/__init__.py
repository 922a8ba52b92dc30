"""stiction: a rigid-body physics engine for Python in which friction is right."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

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
from stiction.laws import BrushTyre, Coulomb, FrictionCurve, FrictionLaw, MagicFormula, Stribeck
from stiction.materials import MaterialTable
from stiction.motion import Motion
from stiction.pair_properties import PairProperties
from stiction.queries import RayHit, RayHits
from stiction.reports import Energy, SolverReport
from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Plane, Shape, Sphere
from stiction.vehicle import Vehicle
from stiction.wheels import VehicleWork, Wheel, WheelState, four_wheels
from stiction.world import World

if TYPE_CHECKING:
    from stiction.batch import Batch, BatchState
    from stiction.record.recording import Recording

__all__ = [
    "Batch",
    "BatchState",
    "Body",
    "Box",
    "BrushTyre",
    "Capsule",
    "ContactEvents",
    "ConvexHull",
    "Coulomb",
    "Cylinder",
    "Energy",
    "EventKind",
    "FrictionCurve",
    "FrictionLaw",
    "InvalidInputError",
    "IterationLimitWarning",
    "MagicFormula",
    "MaterialTable",
    "MaterialWarning",
    "Motion",
    "NotYetError",
    "OutputError",
    "PairProperties",
    "Plane",
    "RayHit",
    "RayHits",
    "Recording",
    "Shape",
    "SimulationError",
    "SolverReport",
    "Sphere",
    "StictionError",
    "StictionWarning",
    "Stribeck",
    "Vehicle",
    "VehicleWork",
    "Wheel",
    "WheelState",
    "World",
    "__version__",
    "four_wheels",
]


def __getattr__(name: str) -> Any:
    """Names whose packages are heavy, when they are first asked for."""
    if name in {"Batch", "BatchState"}:
        from stiction import batch

        return getattr(batch, name)
    if name == "Recording":
        from stiction.record.recording import Recording

        return Recording
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

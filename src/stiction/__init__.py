"""stiction: a rigid-body physics engine for Python in which friction is right."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stiction._version import __version__

if TYPE_CHECKING:
    from stiction.batch import Batch, BatchState
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
    from stiction.record.recording import Recording
    from stiction.reports import Energy, SolverReport
    from stiction.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere
    from stiction.vehicle import Vehicle
    from stiction.wheels import VehicleWork, Wheel, WheelState, four_wheels
    from stiction.world import World

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
    "Ellipsoid",
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


_NAMES = {
    "batch": ("Batch", "BatchState"),
    "body": ("Body",),
    "errors": (
        "InvalidInputError",
        "IterationLimitWarning",
        "MaterialWarning",
        "NotYetError",
        "OutputError",
        "SimulationError",
        "StictionError",
        "StictionWarning",
    ),
    "events": ("ContactEvents", "EventKind"),
    "laws": ("BrushTyre", "Coulomb", "FrictionCurve", "FrictionLaw", "MagicFormula", "Stribeck"),
    "materials": ("MaterialTable",),
    "motion": ("Motion",),
    "pair_properties": ("PairProperties",),
    "queries": ("RayHit", "RayHits"),
    "record.recording": ("Recording",),
    "reports": ("Energy", "SolverReport"),
    "shapes": ("Box", "Capsule", "ConvexHull", "Cylinder", "Ellipsoid", "Plane", "Shape", "Sphere"),
    "vehicle": ("Vehicle",),
    "wheels": ("VehicleWork", "Wheel", "WheelState", "four_wheels"),
    "world": ("World",),
}
"""What the imports for type checkers above say, for the interpreter: the module of each name."""
_MODULES = {name: module for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """A public name, when it is first asked for: modules are loaded by who uses them (PEP 562)."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value  # found without this function from now on
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

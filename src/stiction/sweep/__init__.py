"""Sweeps: many runs of a scene, here or on Ray, as one table.

>>> from stiction.sweep import load
>>> sweep = load("slip-tip-hold")
>>> len(sweep.points), sweep.points[0].values
(441, {'mu': 0.04, 'angle_deg': 1.0})
"""

from __future__ import annotations

from stiction.sweep.backends import check as check_backend
from stiction.sweep.backends import make as make_backend
from stiction.sweep.driver import Outcome, Progress, SweepError, run_sweep
from stiction.sweep.load import Sweep, builtin_names, builtin_text, from_dict, load
from stiction.sweep.plan import SweepPlan, make_plan

__all__ = [
    "Outcome",
    "Progress",
    "Sweep",
    "SweepError",
    "SweepPlan",
    "builtin_names",
    "builtin_text",
    "check_backend",
    "from_dict",
    "load",
    "make_backend",
    "make_plan",
    "run_sweep",
]

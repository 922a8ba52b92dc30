"""Coefficients from measured motion: ``stiction fit``, and the same as functions.

>>> from stiction.fit import Problem, fit, parse_all, read_csv
>>> from stiction.scene import load
>>> scene = load("pull", ["pushes[0].until=4", "duration=6"])           # doctest: +SKIP
>>> open_ = parse_all(["materials.pairs.wood-concrete.static"], scene.table)      # doctest: +SKIP
>>> fit(Problem(scene, read_csv("pull.csv"), open_))                      # doctest: +SKIP
"""

from stiction.fit.data import COLUMNS, Track, read_csv
from stiction.fit.parameters import RANGES, Parameter, parse, parse_all
from stiction.fit.problem import Motion, Problem
from stiction.fit.search import LOSSES, State
from stiction.fit.solve import Estimate, Fit, fit

__all__ = [
    "COLUMNS",
    "LOSSES",
    "RANGES",
    "Estimate",
    "Fit",
    "Motion",
    "Parameter",
    "Problem",
    "State",
    "Track",
    "fit",
    "parse",
    "parse_all",
    "read_csv",
]

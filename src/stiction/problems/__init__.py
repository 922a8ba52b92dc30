"""One contact problem on its own: read it, write it, solve it, and say how far off a solution is.

>>> from stiction.problems import ContactProblem, solve
>>> problem = ContactProblem([[2.0, 0, 0], [0, 1, 0], [0, 0, 1]], q=[-1.0, 2.0, 0.0], mu=0.5)
>>> solution = solve(problem)
>>> solution.r.round(6).tolist(), solution.converged
([[0.5, -0.25, -0.0]], True)
"""

from __future__ import annotations

from stiction.problems.blocks import BlockMatrix
from stiction.problems.problem import ContactPlaces, ContactProblem, GlobalForm
from stiction.problems.residuals import Residuals, natural_map, residuals
from stiction.problems.solve import Solution, solve

__all__ = [
    "BlockMatrix",
    "ContactPlaces",
    "ContactProblem",
    "GlobalForm",
    "Residuals",
    "Solution",
    "natural_map",
    "residuals",
    "solve",
]

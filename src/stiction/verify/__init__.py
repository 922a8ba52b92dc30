"""Verification: closed forms, measured in worlds of their own.

>>> from stiction import verify
>>> rows = verify.run(["slide-to-roll"])
>>> verify.summarise(rows)
Summary(passed=4, failed=0, known_limits=0, surprises=0)
"""

from __future__ import annotations

from stiction.verify.case import Case, Measurement, Result
from stiction.verify.registry import Summary, all_cases, run, summarise

__all__ = ["Case", "Measurement", "Result", "Summary", "all_cases", "run", "summarise"]

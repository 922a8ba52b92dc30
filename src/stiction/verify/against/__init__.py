"""The same questions to other engines: scenes with closed forms in stiction and in its peers, side by side.

>>> from stiction.verify.against import compare
>>> found = compare([], ["slide-to-roll"], isolated=False)
>>> found.score("slide-to-roll", "stiction").passed
True
"""

from __future__ import annotations

from stiction.verify.against.columns import COLUMNS, OWN, PEERS, Column
from stiction.verify.against.comparison import Comparison, all_trials, compare
from stiction.verify.against.trial import Reading, Score, Track, Trial

__all__ = [
    "COLUMNS",
    "OWN",
    "PEERS",
    "Column",
    "Comparison",
    "Reading",
    "Score",
    "Track",
    "Trial",
    "all_trials",
    "compare",
]

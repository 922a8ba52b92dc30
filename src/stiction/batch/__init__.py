"""Many worlds that are alike, stepped together by one compiled call over all cores."""

from __future__ import annotations

from stiction.batch.batch import Batch
from stiction.batch.state import BatchState

__all__ = ["Batch", "BatchState"]

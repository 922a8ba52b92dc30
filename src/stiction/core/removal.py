"""Taking bodies out of the tree; all else that a removal asks for is renumbering, which numpy does."""

from __future__ import annotations

from stiction.core.jit import entry
from stiction.core.tree import remove


@entry
def drop_leaves(tree, gone):
    """Take the leaves of the bodies that ``gone`` lists out of the tree."""
    for i in gone:
        remove(tree, i)

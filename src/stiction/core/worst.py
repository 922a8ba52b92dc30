"""A tournament tree: which of m contacts is the worst, after any of them has changed, in log m.

The root is row 1, node k's children are 2k and 2k+1, the leaves start at ``leaves``. Ties go to the lower index, so the
order of resolution is the same on every run.
"""

from __future__ import annotations

from stiction.core.jit import jit


@jit
def leaves_for(m):
    """Number of leaves: the power of two that holds m."""
    leaves = 1
    while leaves < m:
        leaves *= 2
    return leaves


@jit
def build(tree, leaves):
    """Fill the inner nodes from the leaves."""
    for node in range(leaves - 1, 0, -1):
        tree[node] = max(tree[2 * node], tree[2 * node + 1])


@jit
def worst(tree, leaves):
    """Index of the largest leaf."""
    node = 1
    while node < leaves:
        node *= 2
        if tree[node] < tree[node + 1]:
            node += 1
    return node - leaves


@jit
def update(tree, leaves, index, value):
    """Set one leaf and everything above it that changes."""
    node = leaves + index
    tree[node] = value
    node //= 2
    while node >= 1:
        top = max(tree[2 * node], tree[2 * node + 1])
        if tree[node] == top:
            break
        tree[node] = top
        node //= 2

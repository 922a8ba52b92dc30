"""A dynamic tree of boxes: which bodies may be near a box, in time that grows with the logarithm of their number.

A leaf holds one body's box, every other node the box around its two children. A new leaf goes where it adds the least
surface area (the chance that a random box hits a node grows with the node's area; Goldsmith and Salmon, 1987), found by
greedy descent with a lower bound, and on the way back to the root nodes are swapped with nieces while that makes a box
smaller (Kensler, 2008; Catto, "Dynamic bounding volume hierarchies", 2019). Boxes of leaves are meant to be fat, so
that a body which moves a little stays in its leaf.

Which bodies a query finds depends on the leaves' boxes alone; the order in which it finds them depends on the history.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stiction.core.jit import jit
from stiction.core.memory import refilled, zeros

NONE = -1
"""No node, no body."""

PARENT, LEFT, RIGHT, HEIGHT, LINKS_WIDTH = range(5)
"""Columns of a tree's links. A leaf has LEFT = NONE, RIGHT = its body and HEIGHT = 0; a node on the free list keeps the
next one in PARENT."""

ROOT, FREE, USED, LEAVES, MOVES, HEAD_WIDTH = range(6)
"""Entries of a tree's head: its root, the first free node, how many nodes were ever handed out, how many leaves, how
often one moved."""

REINSERT = 8
"""Every so many moves a leaf is inserted anew even if its place is good, so that subtrees which travel together do not
keep the place where they set out."""


class Tree(NamedTuple):
    """A tree with room for n bodies."""

    boxes: np.ndarray  # (nodes, 6) float64 lower corner, upper corner, m
    links: np.ndarray  # (nodes, LINKS_WIDTH) int64
    leaf: np.ndarray  # (n,) int64 leaf of a body, or NONE
    head: np.ndarray  # (HEAD_WIDTH,) int64


def make_tree(n: int, nodes: int | None = None) -> Tree:
    """An empty tree with room for n bodies; ``nodes``: for 2 n if left out, and one less than twice the leaves do."""
    nodes = 2 * n if nodes is None else nodes
    return Tree(
        boxes=zeros((nodes, 6)),
        links=np.full((nodes, LINKS_WIDTH), NONE, np.int64),
        leaf=np.full(n, NONE, np.int64),
        head=np.array([NONE, NONE, 0, 0, 0], np.int64),
    )


def grow_tree(tree: Tree, n: int) -> Tree:
    """The same tree with room for n bodies, in new arrays."""
    larger: Tree = refilled(make_tree(n), tree)
    return larger


# --- boxes ------------------------------------------------------------------------------------------------------------


@jit
def half_area(lx, ly, lz, hx, hy, hz):
    """Half the surface of a box, m^2."""
    x, y, z = hx - lx, hy - ly, hz - lz
    return x * y + y * z + z * x


@jit
def node_area(boxes, i):
    """Half the surface of a node's box."""
    return half_area(boxes[i, 0], boxes[i, 1], boxes[i, 2], boxes[i, 3], boxes[i, 4], boxes[i, 5])


@jit
def joint_area(boxes, i, j):
    """Half the surface of the box around two nodes."""
    return half_area(
        min(boxes[i, 0], boxes[j, 0]), min(boxes[i, 1], boxes[j, 1]), min(boxes[i, 2], boxes[j, 2]),
        max(boxes[i, 3], boxes[j, 3]), max(boxes[i, 4], boxes[j, 4]), max(boxes[i, 5], boxes[j, 5]),
    )  # fmt: skip


@jit
def nodes_overlap(boxes, i, j):
    """Whether the boxes of two nodes have a point in common."""
    return (
        boxes[i, 0] <= boxes[j, 3] and boxes[j, 0] <= boxes[i, 3]
        and boxes[i, 1] <= boxes[j, 4] and boxes[j, 1] <= boxes[i, 4]
        and boxes[i, 2] <= boxes[j, 5] and boxes[j, 2] <= boxes[i, 5]
    )  # fmt: skip


@jit
def _enclose(boxes, links, i):
    """Box and height of node i from its children; False if they were right already."""
    a, b = links[i, LEFT], links[i, RIGHT]
    changed = False
    for k in range(3):
        low, high = min(boxes[a, k], boxes[b, k]), max(boxes[a, k + 3], boxes[b, k + 3])
        if low != boxes[i, k] or high != boxes[i, k + 3]:
            changed = True
        boxes[i, k], boxes[i, k + 3] = low, high
    height = 1 + max(links[a, HEIGHT], links[b, HEIGHT])
    if height != links[i, HEIGHT]:
        links[i, HEIGHT] = height
        changed = True
    return changed


# --- nodes ------------------------------------------------------------------------------------------------------------


@jit
def _take_node(links, head):
    node = head[FREE]
    if node == NONE:
        node = head[USED]
        head[USED] = node + 1
    else:
        head[FREE] = links[node, PARENT]
    return node


@jit
def _give_node(links, head, node):
    links[node, PARENT] = head[FREE]
    head[FREE] = node


@jit
def _replace_child(links, head, parent, old, new):
    """Put a node where another one was below ``parent``, which may be NONE: then it becomes the root."""
    if parent == NONE:
        head[ROOT] = new
    elif links[parent, LEFT] == old:
        links[parent, LEFT] = new
    else:
        links[parent, RIGHT] = new
    links[new, PARENT] = parent


@jit
def _rotate(boxes, links, head, i):
    """Swap a child of node i with the child of its sibling that makes the sibling's box smallest, if that helps."""
    best, swap_up, swap_down, swap_at = 0.0, 0, 0, 0
    for side in range(2):
        child, sibling = links[i, LEFT + side], links[i, RIGHT - side]
        if links[sibling, LEFT] == NONE:
            continue
        area = node_area(boxes, sibling)
        for k in range(2):
            gain = area - joint_area(boxes, child, links[sibling, RIGHT - k])
            if gain > best:
                best, swap_up, swap_down, swap_at = gain, links[sibling, LEFT + k], child, sibling
    if best > 0.0:
        _replace_child(links, head, i, swap_down, swap_up)
        _replace_child(links, head, swap_at, swap_up, swap_down)
        _enclose(boxes, links, swap_at)
        links[i, HEIGHT] = 1 + max(links[swap_up, HEIGHT], links[swap_at, HEIGHT])


@jit
def _distance(boxes, i, j):
    """Distance between the centres of two nodes, a measure for comparisons only."""
    d = 0.0
    for k in range(3):
        d += abs(boxes[i, k] + boxes[i, k + 3] - boxes[j, k] - boxes[j, k + 3])
    return d


@jit
def _best_sibling(boxes, links, head, leaf):
    """The node beside which a leaf adds the least area: its new parent's own, and what every ancestor grows by.

    Greedy: of two children the one whose subtree may be cheaper is entered, and none if neither can beat the best so
    far. ``grown`` is what the ancestors of ``node`` grow by, ``joint`` the area of ``node`` with the leaf.
    """
    own = node_area(boxes, leaf)
    node = head[ROOT]
    joint, grown = joint_area(boxes, node, leaf), 0.0
    best, best_cost = node, joint
    while links[node, LEFT] != NONE:
        grown += joint - node_area(boxes, node)
        a, b = links[node, LEFT], links[node, RIGHT]
        joint_a, joint_b = joint_area(boxes, a, leaf), joint_area(boxes, b, leaf)
        if joint_a + grown < best_cost:
            best, best_cost = a, joint_a + grown
        if joint_b + grown < best_cost:
            best, best_cost = b, joint_b + grown
        # below a child, the new parent's own area is at least the leaf's
        bound_a = grown + joint_a - node_area(boxes, a) + own
        bound_b = grown + joint_b - node_area(boxes, b) + own
        enter_a = links[a, LEFT] != NONE and bound_a < best_cost
        enter_b = links[b, LEFT] != NONE and bound_b < best_cost
        if enter_a and enter_b:
            # equal if both hold the leaf already: without the second criterion the tree decays as its leaves move
            enter_a = bound_a < bound_b or (
                bound_a == bound_b and _distance(boxes, a, leaf) < _distance(boxes, b, leaf)
            )
        if enter_a:
            node, joint = a, joint_a
        elif enter_b:
            node, joint = b, joint_b
        else:
            break
    return best


# --- what the world does with a tree ----------------------------------------------------------------------------------


@jit
def insert(tree, body, lx, ly, lz, hx, hy, hz):
    """Add a leaf for a body that has none, with the box given by its lower and upper corner."""
    boxes, links, head = tree.boxes, tree.links, tree.head
    leaf = _take_node(links, head)
    boxes[leaf, 0], boxes[leaf, 1], boxes[leaf, 2] = lx, ly, lz
    boxes[leaf, 3], boxes[leaf, 4], boxes[leaf, 5] = hx, hy, hz
    links[leaf, PARENT], links[leaf, LEFT], links[leaf, RIGHT], links[leaf, HEIGHT] = NONE, NONE, body, 0
    tree.leaf[body] = leaf
    head[LEAVES] += 1
    if head[ROOT] == NONE:
        head[ROOT] = leaf
        return

    sibling = _best_sibling(boxes, links, head, leaf)
    node = _take_node(links, head)
    _replace_child(links, head, links[sibling, PARENT], sibling, node)
    links[node, LEFT], links[node, RIGHT] = sibling, leaf
    links[sibling, PARENT] = links[leaf, PARENT] = node
    while node != NONE:
        _enclose(boxes, links, node)
        _rotate(boxes, links, head, node)
        node = links[node, PARENT]


@jit
def remove(tree, body):
    """Take a body's leaf out; nothing happens if it has none."""
    boxes, links, head = tree.boxes, tree.links, tree.head
    leaf = tree.leaf[body]
    if leaf == NONE:
        return
    tree.leaf[body] = NONE
    head[LEAVES] -= 1
    parent = links[leaf, PARENT]
    _give_node(links, head, leaf)
    if parent == NONE:
        head[ROOT] = NONE
        return
    sibling = links[parent, RIGHT] if links[parent, LEFT] == leaf else links[parent, LEFT]
    node = links[parent, PARENT]
    _replace_child(links, head, node, parent, sibling)
    _give_node(links, head, parent)
    while node != NONE and _enclose(boxes, links, node):
        node = links[node, PARENT]


@jit
def move(tree, body, lx, ly, lz, hx, hy, hz):
    """Give a body another box, whether it has a leaf or not.

    While the box around it and its sibling is no larger than the two together, the leaf stays where it is, and only the
    boxes above it change: a third of the cost of a new place, in a tree that is up to a half slower to query.
    """
    boxes, links, head = tree.boxes, tree.links, tree.head
    leaf = tree.leaf[body]
    head[MOVES] += 1
    if leaf != NONE and links[leaf, PARENT] != NONE and head[MOVES] % REINSERT != 0:
        node = links[leaf, PARENT]
        sibling = links[node, RIGHT] if links[node, LEFT] == leaf else links[node, LEFT]
        joint = half_area(
            min(lx, boxes[sibling, 0]), min(ly, boxes[sibling, 1]), min(lz, boxes[sibling, 2]),
            max(hx, boxes[sibling, 3]), max(hy, boxes[sibling, 4]), max(hz, boxes[sibling, 5]),
        )  # fmt: skip
        if joint <= half_area(lx, ly, lz, hx, hy, hz) + node_area(boxes, sibling):
            boxes[leaf, 0], boxes[leaf, 1], boxes[leaf, 2] = lx, ly, lz
            boxes[leaf, 3], boxes[leaf, 4], boxes[leaf, 5] = hx, hy, hz
            while node != NONE and _enclose(boxes, links, node):
                node = links[node, PARENT]
            return
    remove(tree, body)
    insert(tree, body, lx, ly, lz, hx, hy, hz)


@jit
def query(tree, lx, ly, lz, hx, hy, hz, stack, out):
    """Bodies whose leaf boxes overlap a box; returns their number, which may exceed the room of ``out``.

    ``stack`` is scratch with room for as many nodes as there are leaves: the nodes on it have no leaf in common.
    """
    boxes, links = tree.boxes, tree.links
    room, found, top = out.shape[0], 0, 0
    if tree.head[ROOT] != NONE:
        stack[0] = tree.head[ROOT]
        top = 1
    while top > 0:
        top -= 1
        i = stack[top]
        if (
            lx > boxes[i, 3] or boxes[i, 0] > hx
            or ly > boxes[i, 4] or boxes[i, 1] > hy
            or lz > boxes[i, 5] or boxes[i, 2] > hz
        ):  # fmt: skip
            continue
        if links[i, LEFT] == NONE:
            if found < room:
                out[found] = links[i, RIGHT]
            found += 1
        else:
            stack[top], stack[top + 1] = links[i, LEFT], links[i, RIGHT]
            top += 2
    return found


def check(tree: Tree) -> bool:
    """Whether links, boxes, heights, leaves and free nodes are as they should be; for tests."""
    boxes, links, leaf, head = tree
    bodies, reached = [], 0
    below = [] if head[ROOT] == NONE else [(int(head[ROOT]), NONE)]
    while below:
        i, parent = below.pop()
        reached += 1
        if links[i, PARENT] != parent:
            return False
        if links[i, LEFT] == NONE:
            bodies.append(int(links[i, RIGHT]))
            if leaf[links[i, RIGHT]] != i or links[i, HEIGHT] != 0:
                return False
            continue
        a, b = int(links[i, LEFT]), int(links[i, RIGHT])
        low, high = np.minimum(boxes[a, :3], boxes[b, :3]), np.maximum(boxes[a, 3:], boxes[b, 3:])
        if (boxes[i, :3] != low).any() or (boxes[i, 3:] != high).any():
            return False
        if links[i, HEIGHT] != 1 + max(links[a, HEIGHT], links[b, HEIGHT]):
            return False
        below += [(a, i), (b, i)]
    free, node = 0, int(head[FREE])
    while node != NONE:
        free, node = free + 1, int(links[node, PARENT])
    return (
        sorted(bodies) == [int(body) for body in np.flatnonzero(leaf != NONE)]
        and len(bodies) == head[LEAVES]
        and reached + free == head[USED]
    )

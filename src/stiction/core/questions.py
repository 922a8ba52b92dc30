"""The questions that a world asks of its tree, as entries: none of them is compiled before it is asked."""

from __future__ import annotations

from stiction.core.broadphase import bound_body
from stiction.core.jit import entry
from stiction.core.overlaps import bodies_overlap
from stiction.core.pairs import FOUND, candidates, find_moved, may_meet, touch_body
from stiction.core.query import cast_ray, overlap_box, overlap_sphere
from stiction.core.state import PLANE, SHAPE
from stiction.core.tree import NONE
from stiction.core.vec import vec3


@entry
def refresh_tree(tree, cache, bodies, kinds, n, known, order, g, dt):
    """Bring the tree up to date with where n bodies are now, of which those from ``known`` on are new to it.

    This gives each body the fat box that the next step would give it, so asking changes nothing of what comes.
    ``order`` is scratch, (n,) int64; ``g`` the strength of gravity, m/s^2.
    """
    for i in range(n):
        bound_body(bodies, kinds, i, g, dt)
        order[i] = i
    for i in range(known, n):
        touch_body(cache, i)
    find_moved(tree, cache, bodies, kinds, order, n, dt)


@entry
def cast_rays(tree, cache, bodies, kinds, hulls, origins, directions, reach, mask, hits, found, counts):
    """Hits of k rays, origins and unit directions (k, 3), nearest first: ``hits`` (k, room, HIT_WIDTH), the bodies
    ``found`` (k, room), and how many there are, ``counts`` (k,)."""
    for k in range(origins.shape[0]):
        counts[k] = cast_ray(
            tree, cache, bodies, kinds, hulls, vec3(origins, k, 0), vec3(directions, k, 0), reach, mask, hits[k],
            found[k],
        )  # fmt: skip


@entry
def find_in_region(tree, cache, bodies, kinds, hulls, center, half, radius, mask, points, out):
    """Bodies that overlap a ball, or where ``radius`` is 0 a box along the world's axes; returns how many.

    ``center`` and ``half`` are rows (1, 3); ``out`` has room for all bodies; ``points`` is scratch, (SCRATCH, 5).
    """
    p = vec3(center, 0, 0)
    if radius > 0.0:
        return overlap_sphere(tree, cache, bodies, kinds, hulls, p, radius, mask, points, out)
    return overlap_box(tree, cache, bodies, kinds, hulls, p, vec3(half, 0, 0), mask, points, out)


@entry
def find_overlaps(tree, cache, bodies, kinds, hulls, i, points, out):
    """Bodies that overlap body i and may meet it; returns how many. ``out`` and ``points`` as above."""
    found = 0
    if kinds[i, SHAPE] != PLANE and tree.leaf[i] == NONE:
        return found
    near = cache.lists[FOUND]
    for k in range(candidates(tree, cache, kinds, i, near)):
        j = near[k]
        if j != i and may_meet(kinds, i, j) and bodies_overlap(bodies, kinds, hulls, i, j, points):
            out[found] = j
            found += 1
    return found

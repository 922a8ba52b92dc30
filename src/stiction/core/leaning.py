"""What bodies have turned because the contacts that they stand on give way: forces know nothing of it.

Soft contacts sink, and where their loads are uneven, bodies lean. With a lean go the places where forces act, and the
weight then bends a stack as it bends a column that is too slender: twenty-two cubes upon each other stand, and
twenty-three buckle. Rigid bodies do not. A body whose face sticks to one that does not turn cannot turn either, however
its loads are spread. What it has turned since is its lean, and its forces act where they would without it. So loads are
those of rigid bodies, and nothing feeds a lean.

A body STANDS if a face of it sticks, with loads that three points at least have a part in, to one below that stands, or
to one that nothing turns. With two points it may tip. "Below" is told by the centres of mass, so that nothing stands on
itself by whatever way around. Who stands is told from the step before: it goes up a stack by a body a step, and so does
that what is below stands no more.
"""

from __future__ import annotations

from stiction.core import soft_rows as s
from stiction.core.jit import jit
from stiction.core.lanes import gather
from stiction.core.state import DYNAMIC, KINEMATIC, LEAN, MOBILITY, STANDS, W_START, W
from stiction.core.vec import Vec3, cross, dot, put_vec3, vec3

MOST_LEAN = 0.05
"""rad; what has turned by more does not stand."""


@jit
def begin_lean(bodies, kinds, i, aux, up, x):
    """Enter what a step has to know of body i with its centre at x; ``up``: against gravity, or zero."""
    r = i + 1
    put_vec3(aux, r, s.AUX_LEAN, vec3(bodies, i, LEAN))
    aux[r, s.AUX_HEIGHT], aux[r, s.AUX_HELD] = dot(up, x), 0.0
    if kinds[i, MOBILITY] == DYNAMIC:
        aux[r, s.AUX_STANDS] = bodies[i, STANDS]
        return
    w = vec3(bodies, i, W)
    turning = dot(w, w)
    if kinds[i, MOBILITY] == KINEMATIC:
        w = vec3(bodies, i, W_START)
        turning += dot(w, w)
    aux[r, s.AUX_STANDS] = 1.0 if turning == 0.0 else 0.0


@jit
def without_lean(aux, index, i, C, arm):
    """The arms that the eight bodies in row i of ``index`` would have without their leans, in the frame whose axes are
    the rows of C."""
    g = gather(aux, index, i, s.AUX_WORK)
    return arm - cross(C @ Vec3(g[1], g[2], g[3]), arm)


@jit
def hold(aux, a, b):
    """Note that the bodies of rows a and b stick to each other with whole faces."""
    moves_a, moves_b = aux[a, s.AUX_MASS] > 0.0, aux[b, s.AUX_MASS] > 0.0
    if moves_b and aux[a, s.AUX_STANDS] > 0.0 and (not moves_a or aux[a, s.AUX_HEIGHT] < aux[b, s.AUX_HEIGHT]):
        aux[b, s.AUX_HELD] = 1.0
    if moves_a and aux[b, s.AUX_STANDS] > 0.0 and (not moves_b or aux[b, s.AUX_HEIGHT] < aux[a, s.AUX_HEIGHT]):
        aux[a, s.AUX_HELD] = 1.0


@jit
def keep_lean(bodies, i, aux, angle):
    """Add the rotation vector of a step, rad, to the lean of body i if it stands."""
    lean = vec3(bodies, i, LEAN) + angle
    if aux[i + 1, s.AUX_HELD] > 0.0 and dot(lean, lean) < MOST_LEAN * MOST_LEAN:
        put_vec3(bodies, i, LEAN, lean)
        bodies[i, STANDS] = 1.0
    else:
        forget_lean(bodies, i)


@jit
def forget_lean(bodies, i):
    """Body i does not stand."""
    if bodies[i, STANDS] > 0.0:
        put_vec3(bodies, i, LEAN, Vec3(0.0, 0.0, 0.0))
        bodies[i, STANDS] = 0.0

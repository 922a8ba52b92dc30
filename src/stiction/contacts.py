"""The structured array in which contact points are reported."""

from __future__ import annotations

import numpy as np

CONTACT_DTYPE = np.dtype(
    [
        ("body_a", np.int32),
        ("body_b", np.int32),
        ("point", np.float64, (3,)),
        ("normal", np.float64, (3,)),
        ("separation", np.float64),
        ("normal_impulse", np.float64),
        ("friction_impulse", np.float64, (3,)),
        ("sticking", np.bool_),
    ]
)
"""A row a contact point: indices of the bodies (a < b), point half way between the surfaces (m), normal from a to b,
separation (m, negative when they overlap), impulses of the last step that act on b (N s; on a the opposite), and
whether the point sticks."""

"""Instances: one mesh at many places, which viser sends and draws as a whole."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction.view.meshes import Mesh

if TYPE_CHECKING:
    from viser import BatchedMeshHandle, ViserServer

Array = NDArray[np.float64]


def add_instances(
    server: ViserServer,
    name: str,
    mesh: Mesh,
    positions: Array,
    orientations: Array | None = None,
    *,
    colors: NDArray[np.uint8],
    cast_shadow: bool = False,
    opacity: float | None = None,
    visible: bool = True,
    **pose: Any,
) -> BatchedMeshHandle:
    """Put up a mesh at k places; returns viser's handle.

    Args:
        server: viser's.
        name: of the node in its tree.
        mesh: what each of them looks like.
        positions: (k, 3), m. orientations: (k, 4) quaternions, w first; as the mesh is if left out.
        colors: (k, 3), or (3,) for all of them, see :func:`stiction.view.style.surface`.
        cast_shadow: whether they do.
        opacity: 1 if left out.
        visible: at first.
        pose: ``position`` (3,) and ``wxyz`` (4,) of the node itself.
    """
    return server.scene.add_batched_meshes_simple(
        name,
        mesh.vertices,
        mesh.faces,
        upright(len(positions)) if orientations is None else orientations,
        positions,
        batched_colors=colors,
        lod="off",  # none of them coarser where it is far away
        cast_shadow=cast_shadow,
        opacity=opacity,
        visible=visible,
        **pose,
    )


def upright(count: int) -> NDArray[np.float32]:
    """Orientations (count, 4) of what is not turned."""
    return np.tile(np.array([1.0, 0.0, 0.0, 0.0], np.float32), (count, 1))

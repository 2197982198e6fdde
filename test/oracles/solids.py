"""Solids that are unions of boxes: what is known of them from the kernels of convex pairs alone.

The distance from a union is the least of those from its parts. A body that overlaps must move at
least as far as the deepest part asks for, and is out when every part is apart.
"""

import functools

import numpy as np
from oracles.forms import kernel_form, row_of

from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from truth.bodies import grids
from truth.references.meshes import parts_of

CELLS = {'L': grids.L, 'U': grids.U, 'ring': grids.RING}


def surface_of(name, cuts=1):
    """The surface of a union of unit cells, each side cut into ``cuts`` by ``cuts`` squares."""
    return MeshData(*grids.surface(CELLS[name], cuts=cuts))


@functools.cache
def solid(name, scale=1.0, cuts=1):
    """A solid with its corner at the origin."""
    return grids.solid(CELLS[name], cuts=cuts, scale=scale)


def parts_gap(A, B):
    """The least signed distance of the parts, and how far off it may be.

    Positive: the distance of A and B. Negative: they must move at least that far apart.
    """
    least, error = np.inf, 0.0
    for a in parts_of(A):
        for b in parts_of(B):
            out = row_of(*sorted((a, b), key=lambda part: kernel_form(part)[0]))
            if out[calling.DISTANCE] < least:
                least, error = out[calling.DISTANCE], out[calling.ERROR_BOUND]
    return least, error

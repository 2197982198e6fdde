"""Bodies as kernels have them, by type numbers and parameters: asked of kernels, and of the truth.

The numbers are half sizes; of a hull, and of a solid, they are what it is packed as.
"""

import numpy as np
from oracles.kernel_calls import call_for_pair

from drake_geom_ros.cross_check.bodies import COUNTS, NUMBERS, PRIMITIVES, Body
from drake_geom_ros.geometry import MeshData
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    ALL_ROWS,
    ROW_OF_TYPES,
    TYPE_COUNT,
)
from drake_geom_ros.geometry.meshes._solids import solid_of
from truth.references import convex

KINDS = {NUMBERS[kind]: kind for kind in (*PRIMITIVES, 'Convex')}
PARAMETERS = {NUMBERS[kind]: count for kind, count in COUNTS.items()}
ALIGNED, HERE = np.eye(3), np.zeros(3)


def body(form, R=ALIGNED, p=HERE):
    """Return the body of a form, (type number, parameters), at a pose."""
    kind, size = KINDS[form[0]], np.asarray(form[1], dtype=float)
    if kind == 'Convex':
        vertices = size[1 : 1 + 3 * int(size[0])].reshape(3, -1).T
        return Body(kind, vertices, R, np.array(p, dtype=float))
    return Body.of_halves(kind, size).placed(R, p)


def hull_of(vertices):
    """Return the parameters of a hull by its vertices (n, 3)."""
    return Body('Convex', vertices).form[1]


def kernel_form(body):
    """Return the type number and the parameters that kernels take; a convex Solid is its hull."""
    if body.kind == 'Solid':
        return solid_of(MeshData(body.size, body.triangles), (1.0, 1.0, 1.0))
    return body.form


def in_order(*bodies):
    """Return bodies in the order in which the pair table has their types."""
    return sorted(bodies, key=lambda body: kernel_form(body)[0])


def row_of(a, b, tolerance=1e-9, cutoff=np.inf, hint=(0.0, 0.0, 0.0), kernel=None):
    """Return the result row of two bodies, the lower type first; by the pair table's kernel."""
    (kind_A, shape_A), (kind_B, shape_B) = kernel_form(a), kernel_form(b)
    if kernel is None:
        number = ROW_OF_TYPES[kind_A * TYPE_COUNT + kind_B]
        assert number >= 0, f'no kernel answers for types {kind_A} and {kind_B} in this order'
        kernel = ALL_ROWS[number].load_kernel()
    out = np.full(calling.PAIR_WIDTH, np.nan)
    out[calling.NORMAL : calling.NORMAL + 3] = hint
    asked = b.p - a.p, tolerance, cutoff, out
    call_for_pair(kernel, kind_A, shape_A, a.R, kind_B, shape_B, b.R, *asked)
    assert np.isfinite(out).all(), (a, b, out)
    return out


def signed_distance(form_A, X_WA, form_B, X_WB):
    """Return phi [m] and a unit direction (3,) out of A that attains it; a pose is (R, p)."""
    return convex.signed_distance(body(form_A, *X_WA), body(form_B, *X_WB))

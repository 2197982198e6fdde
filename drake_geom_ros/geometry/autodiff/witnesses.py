"""Derivatives of nearest points and normals, implicitly from the curvature of the surfaces.

Let a and b be the nearest points of A and B, n = nhat_BA and phi the distance, so that
``a - b = phi n``; n is normal to both surfaces. While the bodies move, a follows A's material and
slides over its surface: by M_A times the rotation of -n relative to A, where M_A are the radii of
curvature. On an edge or a face it also slides freely along it, while n stays at right angles to
it. The same holds for b. Together these are linear equations for the rotation of n and for the
sliding, in two axes at right angles to n::

    (phi + M_A + M_B) dn - D_A s_A + D_B s_B = v_A - v_B + M_A (w_A x n) + M_B (w_B x n)
    D_A^T dn = D_A^T (w_A x n),   D_B^T dn = D_B^T (w_B x n)

with the material velocities v at a and b, the angular velocities w, and the free directions D of
edges and faces (``_proximity.kernels.features`` computes M and D).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.shapes.features import FACE, SEGMENT
from drake_geom_ros.math.array_types import Floats


class Side(NamedTuple):
    """Curvature and velocities of one body at its nearest point, in the two axes."""

    D: Floats  # (2, f) free directions of its edge or face
    M: Floats  # (2, 2) [m] radii of curvature
    turn: Floats  # (2, n) w x n
    velocity: Floats  # (2, n) of its material, in the axes


class PoseDerivatives(NamedTuple):
    """Derivatives by n variables, in World."""

    nhat: Floats  # (3, n) of the normal
    of_a: Floats  # (3, n) of a relative to A's material
    of_b: Floats  # (3, n) of b relative to B's material


def side_of(feature: Floats, U: Floats, n: Floats, w: Floats, v: Floats) -> Side:
    """Return a side, from its feature (6,), axes U (3, 2), and material velocities (3, n)."""
    freedom, du, dv, uu, uv, vv = feature
    D = np.zeros((2, 0))
    if freedom == SEGMENT:
        D = np.array([[du], [dv]])
    elif freedom == FACE:
        D = np.eye(2)
    M = np.array([[uu, uv], [uv, vv]])
    return Side(D, M, U.T @ np.cross(w, n[:, None], axis=0), U.T @ v)


def motion_of(phi: float, n: Floats, U: Floats, A: Side, B: Side) -> PoseDerivatives:
    """Return the derivatives of the normal and the nearest points.

    Raises numpy.linalg.LinAlgError if the equations have no unique solution.
    """
    f, g = A.D.shape[1], B.D.shape[1]
    system = np.zeros((2 + f + g, 2 + f + g))
    system[:2, :2] = phi * np.eye(2) + A.M + B.M
    system[:2, 2 : 2 + f], system[:2, 2 + f :] = -A.D, B.D
    system[2 : 2 + f, :2], system[2 + f :, :2] = A.D.T, B.D.T
    right = np.concatenate(
        (
            A.velocity - B.velocity + A.M @ A.turn + B.M @ B.turn,
            A.D.T @ A.turn,
            B.D.T @ B.turn,
        )
    )
    solved = np.linalg.solve(system, right)
    dn, s_A, s_B = solved[:2], solved[2 : 2 + f], solved[2 + f :]
    slip_A = -A.M @ (dn - A.turn) + A.D @ s_A
    slip_B = B.M @ (dn - B.turn) + B.D @ s_B
    return PoseDerivatives(U @ dn, U @ slip_A, U @ slip_B)

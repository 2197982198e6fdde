"""Bounds of the rounding errors of posed bodies, relative to their exact poses.

The *exact poses* are products of real numbers along the chain of frames: positions as they are in
float64; for a quaternion the rotation of its float64 numbers, normalised exactly; for a matrix the
rotation nearest to it (accepted matrices are orthogonal within rounding, see
``math.rotations.orthogonal``). World computes R and p in float64 and, beside them, two bounds of
their errors (Frobenius and Euclidean norms):

- ``turn`` [-] of R. A rotation that is read is off by ROTATION_TAKEN, a product adds
  ROTATION_STEP, and errors add up: |R S - R' S'| <= |R - R'| + |S - S'| for rotations. Making R
  orthogonal adds rounding only: R = R' (I + E) becomes R' (I + skew(E)), to first order, which is
  no farther from R'. A matrix of zeros and ones, such as the identity or a quarter turn, has no
  error and adds none in a product.
- ``shift`` [m] of p. In p_WC = p_WB + R_WB p_BC the shift of B remains, its turn has p_BC as the
  lever arm, and the sum rounds: ``shift + turn |p_BC| + POSITION_STEP (|p_WB| + |p_BC|)``.

They become one number per geometry, the radius ``shift + turn r`` [m], with r its outer radius (0
for a ball, which no turn moves). No point of the exact body is farther than this from the computed
body, and vice versa. So its support function, and its signed distance to anything, are off by no
more. POSITION_STEP includes the rounding of subtracting two positions.

A half space has no outer radius. Its number is the shift of its origin. Its turn, called tilt, is
multiplied by the distance of the other body, because the height n . (a - p) of a point a over the
plane through p with the normal n is off by at most ``shift + turn |a - p|``.

Source of the constants: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., chapter
3. There gamma_n = n u / (1 - n u), u = EPS / 2, and an inner product of n terms is off by gamma_n
times that of the moduli (3.5). Lengths are sums of moduli here, which no square overflows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.arrays import unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    POSITION_STEP,
    ROTATION_STEP,
    ROTATION_TAKEN,
)

Floats = NDArray[np.float64]

# Columns of the roundings of a frame, or of a pose that is read.
TURN = 0  # [-]
SHIFT = 1  # [m]
# Columns of the roundings of a posed geometry.
RADIUS = 0  # [m] no point of the exact body is farther than this from the computed one
TILT = 1  # [-] the turn of a half space, 0 for other shapes


def taken_roundings(R_PFs: Floats) -> Floats:
    """Return turn [-] and shift [m] (n, 2) of poses that are read, from rotations (n, 3, 3).

    The rounding of a product with the pose is included.
    """
    exact = ((R_PFs == 0.0) | (np.abs(R_PFs) == 1.0)).all(axis=(1, 2))
    roundings = np.zeros((len(R_PFs), 2))
    roundings[~exact, TURN] = ROTATION_TAKEN + ROTATION_STEP
    return roundings


@inlined
def length_of(ps: Floats, k: int) -> float:
    """Return the sum of the moduli of row k, an upper bound of its length [m]."""
    return abs(ps[k, 0]) + abs(ps[k, 1]) + abs(ps[k, 2])


@inlined
def shift_of(turn: float, shift: float, reach: float, length: float) -> float:
    """Return the shift [m] of C in ``p_WC = p_WB + R_WB p_BC``.

    ``turn`` [-], ``shift`` [m] and ``reach`` = |p_WB| [m] are of B; ``length`` is |p_BC| [m].
    """
    return shift + turn * length + POSITION_STEP * (reach + length)


@inlined
def is_exact(R_PFs: Floats, f: int) -> bool:
    """Return whether the rotation in row f is made of zeros and ones."""
    f = unsigned(f)
    first = abs(R_PFs[f, 0, 0])
    exact = first == 0.0 or first == 1.0  # this alone decides in most cases
    if exact:
        for i in range(3):
            for j in range(3):
                r = abs(R_PFs[f, i, j])
                exact &= r == 0.0 or r == 1.0
    return exact


@inlined
def make_orthogonal(Rs: Floats, f: int) -> None:
    """Replace the matrix in row f, orthogonal within rounding, by the rotation nearest to it.

    ``R - R (R^T R - I) / 2``: a step of Newton and Schulz, as in ``math.rotations.orthogonal``.
    Without this step the defects of a chain would add up, but kernels assume rotations.
    """
    f = unsigned(f)
    a, b, c = Rs[f, 0, 0], Rs[f, 1, 0], Rs[f, 2, 0]
    p, q, r = Rs[f, 0, 1], Rs[f, 1, 1], Rs[f, 2, 1]
    x, y, z = Rs[f, 0, 2], Rs[f, 1, 2], Rs[f, 2, 2]
    e_xx = 0.5 * (a * a + b * b + c * c - 1.0)
    e_yy = 0.5 * (p * p + q * q + r * r - 1.0)
    e_zz = 0.5 * (x * x + y * y + z * z - 1.0)
    e_xy = 0.5 * (a * p + b * q + c * r)
    e_xz = 0.5 * (a * x + b * y + c * z)
    e_yz = 0.5 * (p * x + q * y + r * z)
    for i in range(3):
        u, v, w = Rs[f, i, 0], Rs[f, i, 1], Rs[f, i, 2]
        Rs[f, i, 0] = u - (u * e_xx + v * e_xy + w * e_xz)
        Rs[f, i, 1] = v - (u * e_xy + v * e_yy + w * e_yz)
        Rs[f, i, 2] = w - (u * e_xz + v * e_yz + w * e_zz)

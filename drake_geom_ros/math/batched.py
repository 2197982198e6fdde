"""Conversions of many poses at once, as arrays, without Python work per pose.

A pose is either a row of seven numbers, ``x y z qx qy qz qw`` [m, -], or a pair of arrays:
rotation matrices R (n, 3, 3) and positions p (n, 3) [m]. ``X_AB = (R_AB, p_AB)`` takes a point
from B's axes to A's: ``p_AQ = R_AB p_BQ + p_AB``.

    >>> Rs, ps = matrices_from_poses([[1, 2, 3, 0, 0, 0, 1]])
    >>> poses_from_matrices(Rs, ps)
    array([[1., 2., 3., 0., 0., 0., 1.]])
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import QUATERNION_NORM


def matrices_from_poses(poses: ArrayLike, what: str = 'poses') -> tuple[Floats, Floats]:
    """Return R (n, 3, 3) and p (n, 3) [m] of ``poses`` (n, 7), x y z qx qy qz qw.

    Quaternions are normalised. Raises RuntimeError, with the first bad row as ``what[row]``, for
    another shape, a number that is not finite, or a quaternion whose length differs from 1 by more
    than ``QUATERNION_NORM``.
    """
    rows = checked_rows(poses, 7, what, 'x y z qx qy qz qw')
    return rotations_from_quaternions(rows[:, 3:], what), rows[:, :3].copy()


def are_poses(poses: ArrayLike) -> NDArray[np.bool_]:
    """Return the mask (n,) of ``poses`` (n, 7) that ``matrices_from_poses`` accepts."""
    rows = np.asarray(poses, dtype=np.float64)
    with np.errstate(over='ignore', invalid='ignore'):
        off = np.abs(np.linalg.norm(rows[:, 3:], axis=1) - 1.0)
    return np.asarray(np.isfinite(rows).all(axis=1) & (off <= QUATERNION_NORM))


def poses_from_matrices(Rs: ArrayLike, ps: ArrayLike) -> Floats:
    """Return poses (n, 7), x y z qx qy qz qw, of R (n, 3, 3) and p (n, 3) [m]; qw >= 0."""
    return np.hstack((np.asarray(ps, dtype=np.float64), quaternions_from_rotations(Rs)))


def rotations_from_quaternions(qxqyqzqw: ArrayLike, what: str = 'quaternions') -> Floats:
    """Return R (n, 3, 3) of quaternions (n, 4), which are normalised first.

    Raises RuntimeError as ``matrices_from_poses`` does. Formula (Euler-Rodrigues):
    R = I + s w [v]x + s [v]x [v]x for q = (v, w), s = 2 / |q|^2.
    """
    quaternions = checked_rows(qxqyqzqw, 4, what, 'qx qy qz qw')
    norms = np.linalg.norm(quaternions, axis=1)
    bad = np.flatnonzero(np.abs(norms - 1.0) > QUATERNION_NORM)
    if bad.size:
        k = bad[0]
        raise RuntimeError(
            f'{what}[{k}]: the quaternion {quaternions[k].tolist()} has norm {norms[k]:.6g}; '
            f'allowed is 1 +- {QUATERNION_NORM:g}, in the order qx qy qz qw'
        )
    x, y, z, w = quaternions.T
    # Normalising the components first would round twice.
    s = 2.0 / (x * x + y * y + (z * z + w * w))
    Rs = np.empty((len(quaternions), 3, 3))
    Rs[:, 0, 0] = 1.0 - s * (y * y + z * z)
    Rs[:, 1, 1] = 1.0 - s * (x * x + z * z)
    Rs[:, 2, 2] = 1.0 - s * (x * x + y * y)
    Rs[:, 0, 1], Rs[:, 1, 0] = s * (x * y - w * z), s * (x * y + w * z)
    Rs[:, 0, 2], Rs[:, 2, 0] = s * (x * z + w * y), s * (x * z - w * y)
    Rs[:, 1, 2], Rs[:, 2, 1] = s * (y * z - w * x), s * (y * z + w * x)
    return Rs


def slerp(q0: ArrayLike, q1: ArrayLike, u: ArrayLike) -> Floats:
    """Return unit quaternions (..., 4) on the arcs from q0 to q1 (..., 4) at u (..., 1) in [0, 1].

    Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985. sin(u a) / sin(a) is
    computed as a quotient of sinc, without a special case for a = 0. Requires q0 . q1 >= 0.
    """
    q0, q1, u = np.asarray(q0, float), np.asarray(q1, float), np.asarray(u, float)
    chord = np.linalg.norm(q1 - q0, axis=-1, keepdims=True)
    turns = 2.0 * np.arctan2(chord, np.linalg.norm(q1 + q0, axis=-1, keepdims=True)) / np.pi

    def weight(v: Floats) -> Floats:
        return np.asarray(v * np.sinc(v * turns) / np.sinc(turns))

    q = weight(1.0 - u) * q0 + weight(u) * q1
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def quaternions_from_rotations(Rs: ArrayLike) -> Floats:
    """Return unit quaternions (n, 4), qx qy qz qw with qw >= 0, of R (n, 3, 3).

    The four products 4 q_k q are rows of linear sums of R's elements; the row of the largest q_k
    loses no digits (Shepperd, J. Guidance and Control 1(3), 1978).
    """
    R = np.asarray(Rs, dtype=np.float64)
    xx, yy, zz = R[:, 0, 0], R[:, 1, 1], R[:, 2, 2]
    xy, xz, yz = R[:, 0, 1] + R[:, 1, 0], R[:, 0, 2] + R[:, 2, 0], R[:, 1, 2] + R[:, 2, 1]
    wx, wy, wz = R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]
    products = np.empty((len(R), 4, 4))
    products[:, 0, 0], products[:, 1, 1] = 1.0 + xx - yy - zz, 1.0 - xx + yy - zz
    products[:, 2, 2], products[:, 3, 3] = 1.0 - xx - yy + zz, 1.0 + xx + yy + zz
    mixed = (((0, 1), xy), ((0, 2), xz), ((1, 2), yz), ((0, 3), wx), ((1, 3), wy), ((2, 3), wz))
    for (row, column), sums in mixed:
        products[:, row, column] = products[:, column, row] = sums
    largest = np.argmax(np.diagonal(products, axis1=1, axis2=2), axis=1)
    rows = products[np.arange(len(R)), largest]
    quaternions: Floats = rows / np.linalg.norm(rows, axis=1)[:, None]
    quaternions[quaternions[:, 3] < 0.0] *= -1.0
    return quaternions


def compose(R_ABs: Floats, p_ABs: Floats, R_BCs: Floats, p_BCs: Floats) -> tuple[Floats, Floats]:
    """Return R_AC (n, 3, 3) and p_AC (n, 3) of X_AC = X_AB X_BC; (3, 3) and (3,) broadcast."""
    return R_ABs @ R_BCs, p_ABs + np.einsum('...ij,...j->...i', R_ABs, p_BCs)


def checked_rows(values: ArrayLike, width: int, what: str, layout: str) -> Floats:
    """Return ``values`` as floats (n, width); RuntimeError for another shape or a NaN or inf."""
    try:
        rows = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RuntimeError(f'{what}: not an array of numbers (n, {width}): {error}') from None
    if rows.size == 0 and rows.ndim <= 2:
        rows = rows.reshape(0, width)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise RuntimeError(f'{what}: shape {rows.shape} is not (n, {width}), {layout}')
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if bad.size:
        raise RuntimeError(f'{what}[{bad[0]}]: {rows[bad[0]].tolist()} is not finite')
    return rows

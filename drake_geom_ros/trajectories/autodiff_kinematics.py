"""Forward kinematics of AutoDiffXd: the values of ``Kinematics``, with derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.autodiffutils.arrays import autodiff_array, derivatives_of, values_of
from drake_geom_ros.math.array_types import Floats


def is_of_autodiff(*arrays: Any) -> bool:
    """Return whether any array has objects, as arrays of AutoDiffXd have."""
    return any(np.asarray(array).dtype == object for array in arrays if array is not None)


def values_and_rates(q: Any, count: int) -> tuple[Floats, Floats]:
    """Return the values (count,) and derivatives (count, n) of joint values of AutoDiffXd.

    Raises ValueError for more than one configuration.
    """
    if np.shape(q) != (count,):
        raise ValueError(
            f'q of AutoDiffXd must have the shape ({count},), one configuration; got '
            f'{np.shape(q)}. Of a column take [:, 0]; for many configurations take their values, '
            'and derivatives by link_jacobians'
        )
    return values_of(q), derivatives_of(q)


def transforms(X_WLs: Floats, Js: Floats, rates: Floats) -> NDArray[np.object_]:
    """Return X_WL (links, 4, 4) of AutoDiffXd, from Jacobians (links, 6, joints).

    ``rates`` (joints, n) are the derivatives of the joint values. A rotation changes by its
    angular velocity: dR = [w]x R.
    """
    velocities = np.einsum('lij,jn->lin', Js, rates)
    turns, shifts = velocities[:, :3], velocities[:, 3:]
    derivatives = np.zeros((*X_WLs.shape, rates.shape[1]))
    for column in range(3):
        axis = X_WLs[:, :3, column, None]
        derivatives[:, :3, column] = np.cross(turns, axis, axis=1)
    derivatives[:, :3, 3] = shifts
    return autodiff_array(X_WLs, derivatives)
